//! Opening: a file is mapped, or its bytes are given, and it is validated as deeply as asked.

use std::path::Path;
use std::sync::OnceLock;

use super::container::{self, Container, First, is_known_codec, is_understood};
use super::decode::{check_stored, unpack};
use super::error::{Brief, CacheError, Fault};
use super::file_bytes::FileBytes;
use super::options::{OpenOptions, Validation};
use super::reader::{Cache, Opened, Places};
use super::report::Finding;
use super::{Meta, check};
use crate::exec::Executor;
use crate::layout::{SectionEntry, SectionKind, section_flags, tree_flags};

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
        Opened::new(FileBytes::borrowed(bytes), GIVEN, options, exec)
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
        let owned = FileBytes::copied(bytes, options.max_memory).map_err(|fault| fault.of(GIVEN))?;
        Cache::new(owned, GIVEN, options, exec)
    }
}

/// What errors call bytes that come from no file.
pub(super) const GIVEN: &str = "the given bytes";

/// The kinds of which a sequence has several sections: only a frame that needs one of them reads it.
pub(super) fn is_of_frames(kind: SectionKind) -> bool {
    kind.rule().is_some_and(|rule| rule.ordinals > 1)
}

impl<'a> Opened<'a> {
    fn new(bytes: FileBytes<'a>, name: &str, options: &OpenOptions, exec: &Executor) -> Result<Opened<'a>, CacheError> {
        let cache = Opened::front(bytes, name, options, exec)?;
        if cache.header().has(tree_flags::SEQUENCE) {
            return Err(CacheError::Sequence { name: name.to_owned(), frames: cache.header().frame_count });
        }
        if options.validation >= Validation::Tree {
            cache.check_records(exec).map_err(|fault| fault.of(name))?;
        }
        Ok(cache)
    }

    /// A file whose container holds, with everything hashed and decoded that the level asks for; of a sequence only what all frames share.
    pub(super) fn front(
        bytes: FileBytes<'a>,
        name: &str,
        options: &OpenOptions,
        exec: &Executor,
    ) -> Result<Opened<'a>, CacheError> {
        let container = Container::parse(bytes.as_slice()).map_err(|breach| Fault::from(breach).of(name))?;
        let find = |kind| container.find(kind, 0);
        let places = Places {
            node: find(SectionKind::NODE),
            tris: find(SectionKind::TRIS),
            geom: find(SectionKind::GEOM),
            blas: find(SectionKind::BLAS),
            tnod: find(SectionKind::TNOD),
            inst: find(SectionKind::INST),
            crow: find(SectionKind::CROW),
            cnod: find(SectionKind::CNOD),
            cref: find(SectionKind::CREF),
            orow: find(SectionKind::OROW),
            onod: find(SectionKind::ONOD),
            vert: find(SectionKind::VERT),
            side: find(SectionKind::SIDE),
            nams: find(SectionKind::NAMS),
            mats: find(SectionKind::MATS),
        };
        let meta_place = find(SectionKind::META);
        let decoded = container.entries.iter().map(|_| None).collect();
        let (meta, meta_error, validation) = (None, None, options.validation);
        let (by_id, marks) = (OnceLock::new(), OnceLock::new());
        let mut cache = Opened { bytes, container, decoded, places, by_id, marks, meta, meta_error, validation };
        cache.fill(meta_place, options, exec).map_err(|fault| fault.of(name))?;
        Ok(cache)
    }

    /// Hash, decode and read what the level asks for.
    fn fill(&mut self, meta_place: Option<usize>, options: &OpenOptions, exec: &Executor) -> Result<(), Fault> {
        // Hold what decoding will take against the limit before anything is allocated.
        let sequence = self.header().has(tree_flags::SEQUENCE);
        let is_later = |e: &SectionEntry| sequence && is_of_frames(e.kind);
        let packed = |e: &&SectionEntry| e.is_packed() && is_known_codec(e) && !is_later(e);
        let owned = self.bytes.owned_len();
        let entries = &self.container.entries;
        let needed = entries.iter().filter(packed).map(|e| u128::from(e.raw_len)).sum::<u128>() + owned as u128;
        if needed > u128::from(options.max_memory) {
            return Err(Fault::Memory { needed, limit: options.max_memory });
        }
        let any_packed = entries.iter().any(|e| packed(&e));
        self.container.check_head()?;

        // A decoder sees only bytes that were hashed, at every level; so does the reader of META.
        // The rows of BLAS come first: what they contradict is not worth decoding.
        let thorough = options.validation >= Validation::Hash;
        let blas = self.places.blas;
        let others = (0..self.container.entries.len()).filter(|i| Some(*i) != blas);
        for i in blas.into_iter().chain(others) {
            let entry = self.container.entries[i];
            if is_later(&entry) {
                continue;
            }
            let decode = entry.is_packed() && is_known_codec(&entry) && (thorough || is_understood(&entry));
            if thorough || decode || Some(i) == meta_place {
                check_stored(&entry, self.stored_bytes(i), exec)?;
            }
            if decode {
                let raw_len =
                    usize::try_from(entry.raw_len).map_err(|_| Fault::Memory { needed, limit: options.max_memory })?;
                let unpacked = unpack(&entry, self.stored_bytes(i), raw_len, exec);
                match unpacked {
                    Ok(raw) => self.decoded[i] = Some(raw),
                    Err(breach) if entry.is(section_flags::CRITICAL) => return Err(breach.into()),
                    // It is what its writer wrote, and nothing that a ray needs: a check of the records reports it.
                    Err(breach) if Some(i) == meta_place => self.meta_error = Some(Brief(&breach).to_string()),
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
                Err(breach) => self.meta_error = Some(Brief(&breach).to_string()),
            }
        } else if self.meta_error.is_none() {
            self.meta_error = container::later_meta(&self.container.entries).map(|unread| Brief(&unread).to_string());
        }
        if thorough {
            let mut first = First::default();
            _ = self.container.check_content_id(&mut first);
            first.result()?;
        }
        Ok(())
    }

    /// Hold the rows of BLAS against the lengths that the table states for NODE and TRIS.
    fn check_rows(&self) -> Result<(), Finding> {
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
        let of = check::RecordsOf::File(self.header());
        let mut report = check::check_records(&view, self.header().tree_flags, of, &limits, exec);
        let section = |place: Option<usize>| place.and_then(|i| self.section_bytes(i));
        let places = &self.places;
        // One that cannot be decoded is passed over, as if the file had no compact trees.
        let is_unread = |place: Option<usize>| place.is_some() && section(place).is_none();
        if report.is_valid() && ![places.crow, places.cnod, places.cref].into_iter().any(is_unread) {
            let compact = check::CompactRecords {
                rows: section(places.crow).map(|_| self.compact_rows()),
                nodes: section(places.cnod).map(|_| self.compact_nodes()),
                order: section(places.cref).map(|_| self.compact_order()),
            };
            report.append(check::check_compact(&view, &compact, &limits, exec));
        }
        if report.is_valid() && ![places.orow, places.onod].into_iter().any(is_unread) {
            let turns = check::TurnRecords {
                rows: section(places.orow).map(|_| self.turns()),
                nodes: section(places.onod).map(|_| self.turned_nodes()),
            };
            report.append(check::check_turns(&view, &turns, &limits, exec));
        }
        if section(self.places.vert).is_some() {
            report.append(check::check_vertices(&view, self.records(self.places.vert), &limits, exec));
        }
        if section(self.places.side).is_some() {
            check::check_sides(view.geoms, self.records(self.places.side), &mut report);
        }
        Fault::of_report(&report)
    }
}
