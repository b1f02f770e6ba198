use super::document::{Document, MESHOPT, compressed};
use crate::scene::SceneError;
use crate::scene::source::Source;
use base64::Engine;
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// The bytes of a document's buffers, each fetched when it is first needed.
pub(super) struct Buffers<'b> {
    binary: Option<&'b [u8]>,
    loaded: Vec<Option<Cow<'b, [u8]>>>,
}

impl<'b> Buffers<'b> {
    pub fn new(document: &Document, binary: Option<&'b [u8]>) -> Buffers<'b> {
        Buffers { binary, loaded: vec![None; document.buffers.len()] }
    }

    /// Bytes `byteOffset .. byteOffset + byteLength` of a buffer view, fetching its buffer if need be.
    pub fn view(&mut self, document: &Document, view: usize, source: &mut Source) -> Result<&[u8], SceneError> {
        let Some(json) = document.buffer_views.get(view) else {
            let count = document.buffer_views.len();
            return Err(SceneError::malformed(source.path, format!("it uses buffer view {view}, but has {count}")));
        };
        let index = json.buffer.value();
        self.load(document, index, view, source)?;
        let buffer = self.loaded.get(index).and_then(Option::as_deref).unwrap_or_default();
        let (offset, length) = (json.byte_offset.map_or(0, |o| o.0), json.byte_length.0);
        let end = offset.checked_add(length).filter(|end| *end <= buffer.len() as u64);
        match end {
            Some(end) => Ok(&buffer[offset as usize..end as usize]),
            None => {
                let size = buffer.len();
                let reason =
                    format!("buffer view {view} takes {length} bytes at {offset} of buffer {index}, which has {size}");
                Err(SceneError::malformed(source.path, reason))
            }
        }
    }

    fn load(&mut self, document: &Document, index: usize, view: usize, source: &mut Source) -> Result<(), SceneError> {
        let Some(json) = document.buffers.get(index) else {
            let count = document.buffers.len();
            let reason = format!("buffer view {view} uses buffer {index}, but there are {count}");
            return Err(SceneError::malformed(source.path, reason));
        };
        if self.loaded[index].is_some() {
            return Ok(());
        }
        let mut bytes = match (&json.uri, self.binary) {
            (Some(uri), _) => Cow::Owned(fetch(uri, index, source)?),
            (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
            (None, _) => {
                let mut fallback = json.extensions.iter().flat_map(|e| &e.others).map(|(name, _)| name.as_str());
                let meshopt = fallback.find(|name| MESHOPT.contains(name));
                return Err(meshopt.map_or_else(
                    || {
                        SceneError::malformed(
                            source.path,
                            format!("buffer {index} has no data: no uri and no GLB chunk"),
                        )
                    },
                    |extension| compressed(extension, source),
                ));
            }
        };
        let stated = json.byte_length.0;
        if stated > bytes.len() as u64 {
            let size = bytes.len();
            let reason = format!("buffer {index} has {size} bytes, but its byteLength says {stated}");
            return Err(SceneError::malformed(source.path, reason));
        }
        match &mut bytes {
            Cow::Borrowed(b) => *b = &b[..stated as usize],
            Cow::Owned(b) => b.truncate(stated as usize),
        }
        self.loaded[index] = Some(bytes);
        Ok(())
    }
}

/// The bytes behind a URI: embedded, or a file that the policy lets this model name.
fn fetch(uri: &str, buffer: usize, source: &mut Source) -> Result<Vec<u8>, SceneError> {
    if let Some(data) = uri.strip_prefix("data:") {
        return embedded(data, buffer, source);
    }
    let (path, name) = locate(uri, buffer, source)?;
    let missing =
        |e| SceneError::MissingBuffer { model: source.path.to_owned(), buffer, path: path.clone(), source: e };
    let real = if source.options.allow_outside { path.clone() } else { inside(&path, uri, buffer, source, &missing)? };
    let bytes = match source.read_file(&real) {
        Ok(bytes) => bytes?,
        Err(e) => {
            return Err(SceneError::MissingBuffer { model: source.path.to_owned(), buffer, path, source: e });
        }
    };
    if source.inputs.iter().all(|i| i.path != path) {
        source.add_input(path, name, &bytes);
    }
    source.advance(bytes.len() as u64);
    Ok(bytes)
}

/// The content of a data URI, base64 or percent-encoded.
fn embedded(data: &str, buffer: usize, source: &mut Source) -> Result<Vec<u8>, SceneError> {
    let malformed =
        |what: String| SceneError::malformed(source.path, format!("the data URI of buffer {buffer} {what}"));
    let Some((kind, content)) = data.split_once(',') else {
        return Err(malformed("has no comma before its data".into()));
    };
    let bytes = if kind.ends_with(";base64") {
        LENIENT_BASE64.decode(content).map_err(|e| malformed(format!("is not base64: {e}")))?
    } else {
        percent_decode_str(content).collect()
    };
    source.charge(bytes.len() as u64, "an embedded buffer")?;
    Ok(bytes)
}

/// Standard alphabet; padding and unused last bits may be as they come.
const LENIENT_BASE64: base64::engine::GeneralPurpose = base64::engine::GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    base64::engine::GeneralPurposeConfig::new()
        .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The path that a URI means, and the name to remember it by. Without `allow_outside` only relative paths that stay in the
/// folder pass; the path is judged after percent-decoding, with both kinds of slash.
fn locate(uri: &str, buffer: usize, source: &Source) -> Result<(PathBuf, String), SceneError> {
    let malformed = |why: &str| SceneError::malformed(source.path, format!("buffer {buffer} names '{uri}', {why}"));
    let outside = |why| SceneError::OutsideFolder { model: source.path.to_owned(), buffer, uri: uri.to_owned(), why };
    let decoded = percent_decode_str(uri).decode_utf8().map_err(|_| malformed("which is not UTF-8"))?.into_owned();
    if decoded.contains('\0') {
        return Err(malformed("which has a NUL character"));
    }
    match scheme(uri) {
        Some(scheme) if scheme.eq_ignore_ascii_case("file") => {
            if !source.options.allow_outside {
                return Err(outside("a file: address"));
            }
            let path = PathBuf::from(decoded["file:".len()..].strip_prefix("//").unwrap_or(&decoded["file:".len()..]));
            let name = name_from(source.folder.as_deref(), &path);
            return Ok((path, name));
        }
        Some(_) => return Err(malformed("an address of another kind than a file; only files and data URIs are read")),
        None => {}
    }
    let is_drive = decoded.as_bytes().get(1) == Some(&b':');
    if decoded.starts_with(['/', '\\']) || is_drive || Path::new(&decoded).is_absolute() {
        if !source.options.allow_outside {
            return Err(outside("an absolute path"));
        }
        let path = PathBuf::from(decoded);
        let name = name_from(source.folder.as_deref(), &path);
        return Ok((path, name));
    }
    if climbs_out(&decoded) && !source.options.allow_outside {
        return Err(outside("a path that leaves the model's folder"));
    }
    match &source.folder {
        Some(folder) => Ok((folder.join(&decoded), decoded)),
        None => Err(malformed("but this model does not come from a folder; embed its buffers, or give it a path")),
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
    let (scheme, _) = uri.split_once(':')?;
    let is_scheme = |c: char| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.');
    (scheme.len() > 1 && scheme.starts_with(|c: char| c.is_ascii_alphabetic()) && scheme.chars().all(is_scheme))
        .then_some(scheme)
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
fn inside(
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
    let why = "a symbolic link that leaves the model's folder";
    Err(SceneError::OutsideFolder { model: source.path.to_owned(), buffer, uri: uri.to_owned(), why })
}
