//! Opening: a file is mapped, validated as deeply as asked, and handed out as slices.

use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use std::sync::OnceLock;

use bytemuck::Pod;

use super::aligned::AlignedBytes;
use super::container::{self, Container, First, is_understood};
use super::error::{CacheError, Fault};
#[cfg(feature = "zstd")]
use super::pack;
use super::{Header, Meta, View, check};
use crate::exec::Executor;
use crate::layout::Node;
use crate::layout::{BlasRecord, GeomRecord, InstanceRecord, SectionEntry, SectionKind, TriangleRecord, section_flags};

/// How deeply a file is looked into when it is opened. Each level includes the ones before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Validation {
    /// Header, section table, tiling, `file_id`: the file is of this format, complete, and its parts are where they are said to be.
    /// Milliseconds for any size. Traversal of a damaged file then ends and touches no foreign memory, but may miss or invent hits.
    Quick,
    /// And the hash of every section: the bytes are those that were written.
    #[default]
    Hash,
    /// And every record: indices, tree shape, boxes, triangles, instances, counts. For files from strangers, who can hash
    /// anything.
    Tree,
}

/// How a file is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenOptions {
    /// What is checked before the file is handed out.
    pub validation: Validation,
    /// Map the file instead of reading it. A mapping is not a snapshot: whoever changes the file in place changes what is
    /// traced, and whoever shortens it ends the process (SIGBUS). This crate's writer does neither; turn mapping off for files
    /// that others may write.
    pub mmap: bool,
    /// Most bytes that decoded sections, and without `mmap` the file, may take.
    pub max_memory: u64,
}

impl OpenOptions {
    /// [`OpenOptions::max_memory`] unless another is given: 8 GiB.
    pub const DEFAULT_MAX_MEMORY: u64 = 8 << 30;
}

impl Default for OpenOptions {
    fn default() -> Self {
        OpenOptions { validation: Validation::default(), mmap: true, max_memory: Self::DEFAULT_MAX_MEMORY }
    }
}

/// An open cache file that owns or maps its bytes.
pub type Cache = Opened<'static>;

/// An open cache file. [`Cache`] is the form that owns or maps its bytes; [`Cache::from_slice`] gives one that borrows them.
pub struct Opened<'a> {
    bytes: FileBytes<'a>,
    pub(super) container: Container,
    /// The decoded bytes of each packed section, parallel to the section table.
    decoded: Vec<Option<AlignedBytes>>,
    pub(super) places: Places,
    /// For each instance of the scene its record; filled when it is first asked for.
    pub(super) by_id: OnceLock<Vec<u32>>,
    meta: Option<Meta>,
    meta_error: Option<String>,
    validation: Validation,
}

/// A whole file in memory: mapped, read to a 64-byte boundary, or borrowed.
pub struct FileBytes<'a>(Bytes<'a>);

enum Bytes<'a> {
    #[cfg(feature = "mmap")]
    Mapped(memmap2::Mmap),
    Owned(AlignedBytes),
    Borrowed(&'a [u8]),
}

impl FileBytes<'_> {
    /// Map or read a file, as `options` say; nothing in it is looked at.
    ///
    /// # Errors
    /// Where the file cannot be read, is not a regular one, or is larger than `options.max_memory` and not to be mapped.
    pub fn open(path: &Path, options: &OpenOptions) -> Result<FileBytes<'static>, CacheError> {
        // Ask before opening: to open a named pipe would wait for its writer.
        let metadata = std::fs::metadata(path).map_err(CacheError::io("open", path))?;
        if !metadata.is_file() {
            let error = std::io::Error::other("it is not a regular file");
            return Err(CacheError::io("open", path)(error));
        }
        let file = File::open(path).map_err(CacheError::io("open", path))?;
        let metadata = file.metadata().map_err(CacheError::io("open", path))?;
        if metadata.len() == 0 {
            return Ok(FileBytes(Bytes::Owned(AlignedBytes::default())));
        }
        #[cfg(feature = "mmap")]
        if options.mmap {
            return Ok(FileBytes(Bytes::Mapped(map(&file).map_err(CacheError::io("map", path))?)));
        }
        Ok(FileBytes(Bytes::Owned(read(file, metadata.len(), path, options.max_memory)?)))
    }

    /// The file's bytes.
    pub fn as_slice(&self) -> &[u8] {
        match &self.0 {
            #[cfg(feature = "mmap")]
            Bytes::Mapped(map) => map,
            Bytes::Owned(bytes) => bytes.as_slice(),
            Bytes::Borrowed(bytes) => bytes,
        }
    }

    /// Bytes that are neither mapped nor borrowed.
    fn owned_len(&self) -> usize {
        match &self.0 {
            Bytes::Owned(bytes) => bytes.as_slice().len(),
            _ => 0,
        }
    }
}

/// Index of each kind's table entry, number 0.
#[derive(Clone, Copy)]
pub(super) struct Places {
    node: Option<usize>,
    tris: Option<usize>,
    geom: Option<usize>,
    blas: Option<usize>,
    tnod: Option<usize>,
    inst: Option<usize>,
    pub vert: Option<usize>,
    pub side: Option<usize>,
    pub nams: Option<usize>,
    pub mats: Option<usize>,
}

impl Opened<'static> {
    /// Map a file and check its hashes: [`Cache::open_with`] and the default options.
    ///
    /// # Errors
    /// Where the file cannot be read, is not a cache, is damaged, or needs a newer version of this crate.
    pub fn open(path: impl AsRef<Path>) -> Result<Cache, CacheError> {
        Cache::open_with(path, &OpenOptions::default())
    }

    /// Open a file as `options` say.
    ///
    /// # Errors
    /// As [`Cache::open`], and where `options.max_memory` is too small.
    pub fn open_with(path: impl AsRef<Path>, options: &OpenOptions) -> Result<Cache, CacheError> {
        Cache::open_on(path, options, &Executor::current())
    }

    /// [`Cache::open_with`] with the threads of `exec`: hashing, decoding and checking are shared among them.
    ///
    /// # Errors
    /// As [`Cache::open_with`].
    pub fn open_on(path: impl AsRef<Path>, options: &OpenOptions, exec: &Executor) -> Result<Cache, CacheError> {
        let path = path.as_ref();
        Cache::new(FileBytes::open(path, options)?, &path.display().to_string(), options, exec)
    }

    /// Open a file's bytes where they lie, for example in a larger archive or in the program itself.
    ///
    /// Nothing is copied where the slice starts at a multiple of 8 bytes in memory, as the records need; otherwise it is copied once.
    ///
    /// # Errors
    /// As [`Cache::open_with`].
    pub fn from_slice<'a>(bytes: &'a [u8], options: &OpenOptions) -> Result<Opened<'a>, CacheError> {
        Cache::from_slice_on(bytes, options, &Executor::current())
    }

    /// [`Cache::from_slice`] with the threads of `exec`.
    ///
    /// # Errors
    /// As [`Cache::open_with`].
    pub fn from_slice_on<'a>(
        bytes: &'a [u8],
        options: &OpenOptions,
        exec: &Executor,
    ) -> Result<Opened<'a>, CacheError> {
        if bytes.as_ptr().align_offset(align_of::<u64>()) != 0 {
            return Cache::from_bytes_on(bytes, options, exec);
        }
        Opened::new(FileBytes(Bytes::Borrowed(bytes)), GIVEN, options, exec)
    }

    /// Open a file's bytes from memory; they are copied to a 64-byte boundary.
    ///
    /// # Errors
    /// As [`Cache::open_with`].
    pub fn from_bytes(bytes: &[u8], options: &OpenOptions) -> Result<Cache, CacheError> {
        Cache::from_bytes_on(bytes, options, &Executor::current())
    }

    /// [`Cache::from_bytes`] with the threads of `exec`.
    ///
    /// # Errors
    /// As [`Cache::open_with`].
    pub fn from_bytes_on(bytes: &[u8], options: &OpenOptions, exec: &Executor) -> Result<Cache, CacheError> {
        let name = GIVEN;
        let needed = Fault::memory(bytes.len() as u128, options.max_memory);
        if bytes.len() as u64 > options.max_memory {
            return Err(needed.of(name));
        }
        let mut owned = AlignedBytes::zeroed(bytes.len()).map_err(|_| needed.of(name))?;
        owned.as_mut_slice().copy_from_slice(bytes);
        Cache::new(FileBytes(Bytes::Owned(owned)), name, options, exec)
    }
}

/// What errors call bytes that come from no file.
const GIVEN: &str = "the given bytes";

impl<'a> Opened<'a> {
    fn new(bytes: FileBytes<'a>, name: &str, options: &OpenOptions, exec: &Executor) -> Result<Opened<'a>, CacheError> {
        let container = Container::parse(bytes.as_slice()).map_err(|fault| fault.of(name))?;
        let find = |kind| container.find(kind);
        let places = Places {
            node: find(SectionKind::NODE),
            tris: find(SectionKind::TRIS),
            geom: find(SectionKind::GEOM),
            blas: find(SectionKind::BLAS),
            tnod: find(SectionKind::TNOD),
            inst: find(SectionKind::INST),
            vert: find(SectionKind::VERT),
            side: find(SectionKind::SIDE),
            nams: find(SectionKind::NAMS),
            mats: find(SectionKind::MATS),
        };
        let meta_place = find(SectionKind::META);
        let decoded = container.entries.iter().map(|_| None).collect();
        let (meta, meta_error, validation) = (None, None, options.validation);
        let by_id = OnceLock::new();
        let mut cache = Opened { bytes, container, decoded, places, by_id, meta, meta_error, validation };
        cache.fill(meta_place, options, exec).map_err(|fault| fault.of(name))?;
        if options.validation >= Validation::Tree {
            cache.check_records(exec).map_err(|fault| fault.of(name))?;
        }
        Ok(cache)
    }

    /// Hash, decode and read what the level asks for.
    fn fill(&mut self, meta_place: Option<usize>, options: &OpenOptions, exec: &Executor) -> Result<(), Fault> {
        // Hold what decoding will take against the limit before anything is allocated.
        let packed = |e: &&SectionEntry| e.codec == SectionEntry::ZSTD;
        let owned = self.bytes.owned_len();
        let entries = &self.container.entries;
        let needed = entries.iter().filter(packed).map(|e| u128::from(e.raw_len)).sum::<u128>() + owned as u128;
        if needed > u128::from(options.max_memory) {
            return Err(Fault::memory(needed, options.max_memory));
        }
        let any_packed = entries.iter().any(|e| e.codec == SectionEntry::ZSTD);
        self.container.check_head()?;

        // A decoder sees only bytes that were hashed, at every level; so does the reader of META.
        // The rows of BLAS come first: what they contradict is not worth decoding.
        let thorough = options.validation >= Validation::Hash;
        let blas = self.places.blas;
        let others = (0..self.container.entries.len()).filter(|i| Some(*i) != blas);
        for i in blas.into_iter().chain(others) {
            let entry = self.container.entries[i];
            let decode = entry.codec == SectionEntry::ZSTD && (thorough || is_understood(&entry));
            if thorough || decode || Some(i) == meta_place {
                check_hash("E0201", &entry, self.stored_bytes(i), &entry.stored_hash, exec)?;
            }
            if decode {
                let raw_len = usize::try_from(entry.raw_len).map_err(|_| Fault::memory(needed, options.max_memory))?;
                let unpacked = unpack(&entry, self.stored_bytes(i), raw_len, exec);
                match unpacked {
                    Ok(raw) => self.decoded[i] = Some(raw),
                    Err(fault) if entry.is(section_flags::CRITICAL) => return Err(fault),
                    // It is what its writer wrote, and nothing that a ray needs: `check` reports it.
                    Err(fault) if Some(i) == meta_place => self.meta_error = Some(fault.to_string()),
                    Err(_) => {}
                }
            }
            if Some(i) == blas && any_packed {
                self.check_rows()?;
            }
        }
        if let Some(bytes) = meta_place.and_then(|i| self.section_bytes(i)) {
            match Meta::decode(bytes) {
                Ok(meta) => self.meta = Some(meta),
                Err(fault) => self.meta_error = Some(fault.to_string()),
            }
        } else if self.meta_error.is_none() {
            self.meta_error = container::later_meta(&self.container.entries);
        }
        if thorough {
            let mut first = First::default();
            _ = self.container.check_content_id(&mut first);
            first.result()?;
        }
        Ok(())
    }

    /// Hold the rows of BLAS against the lengths that the table states for NODE and TRIS.
    fn check_rows(&self) -> Result<(), Fault> {
        let count = |place: Option<usize>| place.and_then(|i| self.sections().get(i)).map_or(0, |e| e.elem_count);
        let (nodes, triangles) = (count(self.places.node), count(self.places.tris));
        let mut first = First::default();
        _ = check::check_rows(self.blases(), nodes, triangles, &mut first);
        first.result()
    }

    /// Look into every record and say the first thing that is wrong.
    fn check_records(&self, exec: &Executor) -> Result<(), Fault> {
        let limits = check::Limits { max_issues: 1, ..check::Limits::default() };
        let view = self.view();
        let mut report = check::check_records(&view, self.header().tree_flags, Some(self.header()), &limits, exec);
        let section = |place: Option<usize>| place.and_then(|i| self.section_bytes(i));
        if section(self.places.vert).is_some() {
            report.append(check::check_vertices(&view, self.records(self.places.vert), &limits, exec));
        }
        if section(self.places.side).is_some() {
            check::check_sides(view.geoms, self.records(self.places.side), &mut report);
        }
        Fault::of_report(&report)
    }

    /// The file's first 256 bytes. Not every count in it is held against the records below [`Validation::Tree`].
    pub fn header(&self) -> &Header {
        &self.container.header
    }

    /// The section table, unknown sections included.
    pub fn sections(&self) -> &[SectionEntry] {
        &self.container.entries
    }

    /// The index in [`Cache::sections`] of the section of this kind, if this version can read it.
    pub fn find(&self, kind: SectionKind) -> Option<usize> {
        self.container.find(kind)
    }

    /// The level at which the file was opened.
    pub fn validation(&self) -> Validation {
        self.validation
    }

    /// Provenance; `None` for a file without META, and for one whose META cannot be read: [`Cache::meta_error`].
    pub fn meta(&self) -> Option<&Meta> {
        self.meta.as_ref()
    }

    /// Why [`Cache::meta`] is `None` although the file has a META: it is of a later layout, or breaks its own. Traversal does not
    /// need it, so such a file is opened all the same.
    pub fn meta_error(&self) -> Option<&str> {
        self.meta_error.as_deref()
    }

    /// Everything that traversal reads.
    pub fn view(&self) -> View<'_> {
        View {
            nodes: self.nodes(),
            triangles: self.triangles(),
            geoms: self.geoms(),
            blases: self.blases(),
            tlas_nodes: self.tlas_nodes(),
            instances: self.instances(),
        }
    }

    /// `NODE`: the nodes of all BLASes, tree after tree; where each begins, [`BlasRecord::node_offset`] says.
    pub fn nodes(&self) -> &[Node] {
        self.records(self.places.node)
    }

    /// `TRIS`: the triangles of all BLASes in leaf order; where each begins, [`BlasRecord::ref_offset`] says. With spatial splits a
    /// triangle may stand there several times.
    pub fn triangles(&self) -> &[TriangleRecord] {
        self.records(self.places.tris)
    }

    /// `GEOM`: the source parts, which [`Hit::geom`](crate::Hit::geom) and [`TriangleRecord::geom`] index.
    pub fn geoms(&self) -> &[GeomRecord] {
        self.records(self.places.geom)
    }

    /// `BLAS`: one record for each tree; none in an empty scene.
    pub fn blases(&self) -> &[BlasRecord] {
        self.records(self.places.blas)
    }

    /// Empty in a one-level file.
    pub fn tlas_nodes(&self) -> &[Node] {
        self.records(self.places.tnod)
    }

    /// The instances in the order of the top-level tree's leaves; empty in a one-level file. Hits name them by their `id`:
    /// see [`Cache::instance_record`](Opened::instance_record).
    pub fn instances(&self) -> &[InstanceRecord] {
        self.records(self.places.inst)
    }

    /// The decoded bytes of section `index` of [`Cache::sections`]; `None` for an unknown codec, for a section that may be ignored and
    /// cannot be decoded, and at [`Validation::Quick`] for packed sections of unknown kinds.
    pub fn section_bytes(&self, index: usize) -> Option<&[u8]> {
        match self.sections().get(index)?.codec {
            SectionEntry::RAW => Some(self.stored_bytes(index)),
            _ => self.decoded.get(index)?.as_ref().map(AlignedBytes::as_slice),
        }
    }

    /// The bytes of section `index` as they stand in the file; empty beyond the table.
    pub fn stored_bytes(&self, index: usize) -> &[u8] {
        let range = self.sections().get(index).and_then(|e| Some(to_usize(e.offset)?..to_usize(e.end()?)?));
        // The container checks found every range inside the file, so this finds it there too.
        range.and_then(|range: Range<usize>| self.bytes.as_slice().get(range)).unwrap_or_default()
    }

    pub(super) fn records<T: Pod>(&self, place: Option<usize>) -> &[T] {
        let bytes = place.and_then(|i| self.section_bytes(i)).unwrap_or_default();
        // Offsets are multiples of 64 in memory that starts at one, and lengths are multiples of the record's: both were checked.
        bytemuck::try_cast_slice(bytes).unwrap_or_default()
    }
}

/// Renderers share one cache between threads.
const _: fn() = || {
    fn shared<T: Send + Sync>() {}
    shared::<Cache>();
};

impl std::fmt::Debug for Opened<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cache")
            .field("header", self.header())
            .field("sections", &self.sections())
            .finish_non_exhaustive()
    }
}

fn to_usize(value: u64) -> Option<usize> {
    usize::try_from(value).ok()
}

#[cfg(feature = "zstd")]
pub(super) fn unpack(
    entry: &SectionEntry,
    stored: &[u8],
    raw_len: usize,
    exec: &Executor,
) -> Result<AlignedBytes, Fault> {
    let raw = pack::unpack(stored, raw_len, exec)
        .map_err(|fault| Fault { detail: format!("{}: {}", entry.kind, fault.detail), ..fault })?;
    check_hash("E0202", entry, raw.as_slice(), &entry.raw_hash, exec)?;
    Ok(raw)
}

#[cfg(not(feature = "zstd"))]
pub(super) fn unpack(
    entry: &SectionEntry,
    _stored: &[u8],
    _raw_len: usize,
    _exec: &Executor,
) -> Result<AlignedBytes, Fault> {
    Err(container::no_zstd(entry))
}

fn check_hash(
    rule: &'static str,
    entry: &SectionEntry,
    bytes: &[u8],
    want: &[u8; 32],
    exec: &Executor,
) -> Result<(), Fault> {
    if exec.hash(bytes) == *want {
        return Ok(());
    }
    let form = if rule == "E0201" { "stored" } else { "decoded" };
    Err(Fault::invalid(
        rule,
        format!("the {form} bytes of {} do not have the hash of the section table: the file is damaged", entry.kind),
    ))
}

/// Map a file for reading.
#[cfg(feature = "mmap")]
#[allow(unsafe_code)]
fn map(file: &File) -> std::io::Result<memmap2::Mmap> {
    // SAFETY: what the compiler may assume of the resulting `&[u8]`, that nobody writes to it, cannot be promised for a file, as
    // memmap2 says itself. What this crate does about it: its writer never changes a file in place but renames a new one over
    // it, and a renamed-over file stays whole for those who map it; header and table are copied out before they are
    // checked and used; what is read later is plain old data without invalid values, and every index taken from it is
    // bounds-checked where it is used. A file that another program changes in place can thus give wrong hits; one that is
    // shortened ends the process by SIGBUS. `OpenOptions::mmap` and the specification say so.
    unsafe { memmap2::Mmap::map(file) }
}

fn read(mut file: File, len: u64, path: &Path, max_memory: u64) -> Result<AlignedBytes, CacheError> {
    let too_large = || Fault::memory(len.into(), max_memory).of(&path.display().to_string());
    if len > max_memory {
        return Err(too_large());
    }
    let mut bytes = to_usize(len).and_then(|len| AlignedBytes::zeroed(len).ok()).ok_or_else(too_large)?;
    file.read_exact(bytes.as_mut_slice()).map_err(CacheError::io("read", path))?;
    Ok(bytes)
}
