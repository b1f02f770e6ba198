use super::data_uri;
use super::document::Document;
use super::extensions::{MESHOPT, compressed};
use super::reference::{Place, inside, locate};
use crate::scene::error::clipped;
use crate::scene::source::Source;
use crate::scene::{Resemblance, SceneError};
use std::borrow::Cow;

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
        let index = json.buffer.0 as usize;
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
            (Some(uri), _) => {
                let bytes = fetch(uri, index, source)?;
                source.keep(bytes.len() as u64);
                Cow::Owned(bytes)
            }
            (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
            (None, _) => {
                let mut fallback = json.extensions.iter().flat_map(|e| e.keys()).map(String::as_str);
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
    if let Some(data) = data_uri::strip_scheme(uri) {
        // Decoded data are never longer than their text.
        source.charge(data.len() as u64, "an embedded buffer")?;
        let bytes = data_uri::decode(data)
            .map_err(|what| SceneError::malformed(source.path, format!("the data URI of buffer {buffer} {what}")))?;
        source.release((data.len() - bytes.len()) as u64);
        return Ok(bytes);
    }
    let Place { path, name } = locate(uri, buffer, source)?;
    let missing =
        |e| SceneError::MissingBuffer { model: source.path.to_owned(), buffer, path: path.clone(), source: e };
    let real = if source.options.allow_outside { path.clone() } else { inside(&path, uri, buffer, source, &missing)? };
    let bytes = match source.read_file(&real) {
        Ok(bytes) => bytes?,
        Err(e) => {
            return Err(SceneError::MissingBuffer { model: source.path.to_owned(), buffer, path, source: e });
        }
    };
    if let Some(resembles) = Resemblance::of_stand_in(&bytes) {
        let what = format!("buffer {buffer}, {},", clipped(&path.to_string_lossy()));
        return Err(SceneError::InPlaceOfData { path: source.path.to_owned(), what, resembles });
    }
    if source.inputs.iter().all(|i| i.path != path) {
        source.add_input(path, name, &bytes);
    }
    source.advance(bytes.len() as u64);
    Ok(bytes)
}
