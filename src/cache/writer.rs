//! Writing: an [`Image`] and its [`Meta`] become a file, in memory or on disk.
//!
//! The bytes depend on the content and the codec alone. Sections are written from where they lie: only packed ones are held
//! a second time.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use bytemuck::{Zeroable, cast_slice};

use bvhc_core::cache::parts::{Fault, check_tree_flags, encode_names};

use super::CacheError;
use super::atomic::{Staged, Strays};
use super::check::{Limits, check_image};
use super::sealed::{Codec, Form, Piece, Sealed, WriteSummary};
use super::{Header, KINDS, MAGIC, MAJOR, MIN_MINOR, SectionEntry, SectionKind};
use super::{Image, Meta, atomic, tree_flags};
use crate::exec::Executor;
use crate::trace::wide::CompactTrees;
use crate::tree::max_depth;

/// Choices that change the file but not its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WriteOptions {
    /// How sections are stored.
    pub codec: Codec,
    /// Hold every record against the rules of the format first, and refuse an image that breaks one: a few passes over the records.
    /// Turn it off only for an image that came from [`compile`](crate::compile::compile) and was not changed.
    pub check: bool,
}

impl WriteOptions {
    /// For what a build made: debug builds, and so every test, look into each record before they write it; a release trusts the builders.
    pub const fn of_build(codec: Codec) -> WriteOptions {
        WriteOptions { codec, check: cfg!(debug_assertions) }
    }
}

impl Default for WriteOptions {
    fn default() -> WriteOptions {
        WriteOptions { codec: Codec::Raw, check: true }
    }
}

/// Write a file and put it in the place of `path` in one step: whatever happens, the old file or the new one is there.
///
/// Bytes go to a temporary file beside it, which is synced and renamed. An existing file's permissions are kept; a symbolic
/// link stays one, and what it points to is replaced. Temporary files that killed writers of the same `path` left are removed.
pub fn write_file(
    path: &Path,
    image: &Image,
    meta: &Meta,
    options: &WriteOptions,
    exec: &Executor,
) -> Result<WriteSummary, CacheError> {
    let mut sealed = seal(&path.display().to_string(), image, meta, options, exec)?;
    atomic::replace(path, |file| sealed.sign_and_write(file, exec))?;
    Ok(sealed.summary())
}

/// [`write_file`] up to the point where the new file takes its place, which is left to the caller, for one who writes many: [`Staged`].
///
/// # Errors
/// As [`write_file`].
pub fn stage_file(
    path: &Path,
    image: &Image,
    meta: &Meta,
    options: &WriteOptions,
    strays: &Strays,
    exec: &Executor,
) -> Result<(WriteSummary, Staged), CacheError> {
    let mut sealed = seal(&path.display().to_string(), image, meta, options, exec)?;
    let staged = atomic::stage(path, strays, |file| sealed.sign_and_write(file, exec))?;
    Ok((sealed.summary(), staged))
}

/// Write a file to any sink, front to back.
pub fn write_to(
    sink: impl Write,
    image: &Image,
    meta: &Meta,
    options: &WriteOptions,
    exec: &Executor,
) -> Result<WriteSummary, CacheError> {
    let name = "the cache";
    let sealed = seal(name, image, meta, options, exec)?.signed(exec);
    sealed.write_to(sink).map_err(CacheError::io("write", Path::new(name)))?;
    Ok(sealed.summary())
}

/// A file's bytes.
pub fn to_bytes(image: &Image, meta: &Meta, options: &WriteOptions, exec: &Executor) -> Result<Vec<u8>, CacheError> {
    let sealed = seal("the cache", image, meta, options, exec)?.signed(exec);
    let mut bytes = Vec::with_capacity(usize::try_from(sealed.header.file_len).unwrap_or(0));
    sealed.write_to(&mut bytes).map_err(CacheError::io("write", Path::new("the cache")))?;
    Ok(bytes)
}

/// A file that is not signed yet.
fn seal<'a>(
    name: &str,
    image: &'a Image,
    meta: &Meta,
    options: &WriteOptions,
    exec: &Executor,
) -> Result<Sealed<'a>, CacheError> {
    let unwritable = |detail| CacheError::Unwritable { name: name.to_owned(), detail };
    let too_large = |limit| CacheError::Limit { name: name.to_owned(), limit };
    if options.check {
        let report = check_image(image, &Limits { max_issues: 1, ..Limits::default() }, exec);
        Fault::of_report(&report).map_err(|fault| refusal(fault, name))?;
    }
    let meta_bytes = meta.encode().map_err(too_large)?;
    let header = describe(image, meta).map_err(unwritable)?;

    // Line up the sections in the registry's order.
    let names = if image.names.len() == image.geoms.len() { encode_names(&image.names) } else { None };
    if options.check && names.is_none() && image.geoms.iter().any(|g| g.name_hash != [0; 32]) {
        return Err(unwritable("its parts have hashes of names, and there is no name for each part".into()));
    }
    if let Some(input) = meta.dependencies.iter().find(|d| d.is_absolute()) {
        return Err(unwritable(format!(
            "META names the input {:?}, and inputs are named relative to the model's folder",
            input.name
        )));
    }
    if let Some((what, name)) = meta.repeated() {
        return Err(unwritable(format!("META names the {what} {name:?} twice")));
    }
    let materials = if image.materials.len() == image.geoms.len() { encode_names(&image.materials) } else { None };
    if options.check && materials.is_none() && image.materials.iter().any(|m| !m.is_empty()) {
        return Err(unwritable("its parts have materials, and there is no name for each part".into()));
    }
    let two_level = header.has(tree_flags::TWO_LEVEL);
    let mut pieces = Vec::new();
    for rule in &KINDS {
        let (count, data): (usize, Cow<[u8]>) = match rule.kind {
            SectionKind::NODE => (image.nodes.len(), cast_slice(&image.nodes).into()),
            SectionKind::TRIS => (image.triangles.len(), cast_slice(&image.triangles).into()),
            SectionKind::GEOM => (image.geoms.len(), cast_slice(&image.geoms).into()),
            SectionKind::BLAS => (image.blases.len(), cast_slice(&image.blases).into()),
            SectionKind::TNOD if two_level => (image.tlas_nodes.len(), cast_slice(&image.tlas_nodes).into()),
            SectionKind::INST if two_level => (image.instances.len(), cast_slice(&image.instances).into()),
            SectionKind::CROW | SectionKind::CNOD | SectionKind::CREF => {
                pieces.extend(image.compact.as_ref().map(|trees| piece_of_compact(trees, rule.kind)));
                continue;
            }
            SectionKind::OROW | SectionKind::ONOD => match &image.turns {
                Some(turns) if rule.kind == SectionKind::OROW => (turns.rows.len(), cast_slice(&turns.rows).into()),
                Some(turns) => (turns.nodes.len(), cast_slice(&turns.nodes).into()),
                None => continue,
            },
            SectionKind::VERT if !image.vertices.is_empty() => {
                (image.vertices.len(), cast_slice(&image.vertices).into())
            }
            SectionKind::SIDE if !image.sides.is_empty() => (image.sides.len(), cast_slice(&image.sides).into()),
            SectionKind::MATS => match &materials {
                Some(bytes) => (image.materials.len(), bytes.clone().into()),
                None => continue,
            },
            SectionKind::NAMS => match &names {
                Some(bytes) => (image.names.len(), bytes.clone().into()),
                None => continue,
            },
            SectionKind::META => (0, meta_bytes.clone().into()),
            _ => continue,
        };
        let entry = entry_of(rule.kind, count);
        pieces.push(Piece { entry, data: data.into(), form: Form::Decoded });
    }
    Sealed::lay_out(header, pieces, options.codec, exec).map_err(CacheError::io("compress", Path::new(name)))
}

/// A section of compact trees.
pub(super) fn piece_of_compact(trees: &CompactTrees, kind: SectionKind) -> Piece<'_> {
    let (count, data): (usize, &[u8]) = match kind {
        SectionKind::CROW => (trees.rows.len(), cast_slice(&trees.rows)),
        SectionKind::CNOD => (trees.nodes.len(), cast_slice(&trees.nodes)),
        _ => (trees.order.len(), cast_slice(&trees.order)),
    };
    Piece { entry: entry_of(kind, count), data: data.into(), form: Form::Decoded }
}

/// The entry of a section of so many records; where it stands, and its hashes, follow.
fn entry_of(kind: SectionKind, count: usize) -> SectionEntry {
    let known = kind.rule().map(|rule| (rule.flags, rule.schema, rule.elem_size)).unwrap_or_default();
    let (flags, schema, elem_size) = known;
    SectionEntry { kind, flags, schema, elem_size, elem_count: count as u64, ..SectionEntry::zeroed() }
}

/// An image that breaks a rule is a fault of the program; one that could not be looked into may be sound.
pub(super) fn refusal(fault: Fault, name: &str) -> CacheError {
    let detail = fault.to_string();
    match fault.of(name) {
        CacheError::Invalid { name, .. } => CacheError::Unwritable { name, detail },
        limit => limit,
    }
}

/// The header's facts; identities and layout follow in [`Sealed`].
fn describe(image: &Image, meta: &Meta) -> Result<Header, String> {
    check_tree_flags(image.flags).map_err(|breach| breach.detail())?;
    let live = |count: u64| count.saturating_sub(1);
    let two_level = image.flags & tree_flags::TWO_LEVEL != 0;
    if !two_level && (image.blases.len() > 1 || !image.instances.is_empty() || !image.tlas_nodes.is_empty()) {
        return Err("an image without TWO_LEVEL has several trees or instances".into());
    }
    let count =
        |what: &str, len: usize| u32::try_from(len).map_err(|_| format!("it has {len} {what}, more than 32 bits hold"));
    let root = if two_level { image.tlas_nodes.first() } else { image.nodes.first() };
    Ok(Header {
        magic: MAGIC,
        major: MAJOR,
        min_minor: MIN_MINOR,
        header_len: Header::LEN as u16,
        section_entry_len: SectionEntry::LEN as u32,
        section_table_off: Header::LEN as u64,
        tree_flags: image.flags,
        builder_id: builder_id(&meta.method),
        build_key: meta.build_key(),
        prim_count: image.blases.iter().map(|b| u64::from(b.prim_count)).sum(),
        ref_count: image.triangles.len() as u64,
        node_count: image.blases.iter().map(|b| live(b.node_count.into())).sum::<u64>()
            + live(image.tlas_nodes.len() as u64),
        blas_count: count("trees", image.blases.len())?,
        instance_count: count("instances", image.instances.len())?,
        max_depth: image.blases.iter().map(|b| b.max_depth).max().unwrap_or(0).max(max_depth(&image.tlas_nodes)),
        scene_min: root.map_or([0.0; 3], |n| n.min),
        scene_max: root.map_or([0.0; 3], |n| n.max),
        ..Header::zeroed()
    })
}

/// What the header says of the method beside META: two methods have numbers from early days, and no others get any.
pub(super) fn builder_id(method: &str) -> u32 {
    match method {
        "binned" => 1,
        "sbvh" => 2,
        _ => 0,
    }
}
