//! Replacing a file in one step.
//!
//! A writer locks its temporary file for as long as it lives. Whoever comes next tries each temporary file of the same
//! target: one whose lock is free belongs to nobody any more and is removed. So a killed writer leaves at most one file, and the next
//! one cleans it away, without ever touching the file of a writer that is still at work.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

use super::CacheError;
use bvhc_core::cache::parts::clip;

const SUFFIX: &str = ".bvhc-tmp";

/// Let `write` fill a new file, then put it in the place of `path`. On any error `path` is what it was.
pub(super) fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), CacheError> {
    let staged = stage(path, &Strays::default(), write)?;
    staged.sync()?;
    let folder = staged.put()?;
    folder.map_or(Ok(()), |folder| sync_folder(&folder).map_err(CacheError::io("sync the folder of", path)))
}

/// A whole new file beside the one whose place it will take.
///
/// Dropped, it is gone, and the old file is what it was. Killed, the process leaves it; whoever next writes the same file removes it.
#[derive(Debug)]
#[must_use = "nothing is in its place before it is put there"]
pub struct Staged {
    /// As the caller named it.
    path: PathBuf,
    /// Where links lead.
    target: PathBuf,
    /// `None` where the target is a device, which was written to already.
    temporary: Option<NamedTempFile>,
}

impl Staged {
    /// Where it lies until then; `None` where there is nothing to put in place.
    pub fn temporary(&self) -> Option<&Path> {
        self.temporary.as_ref().map(NamedTempFile::path)
    }

    /// Wait until its bytes are on the disk, so that after a power cut the name never means half a file.
    ///
    /// # Errors
    /// Where the operating system could not write them.
    pub fn sync(&self) -> Result<(), CacheError> {
        let Some(temporary) = &self.temporary else { return Ok(()) };
        temporary.as_file().sync_all().map_err(CacheError::io("sync", &self.path))
    }

    /// Put it in its place in one step. The folder that then has the new name, which is on the disk once [`sync_folder`] says so; `None` for
    /// a device.
    ///
    /// # Errors
    /// Where the operating system refuses; then the old file is what it was.
    pub fn put(self) -> Result<Option<PathBuf>, CacheError> {
        let Some(temporary) = self.temporary else { return Ok(None) };
        temporary.persist(&self.target).map_err(|e| CacheError::io("replace", &self.path)(e.error))?;
        Ok(Some(folder_of(&self.target).to_owned()))
    }
}

/// Temporary files that were there when a folder was first looked into: of writers that are gone, or at work. A process that writes many files looks
/// into their folder once.
#[derive(Debug, Default)]
pub struct Strays(Mutex<BTreeMap<PathBuf, Vec<PathBuf>>>);

/// Let `write` fill a new file that will take the place of `path`.
pub(super) fn stage(
    path: &Path,
    strays: &Strays,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<Staged, CacheError> {
    let target = resolve(path).map_err(CacheError::io("write", path))?;
    let existing = fs::metadata(&target).ok();

    // Devices and pipes cannot be replaced; write into them.
    if existing.as_ref().is_some_and(|m| !m.is_file() && !m.is_dir()) {
        let mut file = File::options().write(true).open(&target).map_err(CacheError::io("open", path))?;
        write(&mut file).map_err(CacheError::io("write", path))?;
        return Ok(Staged { path: path.to_owned(), target, temporary: None });
    }

    let (folder, prefix) = (folder_of(&target), temporary_prefix(&target));
    strays.remove_abandoned(folder, &prefix);
    let mut temporary =
        create_locked(folder, &prefix).map_err(CacheError::io("create a temporary file beside", path))?;
    write(temporary.as_file_mut()).map_err(CacheError::io("write", path))?;
    if let Some(existing) = existing {
        temporary
            .as_file()
            .set_permissions(existing.permissions())
            .map_err(CacheError::io("set permissions of", path))?;
    }
    Ok(Staged { path: path.to_owned(), target, temporary: Some(temporary) })
}

/// Stage any other file that shall be old or new as a whole, such as the list of what a cache depends on.
///
/// # Errors
/// Where it cannot be written.
pub fn stage_bytes(path: &Path, strays: &Strays, bytes: &[u8]) -> Result<Staged, CacheError> {
    stage(path, strays, |file| io::Write::write_all(file, bytes))
}

fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// What a chain of symbolic links ends in, so that the links stay.
fn resolve(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..40 {
        match fs::symlink_metadata(&target) {
            Ok(metadata) if metadata.is_symlink() => {
                let link = fs::read_link(&target)?;
                target = target.parent().unwrap_or(Path::new("")).join(link);
            }
            _ => return Ok(target),
        }
    }
    Err(io::Error::other("the symbolic links form a loop"))
}

/// `.scene.bvhc.` for `scene.bvhc`: hidden, and told from the temporary files of its neighbours by the dot.
fn temporary_prefix(target: &Path) -> String {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    format!(".{}.", clip(&name, 200)) // names may have 255 bytes
}

fn create_locked(folder: &Path, prefix: &str) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(SUFFIX).rand_bytes(8);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less what the umask takes
    loop {
        let temporary = builder.tempfile_in(folder)?;
        // File systems without locks exist; there, nothing is ever taken for abandoned.
        if temporary.as_file().lock().is_err() || temporary.path().exists() {
            return Ok(temporary);
        }
        // Another writer took the file for abandoned in the moment before it was locked.
    }
}

impl Strays {
    /// Remove temporary files of the same target whose writers are gone. Nothing depends on it, so errors are passed over.
    fn remove_abandoned(&self, folder: &Path, prefix: &str) {
        let mut folders = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !folders.contains_key(folder) {
            let names = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
            folders.insert(folder.to_owned(), names.filter(|path| random_of(path, ".").is_some()).collect());
        }
        for path in folders.get(folder).into_iter().flatten() {
            let ours =
                random_of(path, prefix).is_some_and(|r| r.len() == 8 && r.bytes().all(|b| b.is_ascii_alphanumeric()));
            if ours
                && let Ok(file) = File::options().write(true).open(path)
                && file.try_lock().is_ok()
            {
                _ = fs::remove_file(path);
            }
        }
    }
}

/// What stands in the name of a temporary file behind `prefix`.
fn random_of(path: &Path, prefix: &str) -> Option<String> {
    let name = path.file_name()?.to_string_lossy();
    Some(name.strip_prefix(prefix)?.strip_suffix(SUFFIX)?.to_owned())
}

/// Wait until the names in a folder are on the disk.
///
/// # Errors
/// Where the operating system could not write them.
#[cfg(unix)]
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Windows has no such call, and needs none for a rename on NTFS.
#[cfg(not(unix))]
pub fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::error::Error;
    use std::io::Write;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bvhc");
        replace(&path, |f| f.write_all(b"old")).unwrap();
        let error = replace(&path, |f| {
            f.write_all(b"ne")?;
            Err(io::Error::other("disk full"))
        });
        let source = error.as_ref().unwrap_err().source().map(ToString::to_string);
        assert_eq!(source.as_deref(), Some("disk full"), "{error:?}");
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"old".to_vec(), vec!["a.bvhc".to_owned()]));
        assert!(replace(&folder.path().join("none/a.bvhc"), |_| Ok(())).is_err());
    }

    #[test]
    fn abandoned_files_go_and_those_of_living_writers_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bvhc");
        let living = create_locked(folder.path(), &temporary_prefix(&path)).unwrap();
        for stray in [".a.bvhc.AAAAAAAA.bvhc-tmp", ".b.bvhc.AAAAAAAA.bvhc-tmp", ".a.bvhc.notes.bvhc-tmp"] {
            fs::write(folder.path().join(stray), "x").unwrap();
        }
        replace(&path, |f| f.write_all(b"new")).unwrap();
        let living = living.path().file_name().unwrap().to_str().unwrap().to_owned();
        let mut want =
            vec![".a.bvhc.notes.bvhc-tmp".to_owned(), ".b.bvhc.AAAAAAAA.bvhc-tmp".into(), "a.bvhc".into(), living];
        want.sort();
        assert_eq!(names(folder.path()), want);
    }

    #[test]
    fn what_is_staged_takes_its_place_when_it_is_put_there_and_else_is_gone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bvhc");
        replace(&path, |f| f.write_all(b"old")).unwrap();
        let strays = Strays::default();
        let staged = stage(&path, &strays, |f| f.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read(staged.temporary().unwrap()).unwrap(), b"new");
        drop(staged);
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"old".to_vec(), vec!["a.bvhc".to_owned()]));

        let staged = stage(&path, &strays, |f| f.write_all(b"new")).unwrap();
        staged.sync().unwrap();
        assert_eq!(staged.put().unwrap().as_deref(), Some(folder.path()));
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"new".to_vec(), vec!["a.bvhc".to_owned()]));
    }

    #[cfg(unix)]
    #[test]
    fn permissions_and_links_are_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a.bvhc"), folder.path().join("link.bvhc"));
        replace(&path, |f| f.write_all(b"1")).unwrap();
        assert_ne!(fs::metadata(&path).unwrap().permissions().mode() & 0o044, 0, "readable as the umask allows");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        symlink("a.bvhc", &link).unwrap();
        replace(&link, |f| f.write_all(b"2")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"2");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        replace(Path::new("/dev/null"), |f| f.write_all(b"3")).unwrap();
    }
}
