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
    /// JSON, so perhaps a glTF.
    Json,
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
            Resemblance::Json => "JSON",
            Resemblance::Nothing => "something else",
        })
    }
}
