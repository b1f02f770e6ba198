//! What stands in the place of a model, by how it begins.

use std::fmt;

/// What a file that is no model looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Resemblance {
    /// The pointer that Git LFS leaves in the place of a large file.
    LfsPointer,
    /// HTML or XML.
    WebPage,
    /// An OBJ with keywords in capitals.
    Capitals,
    /// Text of two bytes a character.
    Utf16,
    /// A file of trees that are built already.
    CacheFile,
    /// JSON, so perhaps a glTF.
    Json,
    /// A glTF in its binary form.
    Glb,
    /// Text with statements of OBJ.
    Obj,
    /// Nothing that is known.
    Nothing,
}

impl Resemblance {
    /// What servers and version control leave in the place of a file, where these bytes are surely that: they may be any data.
    pub(super) fn of_stand_in(bytes: &[u8]) -> Option<Resemblance> {
        let text = bytes.trim_ascii_start();
        let begins = |with: &[u8]| text.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with));
        if begins(b"version https://git-lfs") {
            Some(Resemblance::LfsPointer)
        } else if begins(b"<!doctype") || begins(b"<html") || begins(b"<?xml") {
            Some(Resemblance::WebPage)
        } else {
            None
        }
    }

    /// Text of two bytes a character, told by its mark or by the NULs in its first characters. No model begins so.
    pub(super) fn of_wide_text(bytes: &[u8]) -> Option<Resemblance> {
        let is_marked =
            matches!(bytes, [0xff, 0xfe, rest @ ..] if !rest.starts_with(&[0, 0])) || bytes.starts_with(&[0xfe, 0xff]);
        let is_ascii = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
        let is_wide = match bytes {
            [a, 0, b, 0, ..] | [0, a, 0, b, ..] => is_ascii(*a) && is_ascii(*b),
            _ => false,
        };
        (is_marked || is_wide).then_some(Resemblance::Utf16)
    }

    /// A cache file, told by its signature.
    pub(super) fn of_cache(bytes: &[u8]) -> Option<Resemblance> {
        bytes.starts_with(&bvhc_core::layout::MAGIC).then_some(Resemblance::CacheFile)
    }

    /// A GLB, told by its signature, which no text has at its start.
    pub(super) fn of_glb(bytes: &[u8]) -> Option<Resemblance> {
        bytes.starts_with(b"glTF\x02\0\0\0").then_some(Resemblance::Glb)
    }

    /// What a text most likely is that is no model.
    pub(super) fn of_text(text: &[u8]) -> Resemblance {
        Resemblance::of_stand_in(text).unwrap_or(match text.trim_ascii_start().first() {
            Some(b'<') => Resemblance::WebPage,
            Some(b'{') => Resemblance::Json,
            _ => Resemblance::Nothing,
        })
    }
}

impl fmt::Display for Resemblance {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Resemblance::LfsPointer => "a Git LFS pointer",
            Resemblance::WebPage => "a web page",
            Resemblance::Capitals => "an OBJ in capitals",
            Resemblance::Utf16 => "text in UTF-16",
            Resemblance::CacheFile => "a cache file of trees",
            Resemblance::Json => "JSON",
            Resemblance::Glb => "a GLB model",
            Resemblance::Obj => "an OBJ model",
            Resemblance::Nothing => "something else",
        })
    }
}
