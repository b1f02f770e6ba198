use crate::scene::SceneError;
use crate::scene::options::{BOM, without_padding};
use std::path::Path;

/// The JSON text and the binary chunk of a GLB; anything without the GLB magic is taken to be JSON itself.
///
/// Chunks of unknown types are passed over, as the specification asks (glTF 2.0, 4.4.3).
pub(super) fn split<'b>(bytes: &'b [u8], path: &Path) -> Result<(&'b [u8], Option<&'b [u8]>), SceneError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((text(bytes), None));
    }
    let malformed = |reason: String| SceneError::malformed(path, reason);
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(malformed(format!("the GLB header is cut off: the file has {} of its 12 bytes", bytes.len())));
    };
    if version != 2 {
        return Err(SceneError::UnsupportedVersion { path: path.to_owned(), version: format!("{version}.0") });
    }
    let Some(mut rest) = bytes.get(12..length as usize) else {
        let size = bytes.len();
        return Err(malformed(format!("the GLB header says {length} bytes, but the file has {size}")));
    };

    let (mut json, mut binary) = (None, None);
    for chunk in 0.. {
        if rest.is_empty() {
            break;
        }
        let (Some(size), Some(kind)) = (u32_at(rest, 0), rest.get(4..8)) else {
            return Err(malformed(format!("the header of GLB chunk {chunk} is cut off")));
        };
        let Some(data) = rest.get(8..).and_then(|r| r.get(..size as usize)) else {
            let there = rest.len() - 8;
            return Err(malformed(format!("GLB chunk {chunk} says {size} bytes, but {there} are left")));
        };
        rest = &rest[8 + data.len()..];
        let (slot, name) = match kind {
            b"JSON" => (&mut json, "JSON"),
            b"BIN\0" => (&mut binary, "BIN"),
            _ => continue,
        };
        if slot.replace(data).is_some() {
            return Err(malformed(format!("the GLB has two {name} chunks; one is the most")));
        }
    }
    match json {
        Some(json) => Ok((text(json), binary)),
        None => Err(malformed("the GLB has no JSON chunk".into())),
    }
}

/// Without a mark at its start, and without what pads its end: spaces, as the specification has it, or NUL bytes, as some writers do.
fn text(json: &[u8]) -> &[u8] {
    let json = without_padding(json);
    json.strip_prefix(BOM).unwrap_or(json)
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    let four = bytes.get(offset..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*four))
}
