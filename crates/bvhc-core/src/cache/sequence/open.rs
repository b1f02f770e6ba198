use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::{Frames, Sequence};
use crate::cache::container::First;
use crate::cache::error::{CacheError, Fault};
use crate::cache::file_bytes::FileBytes;
use crate::cache::open::GIVEN;
use crate::cache::options::OpenOptions;
use crate::cache::poses::{Rows, parts_of};
use crate::cache::reader::Opened;
use crate::exec::Executor;
use crate::layout::{SectionKind, tree_flags};

impl Frames<'static> {
    /// Map a file of many frames: [`Sequence::open_with`] and the default options.
    ///
    /// # Errors
    /// Where the file cannot be read, is no sequence, is damaged, or needs a newer version of this crate.
    pub fn open(path: impl AsRef<Path>) -> Result<Sequence, CacheError> {
        Sequence::open_with(path, &OpenOptions::default())
    }

    /// Open a file as `options` say. The level holds for what is handed out: here for what all frames share, in
    /// [`Sequence::frame`](Frames::frame) for the frame.
    ///
    /// # Errors
    /// As [`Sequence::open`], and where `options.max_memory` is too small.
    pub fn open_with(path: impl AsRef<Path>, options: &OpenOptions) -> Result<Sequence, CacheError> {
        Sequence::open_on(path, options, &Executor::current())
    }

    /// [`Sequence::open_with`] with the threads of `exec`.
    ///
    /// # Errors
    /// As [`Sequence::open_with`].
    pub fn open_on(path: impl AsRef<Path>, options: &OpenOptions, exec: &Executor) -> Result<Sequence, CacheError> {
        let path = path.as_ref();
        Frames::new(FileBytes::open(path, options)?, &path.display().to_string(), options, exec)
    }

    /// Open a file's bytes where they lie, as [`Cache::from_slice`](crate::Cache::from_slice) does.
    ///
    /// # Errors
    /// As [`Sequence::open_with`].
    pub fn from_slice<'a>(bytes: &'a [u8], options: &OpenOptions) -> Result<Frames<'a>, CacheError> {
        let exec = Executor::current();
        if bytes.as_ptr().align_offset(align_of::<u64>()) == 0 {
            return Frames::new(FileBytes::borrowed(bytes), GIVEN, options, &exec);
        }
        let owned = FileBytes::copied(bytes, options.max_memory).map_err(|fault| fault.of(GIVEN))?;
        Frames::new(owned, GIVEN, options, &exec)
    }
}

impl<'a> Frames<'a> {
    fn new(bytes: FileBytes<'a>, name: &str, options: &OpenOptions, exec: &Executor) -> Result<Frames<'a>, CacheError> {
        let file = Opened::front(bytes, name, options, exec)?;
        if !file.header().has(tree_flags::SEQUENCE) {
            return Err(CacheError::Still { name: name.to_owned() });
        }
        Frames::of(file, options).map_err(|fault| fault.of(name))
    }

    fn of(file: Opened<'a>, options: &OpenOptions) -> Result<Frames<'a>, Fault> {
        let find = |kind| file.find(kind, 0);
        let (topologies, corners) = (find(SectionKind::TOPO), find(SectionKind::TRIX));
        let (poses, frames) = (find(SectionKind::POSE), find(SectionKind::FRAM));
        let blocks = file.container.pairs(SectionKind::NODE, SectionKind::VPOS);
        let placements = file.container.pairs(SectionKind::TNOD, SectionKind::INST);
        let hashed = file.sections().iter().map(|_| AtomicBool::new(false)).collect();
        let max_memory = options.max_memory;
        let mut opened = Frames {
            file,
            topologies,
            corners,
            poses,
            frames,
            blocks,
            placements,
            parts: Vec::new(),
            hashed,
            max_memory,
            #[cfg(feature = "zstd")]
            moved: None,
        };
        let blocks = opened.file.container.lengths(&opened.blocks);
        let rows = Rows {
            topologies: opened.topologies(),
            poses: opened.poses(),
            frames: opened.frames(),
            geoms: opened.geoms(),
            triangles: opened.indexed_triangles().len() as u64,
            blocks: &blocks,
            placements: opened.placements.len(),
        };
        let mut first = First::default();
        _ = rows.check(&mut first);
        first.result()?;
        opened.parts = parts_of(opened.geoms(), opened.topologies().len());
        #[cfg(feature = "zstd")]
        {
            opened.moved = opened.moved();
        }
        Ok(opened)
    }
}
