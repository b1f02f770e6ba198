//! Changing the container and not the content: raw to zstd and back.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use bvhc_core::cache::parts::{Block, Encoder, Fault, is_known_codec, is_understood};

use super::check::Limits;
use super::intact::sound_sequence;
use super::sealed::{Codec, Form, Piece, Sealed, WriteSummary, store_delta};
use super::writer::{WriteOptions, piece_of_compact};
use super::{
    Cache, CacheError, Head, KINDS, MIN_MINOR, OpenOptions, SEQUENCE_MIN_MINOR, Sequence, Validation, section_flags,
};
use super::{Header, SectionEntry, SectionKind, atomic, keys, tree_flags};
use crate::exec::Executor;
use crate::trace::wide::CompactTrees;

/// The sections of compact trees, in the order of the file.
const COMPACT: [SectionKind; 3] = [SectionKind::CROW, SectionKind::CNOD, SectionKind::CREF];

/// What a conversion did.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConvertSummary {
    /// The new file.
    pub written: WriteSummary,
    /// Sections that could not be kept: unknown to this version and not marked COPY_SAFE.
    pub dropped: Vec<SectionKind>,
}

/// What a conversion changes, and what it leaves out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConvertOptions {
    /// Codec and check of the new file.
    pub write: WriteOptions,
    /// Leave out every section that this version does not know, even where it may be copied.
    pub strip_unknown: bool,
    /// Whether the new file has compact trees, made anew; `None`: what the old one has. They are not part of the content. No sequence has them.
    pub compact: Option<bool>,
    /// Leave out META: the file is smaller and says less; it is never taken for up to date again.
    pub drop_meta: bool,
}

/// Write the content of `from` to `to` with another codec, in one step, with the same `content_id`.
///
/// `from` and `to` may be the same file. Every section is read once and its hashes are checked; with [`WriteOptions::check`], so is
/// everything that the sections say, but for what is left out.
///
/// # Errors
/// Where `from` cannot be opened, breaks a rule, or `to` cannot be written, or where a section that would have to be left out is part of
/// the content.
pub fn convert(
    from: &Path,
    to: &Path,
    open: &OpenOptions,
    options: &ConvertOptions,
    exec: &Executor,
) -> Result<ConvertSummary, CacheError> {
    if Head::read(from, open)?.header.has(tree_flags::SEQUENCE) {
        return convert_sequence(from, to, open, options, exec);
    }
    let validation = open.validation.max(Validation::Hash);
    let cache = Cache::open_on(from, &OpenOptions { validation, ..*open }, exec)?;
    let name = from.display().to_string();
    if options.write.check {
        let limits = Limits { max_issues: 1, ..Limits::default() };
        let of_compact = COMPACT.into_iter().filter(|_| options.compact.is_some());
        let left_out: Vec<_> = options.drop_meta.then_some(SectionKind::META).into_iter().chain(of_compact).collect();
        let report = cache.check_without(&left_out, &limits, exec);
        Fault::of_report(&report).map_err(|fault| fault.of(&name))?;
    }
    let compact = match options.compact {
        Some(true) => Some(
            CompactTrees::of(&cache.view())
                .map_err(|malformed| CacheError::Unwritable { name: name.clone(), detail: malformed.to_string() })?,
        ),
        _ => None,
    };
    let stays = |entry: &SectionEntry| options.compact.is_none() || !COMPACT.contains(&entry.kind);
    let sections = cache.sections().iter().enumerate().filter(|(_, entry)| stays(entry));
    let mut sections = sections.map(|(i, entry)| Section {
        entry,
        data: cache.section_bytes(i).map(Cow::Borrowed),
        stored: cache.stored_bytes(i),
        packed: None,
    });
    let (sealed, dropped) = repack(cache.header(), &mut sections, compact.as_ref(), &name, options, exec)?;
    atomic::replace(to, |file| sealed.write_to(file))?;
    Ok(ConvertSummary { written: sealed.summary(), dropped })
}

/// The same for a file of many frames. What it decodes to is held in memory.
fn convert_sequence(
    from: &Path,
    to: &Path,
    open: &OpenOptions,
    options: &ConvertOptions,
    exec: &Executor,
) -> Result<ConvertSummary, CacheError> {
    let name = from.display().to_string();
    if options.compact == Some(true) {
        return Err(CacheError::Unwritable { name, detail: "a sequence has no compact trees".into() });
    }
    if options.write.check {
        sound_sequence(from, open, exec)?;
    }
    let sequence = Sequence::open_on(from, &OpenOptions { validation: Validation::Hash, ..*open }, exec)?;
    let all = 0..sequence.sections().len();
    let data = all.map(|i| sequence.section_bytes(i, exec)).collect::<Result<Vec<_>, CacheError>>()?;
    let mut packed = match options.write.codec {
        Codec::Compact { level } => {
            pack_blocks(&sequence, &data, level, exec).map_err(CacheError::io("compress", to))?
        }
        _ => BTreeMap::new(),
    };
    let mut sections = sequence.sections().iter().zip(data).enumerate().map(|(i, (entry, data))| Section {
        entry,
        data,
        stored: sequence.stored_bytes(i),
        packed: packed.remove(&i),
    });
    let (sealed, dropped) = repack(sequence.header(), &mut sections, None, &name, options, exec)?;
    atomic::replace(to, |file| sealed.write_to(std::io::BufWriter::new(file)))?;
    Ok(ConvertSummary { written: sealed.summary(), dropped })
}

/// The sections of the blocks as differences, by their indices in the table.
fn pack_blocks(
    sequence: &Sequence,
    data: &[Option<Cow<'_, [u8]>>],
    level: i32,
    exec: &Executor,
) -> io::Result<BTreeMap<usize, Vec<u8>>> {
    let entries = sequence.sections();
    let numbered = |kind: SectionKind, ordinal: usize| {
        entries.iter().position(|entry| entry.kind == kind && entry.ordinal as usize == ordinal)
    };
    let (mut encoder, mut packed) = (Encoder::new(level), BTreeMap::new());
    for block in 0..sequence.block_count() {
        let places = [SectionKind::NODE, SectionKind::VPOS].map(|kind| numbered(kind, block));
        let [Some(nodes), Some(vertices)] = places else { continue };
        let bytes = |index: usize| data[index].as_deref().unwrap_or_default();
        let rows = sequence.poses();
        let until = |block: usize| rows.partition_point(|pose| (pose.block as usize) < block);
        let block = Block {
            poses: &rows[until(block)..until(block + 1)],
            nodes: bytemuck::cast_slice(bytes(nodes)),
            vertices: bytemuck::cast_slice(bytes(vertices)),
        };
        let both = encoder.block(sequence.topologies(), sequence.indexed_triangles(), block, exec)?;
        packed.extend([nodes, vertices].into_iter().zip(both).filter_map(|(index, packed)| Some((index, packed?))));
    }
    Ok(packed)
}

/// A section of the file that is converted.
struct Section<'a> {
    entry: &'a SectionEntry,
    /// Decoded, where that can be had.
    data: Option<Cow<'a, [u8]>>,
    stored: &'a [u8],
    /// As differences.
    packed: Option<Vec<u8>>,
}

fn repack<'a>(
    header: &Header,
    sections: &mut dyn Iterator<Item = Section<'a>>,
    compact: Option<&'a CompactTrees>,
    name: &str,
    options: &ConvertOptions,
    exec: &Executor,
) -> Result<(Sealed<'a>, Vec<SectionKind>), CacheError> {
    // Keep what is understood or may be copied unread.
    let (mut pieces, mut dropped) = (Vec::new(), Vec::new());
    for Section { entry, data, stored, packed } in sections {
        let known = is_understood(entry);
        let keep = if entry.kind == SectionKind::META {
            !options.drop_meta && (known || entry.is(section_flags::COPY_SAFE))
        } else {
            known || (entry.is(section_flags::COPY_SAFE) && !options.strip_unknown)
        };
        if !keep {
            dropped.push(entry.kind);
            continue;
        }
        if let (Some(packed), Some(data)) = (packed, &data) {
            let mut entry = *entry;
            store_delta(&mut entry, data, &packed, exec);
            pieces.push(Piece { entry, data: Cow::from(packed).into(), form: Form::Stored });
            continue;
        }
        pieces.push(match data.filter(|_| is_known_codec(entry)) {
            Some(data) => Piece { entry: *entry, data: data.into(), form: Form::Decoded },
            None => Piece { entry: *entry, data: stored.into(), form: Form::Stored },
        });
    }

    if let Some(trees) = compact {
        // They stand where the writer puts them.
        let rank = |kind: SectionKind| KINDS.iter().position(|rule| rule.kind == kind).unwrap_or(usize::MAX);
        let at = pieces.iter().position(|piece| rank(piece.entry.kind) > rank(COMPACT[0])).unwrap_or(pieces.len());
        pieces.splice(at..at, COMPACT.map(|kind| piece_of_compact(trees, kind)));
    }

    // What was left out must not have been content: compare before anything is written.
    let kept: Vec<_> = pieces.iter().map(|p| p.entry).collect();
    if keys::content_id(&kept) != header.content_id {
        return Err(CacheError::NotCopied { name: name.to_owned(), sections: dropped });
    }
    let header = Header {
        min_minor: if header.has(tree_flags::SEQUENCE) { SEQUENCE_MIN_MINOR } else { MIN_MINOR },
        header_len: Header::LEN as u16,
        section_table_off: Header::LEN as u64,
        features_optional: 0, // none is known, and what an unknown one says may no longer hold
        ..*header
    };
    let sealed =
        Sealed::new(header, pieces, options.write.codec, exec).map_err(CacheError::io("compress", Path::new(name)))?;
    Ok((sealed, dropped))
}

impl Codec {
    /// `raw`, `zstd`, `compact`, or one of these two with `:LEVEL`, a level of 1 to 22.
    pub fn parse(text: &str) -> Option<Codec> {
        let (name, level) = text.split_once(':').map_or((text, None), |(name, level)| (name, Some(level)));
        let level = |usual: i32| match level {
            None => Some(usual),
            Some(level) => level.parse().ok().filter(|level| Codec::LEVELS.contains(level)),
        };
        match name {
            "raw" if level(0) == Some(0) => Some(Codec::Raw),
            "zstd" => level(3).map(|level| Codec::Zstd { level }),
            "compact" => level(9).map(|level| Codec::Compact { level }),
            _ => None,
        }
    }
}
