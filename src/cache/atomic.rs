//! Replacing a file in one step.
//!
//! A writer locks its temporary file for as long as it lives. Whoever comes next tries each temporary file of the same
//! target: one whose lock is free belongs to nobody any more and is removed. So a killed writer leaves at most one file, and the next
//! one cleans it away, without ever touching the file of a writer that is still at work.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::CacheError;
use bvhc_core::cache::parts::clip;

const SUFFIX: &str = ".bvhc-tmp";

/// Let `write` fill a new file, then put it in the place of `path`. On any error `path` is what it was.
pub(super) fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), CacheError> {
    let target = resolve(path).map_err(CacheError::io("write", path))?;
    let existing = fs::metadata(&target).ok();

    // Devices and pipes cannot be replaced; write into them.
    if existing.as_ref().is_some_and(|m| !m.is_file() && !m.is_dir()) {
        let mut file = File::options().write(true).open(&target).map_err(CacheError::io("open", path))?;
        return write(&mut file).map_err(CacheError::io("write", path));
    }

    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let prefix = temporary_prefix(&target);
    remove_abandoned(folder, &prefix);
    let mut temporary =
        create_locked(folder, &prefix).map_err(CacheError::io("create a temporary file beside", path))?;
    write(temporary.as_file_mut()).map_err(CacheError::io("write", path))?;
    if let Some(existing) = existing {
        temporary
            .as_file()
            .set_permissions(existing.permissions())
            .map_err(CacheError::io("set permissions of", path))?;
    }

    // The new bytes reach the disk before the name does, so that after a power cut the name never means half a file.
    temporary.as_file().sync_all().map_err(CacheError::io("sync", path))?;
    temporary.persist(&target).map_err(|e| CacheError::io("replace", path)(e.error))?;
    sync_folder(folder).map_err(CacheError::io("sync the folder of", path))
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

/// Remove temporary files of the same target whose writers are gone. Nothing depends on it, so errors are passed over.
fn remove_abandoned(folder: &Path, prefix: &str) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let random = name.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(SUFFIX));
        let ours = random.is_some_and(|r| r.len() == 8 && r.bytes().all(|b| b.is_ascii_alphanumeric()));
        if ours
            && let Ok(file) = File::options().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Windows has no such call, and needs none for a rename on NTFS.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
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
