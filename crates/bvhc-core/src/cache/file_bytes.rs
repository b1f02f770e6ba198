//! A file's bytes in memory, before anything in them is looked at; the only place that maps files.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::aligned::AlignedBytes;
use super::error::{CacheError, Fault};
use super::options::OpenOptions;

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

    /// Bytes of a file that lie in memory already.
    pub(super) fn borrowed(bytes: &[u8]) -> FileBytes<'_> {
        FileBytes(Bytes::Borrowed(bytes))
    }

    /// A copy of such bytes that starts at a 64-byte boundary.
    pub(super) fn copied(bytes: &[u8], max_memory: u64) -> Result<FileBytes<'static>, Fault> {
        let too_large = || Fault::Memory { needed: bytes.len() as u128, limit: max_memory };
        if bytes.len() as u64 > max_memory {
            return Err(too_large());
        }
        let mut owned = AlignedBytes::zeroed(bytes.len()).map_err(|_| too_large())?;
        owned.as_mut_slice().copy_from_slice(bytes);
        Ok(FileBytes(Bytes::Owned(owned)))
    }

    /// Bytes that are neither mapped nor borrowed.
    pub(super) fn owned_len(&self) -> usize {
        match &self.0 {
            Bytes::Owned(bytes) => bytes.as_slice().len(),
            _ => 0,
        }
    }
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
    let too_large = || Fault::Memory { needed: len.into(), limit: max_memory }.of(&path.display().to_string());
    if len > max_memory {
        return Err(too_large());
    }
    let mut bytes = to_usize(len).and_then(|len| AlignedBytes::zeroed(len).ok()).ok_or_else(too_large)?;
    file.read_exact(bytes.as_mut_slice()).map_err(CacheError::io("read", path))?;
    Ok(bytes)
}

pub(super) fn to_usize(value: u64) -> Option<usize> {
    usize::try_from(value).ok()
}
