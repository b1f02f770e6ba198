//! Laying out: sections that are ready become a file, every byte of which is decided before the first one is written.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

use bytemuck::{bytes_of, cast_slice};

use bvhc_core::cache::parts::{pack, pack_triangles};

use super::{DELTA_MIN_MINOR, Header, MIN_MINOR, SectionEntry, SectionKind, keys, minor_of};
use crate::exec::Executor;

/// How sections are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Codec {
    /// As they are: mappable. What a cache is for.
    #[default]
    Raw,
    /// zstd frames of 1 MiB where that saves at least 5 %: smaller to ship, decoded when opened. Levels 1 to 22; 3 is usual.
    Zstd {
        /// Higher is smaller and slower to write; opening takes the same.
        level: i32,
    },
    /// As zstd, and of the poses of a sequence what remains once they were predicted from others: several times smaller, and slower to open. A still
    /// file has nothing that is stored so.
    Compact {
        /// As that of zstd; 9 is usual.
        level: i32,
    },
}

impl Codec {
    /// The levels of zstd. Outside of them a file is refused, where zstd itself would take the nearest in silence.
    pub const LEVELS: std::ops::RangeInclusive<i32> = 1..=22;

    /// The level of zstd; `None` where nothing is packed.
    pub fn level(self) -> Option<i32> {
        match self {
            Codec::Raw => None,
            Codec::Zstd { level } | Codec::Compact { level } => Some(level),
        }
    }
}

/// What was written.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WriteSummary {
    /// As it stands in the file, `file_id` included.
    pub header: Header,
    /// The section table in file order.
    pub sections: Vec<SectionEntry>,
}

/// A section on its way into a file.
pub(super) struct Piece<'a> {
    /// Kind, ordinal, flags, schema and records; for [`Form::Stored`] also codec, `raw_len` and hashes.
    pub entry: SectionEntry,
    pub data: Data<'a>,
    pub form: Form,
}

/// Where a piece's bytes are.
pub(super) enum Data<'a> {
    Memory(Cow<'a, [u8]>),
    /// In a file that was written before, as stored.
    Spooled {
        file: &'a File,
        offset: u64,
        len: u64,
    },
}

impl<'a, T: Into<Cow<'a, [u8]>>> From<T> for Data<'a> {
    fn from(bytes: T) -> Data<'a> {
        Data::Memory(bytes.into())
    }
}

impl Data<'_> {
    fn len(&self) -> u64 {
        match self {
            Data::Memory(bytes) => bytes.len() as u64,
            Data::Spooled { len, .. } => *len,
        }
    }

    fn write_to(&self, sink: &mut impl Write) -> io::Result<()> {
        match self {
            Data::Memory(bytes) => sink.write_all(bytes),
            Data::Spooled { file, offset, len } => {
                let mut file = *file;
                file.seek(SeekFrom::Start(*offset))?;
                let copied = io::copy(&mut file.take(*len), sink)?;
                if copied == *len { Ok(()) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
            }
        }
    }
}

/// What a piece's bytes are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// Decoded: to be packed or not, as the codec says.
    Decoded,
    /// As stored, in a codec that is to be kept.
    Stored,
}

/// Give decoded bytes their codec and their hashes.
pub(super) fn store<'a>(
    entry: &mut SectionEntry,
    data: Cow<'a, [u8]>,
    codec: Codec,
    exec: &Executor,
) -> io::Result<Cow<'a, [u8]>> {
    entry.codec = SectionEntry::RAW;
    entry.raw_len = data.len() as u64;
    entry.raw_hash = exec.hash(&data);
    entry.stored_hash = entry.raw_hash;
    if let (Codec::Compact { level }, SectionKind::TRIX) = (codec, entry.kind) {
        let packed = pack_triangles(&data, level, exec)?;
        if packed.len() < data.len() {
            store_delta(entry, &data, &packed, exec);
            return Ok(packed.into());
        }
    }
    if let Some(level) = codec.level()
        && let Some(packed) = pack(&data, level, exec)?
    {
        entry.codec = SectionEntry::ZSTD;
        entry.stored_hash = exec.hash(&packed);
        return Ok(packed.into());
    }
    Ok(data)
}

/// Give bytes that are packed as differences their codec and their hashes.
pub(super) fn store_delta(entry: &mut SectionEntry, raw: &[u8], packed: &[u8], exec: &Executor) {
    entry.codec = SectionEntry::DELTA;
    (entry.raw_len, entry.stored_len) = (raw.len() as u64, packed.len() as u64);
    entry.raw_hash = exec.hash(raw);
    entry.stored_hash = exec.hash(packed);
}

/// The smallest minor of a reader that needs to know how these sections are stored.
fn min_minor(entries: &[SectionEntry]) -> u16 {
    if entries.iter().any(|entry| entry.codec == SectionEntry::DELTA) { DELTA_MIN_MINOR } else { MIN_MINOR }
}

/// A file whose sections have their places. It is ready to be written once it is signed: then every byte is decided.
pub(super) struct Sealed<'a> {
    pub header: Header,
    pub entries: Vec<SectionEntry>,
    stored: Vec<Data<'a>>,
    /// Numbers of the sections that are stored as they are and not hashed yet.
    unhashed: Vec<usize>,
}

impl<'a> Sealed<'a> {
    /// Pack, hash, lay out and sign.
    pub fn new(header: Header, pieces: Vec<Piece<'a>>, codec: Codec, exec: &Executor) -> io::Result<Sealed<'a>> {
        Ok(Sealed::lay_out(header, pieces, codec, exec)?.signed(exec))
    }

    pub fn signed(mut self, exec: &Executor) -> Sealed<'a> {
        self.sign(self.hashes(exec));
        self
    }

    /// Pack and lay out. What is stored as it is, is not hashed: its place needs only its length.
    pub fn lay_out(
        mut header: Header,
        pieces: Vec<Piece<'a>>,
        codec: Codec,
        exec: &Executor,
    ) -> io::Result<Sealed<'a>> {
        if let Some(level) = codec.level().filter(|level| !Codec::LEVELS.contains(level)) {
            let (least, most) = Codec::LEVELS.into_inner();
            let fact = format!("the level of zstd is {level}, and levels are {least} to {most}");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, fact));
        }
        let (mut entries, mut stored) = (Vec::with_capacity(pieces.len()), Vec::with_capacity(pieces.len()));
        let mut unhashed = Vec::new();
        let mut end = (Header::LEN + pieces.len() * SectionEntry::LEN) as u64;
        for piece in pieces {
            let Piece { mut entry, data, form } = piece;
            let data = match (form, data) {
                (Form::Decoded, Data::Memory(bytes)) if codec == Codec::Raw => {
                    (entry.codec, entry.raw_len) = (SectionEntry::RAW, bytes.len() as u64);
                    unhashed.push(entries.len());
                    Data::Memory(bytes)
                }
                (Form::Decoded, Data::Memory(bytes)) => Data::Memory(store(&mut entry, bytes, codec, exec)?),
                (_, data) => data,
            };
            entry.stored_len = data.len();
            let page = entry.stored_len >= SectionEntry::PAGE_ALIGN_FROM;
            entry.align_log2 = if page { SectionEntry::PAGE_ALIGN_LOG2 } else { SectionEntry::MIN_ALIGN_LOG2 };
            entry.offset = end.next_multiple_of(1 << entry.align_log2);
            end = entry.offset + entry.stored_len;
            entries.push(entry);
            stored.push(data);
        }
        header.file_len = end.next_multiple_of(64);
        header.minor = minor_of(&entries);
        header.min_minor = header.min_minor.max(min_minor(&entries));
        header.section_count = entries.len() as u32;
        Ok(Sealed { header, entries, stored, unhashed })
    }

    /// The hashes that are missing.
    fn hashes(&self, exec: &Executor) -> Vec<[u8; 32]> {
        let hash = |section: &usize| match &self.stored[*section] {
            Data::Memory(bytes) => exec.hash(bytes),
            Data::Spooled { .. } => self.entries[*section].stored_hash,
        };
        self.unhashed.iter().map(hash).collect()
    }

    /// Fill them in, and what identifies the file by them.
    fn sign(&mut self, hashes: Vec<[u8; 32]>) {
        for (section, hash) in std::mem::take(&mut self.unhashed).into_iter().zip(hashes) {
            let entry = &mut self.entries[section];
            (entry.raw_hash, entry.stored_hash) = (hash, hash);
        }
        self.header.content_id = keys::content_id(&self.entries);
        self.header.file_id = keys::file_id(&self.header, &[], cast_slice(&self.entries));
    }

    /// Write a file that is signed.
    pub fn write_to(&self, mut sink: impl Write) -> io::Result<()> {
        self.write_front(&mut sink)?;
        self.write_sections(sink)
    }

    /// Write a file that is not signed yet: it is hashed meanwhile, and its front comes last.
    pub fn sign_and_write(&mut self, mut file: &mut File, exec: &Executor) -> io::Result<()> {
        // Devices go only forward.
        if !file.metadata()?.is_file() {
            self.sign(self.hashes(exec));
            return self.write_to(file);
        }
        let start = file.stream_position()?;
        file.seek(SeekFrom::Start(start + self.front_len()))?;
        let (written, hashes) = exec.join(|| self.write_sections(&mut *file), || self.hashes(exec));
        written?;
        self.sign(hashes);
        file.seek(SeekFrom::Start(start))?;
        self.write_front(&mut file)
    }

    fn front_len(&self) -> u64 {
        (Header::LEN + self.entries.len() * SectionEntry::LEN) as u64
    }

    fn write_front(&self, sink: &mut impl Write) -> io::Result<()> {
        sink.write_all(bytes_of(&self.header))?;
        sink.write_all(cast_slice(&self.entries))
    }

    /// Everything behind the front.
    fn write_sections(&self, mut sink: impl Write) -> io::Result<()> {
        const ZEROS: [u8; 4096] = [0; 4096];
        let mut at = self.front_len();
        for (entry, data) in self.entries.iter().zip(&self.stored) {
            sink.write_all(&ZEROS[..(entry.offset - at) as usize])?; // shorter than a page, as laid out above
            data.write_to(&mut sink)?;
            at = entry.offset + entry.stored_len;
        }
        sink.write_all(&ZEROS[..(self.header.file_len - at) as usize])
    }

    pub fn summary(&self) -> WriteSummary {
        WriteSummary { header: self.header, sections: self.entries.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn a_file_that_is_hashed_while_it_is_written_is_the_one_that_was_hashed_before() {
        let sections: Vec<Vec<u8>> =
            [0usize, 1, 64, 5000, 300_000].iter().map(|len| (0..*len).map(|i| i as u8).collect()).collect();
        let pieces = || {
            let piece = |bytes: &Vec<u8>| {
                let entry = SectionEntry { kind: SectionKind::META, ..SectionEntry::zeroed() };
                Piece { entry, data: bytes.clone().into(), form: Form::Decoded }
            };
            sections.iter().map(piece).collect()
        };
        for exec in [Executor::sequential(), Executor::new(2).unwrap()] {
            let mut before = Vec::new();
            Sealed::new(Header::zeroed(), pieces(), Codec::Raw, &exec).unwrap().write_to(&mut before).unwrap();
            let mut file = tempfile::tempfile().unwrap();
            let mut sealed = Sealed::lay_out(Header::zeroed(), pieces(), Codec::Raw, &exec).unwrap();
            sealed.sign_and_write(&mut file, &exec).unwrap();
            let mut meanwhile = Vec::new();
            file.rewind().unwrap();
            file.read_to_end(&mut meanwhile).unwrap();
            assert_eq!(meanwhile, before);
            assert_eq!(sealed.summary().header.file_len, before.len() as u64);
            assert_eq!(sealed.summary().sections[4].raw_hash, *blake3::hash(&sections[4]).as_bytes());
        }
    }
}
