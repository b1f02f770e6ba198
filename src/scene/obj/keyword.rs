//! Keywords: what a statement's first word says about it and about the file.

use super::words::split_word;
use crate::scene::Resemblance;

/// Keywords that every exporter writes. Others, such as `end` or `call`, may begin a line of any text.
const KEYWORDS: [&[u8]; 13] =
    [b"v", b"vn", b"vt", b"vp", b"f", b"fo", b"l", b"p", b"o", b"g", b"s", b"usemtl", b"mtllib"];

/// All other keywords of the format and its older versions that place no triangle, and two that readers agree on: `t` for creases and `vw` for
/// skin weights. `call` reads another file and `csh` runs a command, so these two are not among them.
const OTHERS: [&[u8]; 32] = [
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"mg",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"maplib",
    b"usemap",
    b"bsp",
    b"bzp",
    b"cdc",
    b"cdp",
    b"res",
    b"t",
    b"vw",
];

/// Whether a statement with this keyword may be passed over without a word. A comment and nothing at all may.
pub(super) fn is_known(keyword: &[u8]) -> bool {
    keyword.is_empty() || keyword.starts_with(b"#") || KEYWORDS.contains(&keyword) || OTHERS.contains(&keyword)
}

/// Whether a statement holds what is drawn and is no triangle: lines, points, curves and surfaces.
pub(super) fn holds_no_triangle(keyword: &[u8]) -> bool {
    matches!(keyword, b"l" | b"p" | b"curv" | b"curv2" | b"surf" | b"bsp" | b"bzp" | b"cdc" | b"cdp")
}

/// Whether a statement's text runs to the end of its line: a backslash there is part of a name.
pub(super) fn is_name_statement(line: &[u8]) -> bool {
    line.starts_with(b"#") || matches!(split_word(line).0, b"o" | b"g" | b"usemtl" | b"mtllib")
}

/// What the lines so far say for and against the file's being an OBJ model.
#[derive(Debug, Default)]
pub(super) struct Evidence<'a> {
    is_obj: bool,
    /// The first line that is no statement of OBJ and no comment.
    foreign: Option<&'a [u8]>,
}

impl<'a> Evidence<'a> {
    /// Take in a statement of OBJ.
    pub fn confirm(&mut self) {
        self.is_obj = true;
    }

    /// Take in any line.
    pub fn note(&mut self, line: &'a [u8]) {
        if self.is_obj {
            return;
        }
        if is_statement(line) {
            self.is_obj = true;
        } else if self.foreign.is_none() && !line.is_empty() && !line.starts_with(b"#") && line != b"\\" {
            self.foreign = Some(line);
        }
    }

    /// Take in a statement of several lines, of which the first was noted.
    pub fn note_joined(&mut self, line: &[u8]) {
        self.is_obj = self.is_obj || is_statement(line);
    }

    /// The line that shows a file without any statement of OBJ to be something else, and what the file may be.
    pub fn foreign(&self) -> Option<(&'a [u8], Resemblance)> {
        let line = self.foreign.filter(|_| !self.is_obj)?;
        let is_in_capitals = is_statement(&line.to_ascii_lowercase());
        Some((line, if is_in_capitals { Resemblance::Capitals } else { Resemblance::of_text(line) }))
    }
}

fn is_statement(line: &[u8]) -> bool {
    KEYWORDS.contains(&split_word(line).0)
}
