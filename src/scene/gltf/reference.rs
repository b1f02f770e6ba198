//! References to files: which file a URI in a model means, and whether the model may name it.
//!
//! First comes what the URI means (RFC 3986): its path without query and fragment, percent-decoded, without dot segments. Where there is
//! no such file, it is taken as exporters are known to write it: a file name as it stands, not encoded, or with `\` between folders.

use crate::scene::SceneError;
use crate::scene::error::clipped;
use crate::scene::source::Source;
use percent_encoding::percent_decode_str;
use std::path::{Component, Path, PathBuf};

/// A file that a buffer's URI may mean.
pub(super) struct Place {
    /// The path by which it is opened.
    pub path: PathBuf,
    /// The name to remember it by.
    pub name: String,
}

/// Longest path that is tried: what is longer is no path, but most likely data whose `data:` is missing.
const MAX_PATH: usize = 4096;

/// The file that a URI names. Without `allow_outside` only files in the model's folder pass.
pub(super) fn locate(uri: &str, buffer: usize, source: &Source) -> Result<Place, SceneError> {
    let shown = clipped(uri);
    let malformed = |why: &str| SceneError::malformed(source.path, format!("buffer {buffer} names '{shown}', {why}"));
    if uri.len() > MAX_PATH {
        let what =
            format!("the uri of buffer {buffer} has {} bytes: too many for a path, and it is no data URI", uri.len());
        return Err(SceneError::malformed(source.path, what));
    }
    if is_bare_data(uri) {
        let what = format!("the uri of buffer {buffer} looks like a data URI, and does not begin with 'data:'");
        return Err(SceneError::malformed(source.path, what));
    }
    let candidates = match scheme(uri) {
        Some(scheme) if scheme.eq_ignore_ascii_case("file") => {
            if !source.options.allow_outside {
                return Err(outside(uri, "a file: address", buffer, source));
            }
            let rest = &uri["file:".len()..];
            let path = match rest.strip_prefix("//").map(|r| r.split_at(r.find('/').unwrap_or(r.len()))) {
                None => rest,
                Some((host, path)) if host.is_empty() || host.eq_ignore_ascii_case("localhost") => path,
                Some(_) => return Err(malformed("an address on another machine; only files here are read")),
            };
            candidates(without_drive_slash(path))
        }
        // A colon in a file's own name looks like a scheme, so the name is tried before it is called one.
        Some(_) => {
            let place = place(uri.to_owned(), uri, buffer, source).ok().filter(|p| is_file(&p.path));
            let address = "an address of another kind than a file; only files and data URIs are read";
            return place.ok_or_else(|| malformed(address));
        }
        None => candidates(uri),
    };
    let Some(first) = candidates.first() else {
        return Err(malformed("which is no file name in UTF-8"));
    };
    if first.contains('\0') {
        return Err(malformed("which has a NUL character"));
    }
    let mut meant = None;
    for candidate in candidates {
        let place = place(candidate, uri, buffer, source)?;
        if is_file(&place.path) {
            return Ok(place);
        }
        meant.get_or_insert(place);
    }
    meant.ok_or_else(|| malformed("which is no file name in UTF-8"))
}

/// Whether a URI has the middle of a data URI, and so its data, but not the start of one. What it has is not to be shown.
fn is_bare_data(uri: &str) -> bool {
    uri.split_once(',').is_some_and(|(kind, _)| kind.to_ascii_lowercase().ends_with(";base64"))
}

/// What a URI without a scheme may mean, the best first.
fn candidates(uri: &str) -> Vec<String> {
    let path = uri.split(['?', '#']).next().unwrap_or_default();
    let decoded = |text: &str| percent_decode_str(text).decode_utf8().ok().map(|t| t.into_owned());
    let meant = decoded(path).map(|p| without_dot_segments(&p));
    let mut all = Vec::new();
    for text in [meant, decoded(uri), Some(uri.to_owned())].into_iter().flatten() {
        for text in [text.replace('\\', "/"), text].into_iter().rev() {
            if !text.is_empty() && !all.contains(&text) {
                all.push(text);
            }
        }
    }
    all
}

/// A path without `.` and without `..` where something stands before it (RFC 3986, 5.2.4). Leading `..` stay: whether a model may
/// climb out of its folder is another question.
fn without_dot_segments(path: &str) -> String {
    let (root, relative) = path.strip_prefix('/').map_or(("", path), |rest| ("/", rest));
    let mut kept: Vec<&str> = Vec::new();
    for segment in relative.split('/') {
        match segment {
            "." => {}
            ".." if kept.last().is_some_and(|last| *last != "..") => {
                kept.pop();
            }
            ".." if !root.is_empty() => {}
            _ => kept.push(segment),
        }
    }
    format!("{root}{}", kept.join("/"))
}

/// `C:/x` of the `/C:/x` that a file URI has for it.
fn without_drive_slash(path: &str) -> &str {
    let is_drive =
        |p: &str| p.as_bytes().first().is_some_and(u8::is_ascii_alphabetic) && p.as_bytes().get(1) == Some(&b':');
    path.strip_prefix('/').filter(|p| is_drive(p)).unwrap_or(path)
}

fn is_file(path: &Path) -> bool {
    path.metadata().is_ok_and(|m| !m.is_dir())
}

fn outside(uri: &str, why: &'static str, buffer: usize, source: &Source) -> SceneError {
    SceneError::OutsideFolder { model: source.path.to_owned(), buffer, uri: clipped(uri), why }
}

/// Where a decoded path leads, if the model may name it. The path is judged with both kinds of slash.
fn place(path: String, uri: &str, buffer: usize, source: &Source) -> Result<Place, SceneError> {
    let is_drive = path.as_bytes().get(1) == Some(&b':');
    if path.starts_with(['/', '\\']) || is_drive || Path::new(&path).is_absolute() {
        if !source.options.allow_outside {
            return Err(outside(uri, "an absolute path", buffer, source));
        }
        let path = PathBuf::from(path);
        let name = name_from(source.folder.as_deref(), &path);
        return Ok(Place { path, name });
    }
    if climbs_out(&path) && !source.options.allow_outside {
        return Err(outside(uri, "a path that leaves the model's folder", buffer, source));
    }
    match &source.folder {
        Some(folder) => Ok(Place { path: folder.join(&path), name: path }),
        None => {
            let why = "but this model does not come from a folder; embed its buffers, or give it a path";
            let reason = format!("buffer {buffer} names '{}', {why}", clipped(uri));
            Err(SceneError::malformed(source.path, reason))
        }
    }
}

/// The name of a file that the model names by an absolute path: the way to it from the model's folder, with `/` and, where need be,
/// `..`. Where the two share no folder but the root, that would tell all of the path, and the file's own name has to do.
fn name_from(folder: Option<&Path>, path: &Path) -> String {
    let way = |folder: PathBuf| {
        let shared = folder.components().zip(path.components()).take_while(|(a, b)| a == b).count();
        folder.components().take(shared).find(|c| matches!(c, Component::Normal(_)))?;
        let up = folder.components().skip(shared).map(|_| Some(".."));
        let down = path.components().skip(shared).map(|c| c.as_os_str().to_str());
        let name = up.chain(down).collect::<Option<Vec<_>>>()?.join("/");
        // Links may lead elsewhere than the text of the paths says.
        let same = folder.join(&name).canonicalize().ok()? == path.canonicalize().ok()?;
        same.then_some(name)
    };
    let real = folder.and_then(|f| f.canonicalize().ok()).and_then(way);
    let spelled = || folder.and_then(|f| std::path::absolute(f).ok()).and_then(way);
    real.or_else(spelled).unwrap_or_else(|| path.file_name().unwrap_or_default().to_string_lossy().into_owned())
}

/// The part before the first colon where that is a URI scheme; a single letter is a Windows drive.
fn scheme(uri: &str) -> Option<&str> {
    uri.split_once(':').map(|(scheme, _)| scheme).filter(|s| is_scheme(s))
}

pub(super) fn is_scheme(text: &str) -> bool {
    let may_stand = |c: char| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.');
    text.len() > 1 && text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.chars().all(may_stand)
}

fn climbs_out(path: &str) -> bool {
    let mut depth = 0i64;
    path.split(['/', '\\']).any(|part| {
        depth += match part {
            "" | "." => 0,
            ".." => -1,
            _ => 1,
        };
        depth < 0
    })
}

/// The real path of a file that lies in the model's folder even after every symbolic link is followed.
pub(super) fn inside(
    path: &Path,
    uri: &str,
    buffer: usize,
    source: &Source,
    missing: &dyn Fn(std::io::Error) -> SceneError,
) -> Result<PathBuf, SceneError> {
    let folder = match &source.folder {
        Some(folder) if folder.components().next().is_some_and(|c| c != Component::CurDir) => folder.as_path(),
        _ => Path::new("."),
    };
    let folder = folder.canonicalize().map_err(missing)?;
    let real = path.canonicalize().map_err(missing)?;
    if real.starts_with(&folder) {
        return Ok(real);
    }
    Err(outside(uri, "a symbolic link that leaves the model's folder", buffer, source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_uri_means_comes_first_and_what_exporters_write_after() {
        assert_eq!(candidates("a%20b.bin"), ["a b.bin", "a%20b.bin"]);
        assert_eq!(candidates("data\\tri.bin"), ["data\\tri.bin", "data/tri.bin"]);
        assert_eq!(
            candidates("data%5Ctri.bin?v=2"),
            ["data\\tri.bin", "data/tri.bin", "data\\tri.bin?v=2", "data/tri.bin?v=2", "data%5Ctri.bin?v=2",]
        );
        assert_eq!(candidates("rock#1.bin"), ["rock", "rock#1.bin"]);
        assert_eq!(candidates("100%.bin"), ["100%.bin"]);
        assert_eq!(candidates("%ff"), ["%ff"]);
        assert!(candidates("").is_empty());
    }

    #[test]
    fn dot_segments_go_and_leading_ones_stay() {
        for (path, want) in [
            ("./a/./b", "a/b"),
            ("a/../b", "b"),
            ("a/../../b", "../b"),
            ("../../b", "../../b"),
            ("/a/../../b", "/b"),
            ("a//b/..", "a/"),
            ("..a/b.", "..a/b."),
        ] {
            assert_eq!(without_dot_segments(path), want, "{path}");
        }
    }
}
