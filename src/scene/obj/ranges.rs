//! Texts of everyday statements, read in ranges side by side.
//!
//! ```text
//! text ─ ranges of whole lines ─▶ each: positions by `tobj`, numbers of vertices, names ─▶ one after the other: parts
//! ```
//!
//! A range needs to know nothing of those before it: numbers that count back are put right once it is known how many positions there are
//! before their range. Whatever depends on more than its own line leaves the whole text to [`super::statements`]: an error, a limit, a face of
//! fewer than three corners or of very many, a position that comes behind its face, a statement that goes on in the next line. That
//! reader alone words errors, so that there is one account of each.

use super::face::{BYTES_PER_CORNER, BYTES_PER_FACE};
use super::keyword::{holds_no_triangle, is_known, is_name_statement};
use super::lines::{Lines, line_end};
use super::parts::{PartName, Parts};
use super::plain;
use super::polygon::LARGE;
use super::position::{BYTES_PER_POSITION, write_position};
use super::words::{Words, parse_digits, split_word};
use crate::scene::options::BOM;
use crate::scene::source::Source;

/// About so many bytes of text are one range. Neither this nor the number of threads changes what is read.
pub(super) const RANGE: usize = 1 << 19;

/// So many ranges are read before progress is reported again.
const GROUP: usize = 64;

/// What a text of everyday statements says.
#[derive(Debug)]
pub(super) struct Everyday {
    pub ranges: Vec<Range>,
    /// Where parts begin: numbers of faces, counted from 0 over the whole text, in order.
    pub parts: Vec<(usize, PartName)>,
    /// Positions and triangles in all.
    pub positions: usize,
    pub triangles: usize,
    /// Statements that hold no triangle, such as `l` and `p`.
    pub skipped: u64,
}

/// What whole lines next to each other say.
#[derive(Debug, Default)]
pub(super) struct Range {
    /// Three coordinates for each `v`.
    pub positions: Vec<f64>,
    /// Vertices of all faces one after the other, counted from 0 over the whole text.
    pub corners: Vec<u32>,
    /// How many corners each face has; empty where all have three.
    pub arities: Vec<u32>,
    pub faces: usize,
    triangles: u64,
    skipped: u64,
    /// Places in `corners` of numbers that count from the range's first position on.
    relative: Vec<usize>,
    /// Fewest positions before the range with which each face names what is there.
    ahead: i64,
}

/// A statement that names what the faces behind it belong to, and how many faces of its range are before it.
type Naming<'a> = (usize, &'a [u8]);

/// Read a text in ranges of about so many bytes; `None`, and nothing charged, where it holds anything else.
pub(super) fn read(text: &[u8], range: usize, source: &mut Source) -> Option<Everyday> {
    // What ranges hold of the shortest statements, before it is known what there is to be charged for.
    if source.available() < 5 * text.len() as u64 {
        return None;
    }
    let pieces = cut(text.strip_prefix(BOM).unwrap_or(text), range);
    let mut ranges = Vec::with_capacity(pieces.len());
    let (mut positions, mut faces, mut triangles, mut corners, mut skipped) = (0usize, 0usize, 0u64, 0u64, 0u64);
    let (mut parts, mut starts, mut bytes) = (Parts::default(), Vec::new(), 0);
    for group in pieces.chunks(GROUP) {
        let read = source.exec().map(group.to_vec(), |_, piece| Reader::new().read(piece));
        for (range, namings) in read {
            let (mut range, namings) = (range?, namings);
            range.begin_at(positions)?;
            note_parts(&mut parts, &namings, range.faces, |parts, face| {
                bytes += parts.begin(&mut Vec::new());
                starts.push(faces + face);
            });
            positions += range.positions.len() / 3;
            faces += range.faces;
            triangles += range.triangles;
            corners += range.corners.len() as u64;
            skipped += range.skipped;
            ranges.push(range);
        }
        if (positions as u64).max(corners).max(triangles) > u64::from(u32::MAX) {
            return None;
        }
    }
    let numbers = if source.options.vertices { size_of::<[u32; 3]>() as u64 * triangles } else { 0 };
    let lists = BYTES_PER_POSITION * positions as u64 + BYTES_PER_FACE * faces as u64 + BYTES_PER_CORNER * corners;
    if triangles == 0 || source.charge(lists + numbers + bytes, "its geometry").is_err() {
        return None;
    }
    source.advance(text.len() as u64);
    let parts = starts.into_iter().zip(parts.into_names()).collect();
    Some(Everyday { ranges, parts, positions, triangles: triangles as usize, skipped })
}

/// A text in pieces of whole lines.
fn cut(text: &[u8], range: usize) -> Vec<&[u8]> {
    let (mut pieces, mut rest) = (Vec::new(), text);
    while rest.len() > range {
        let Some(end) = rest[range..].iter().position(|b| *b == b'\n') else { break };
        let (piece, tail) = rest.split_at(range + end + 1);
        pieces.push(piece);
        rest = tail;
    }
    pieces.push(rest);
    pieces
}

/// Go over the faces of a range and call `begin` where a part begins, with the number of its first face.
fn note_parts<'a>(
    parts: &mut Parts<'a>,
    namings: &[Naming<'a>],
    faces: usize,
    mut begin: impl FnMut(&mut Parts<'a>, usize),
) {
    let mut face = 0;
    let ends = namings.iter().map(|(before, line)| (*before, Some(*line))).chain([(faces, None)]);
    for (end, line) in ends {
        if end > face && !parts.go_on() {
            begin(parts, face);
        }
        face = end;
        if let Some(line) = line {
            parts.name(line);
        }
    }
}

impl Range {
    /// Make vertices count from the text's first position; `before` are those before this range. `None` where one is not there.
    fn begin_at(&mut self, before: usize) -> Option<()> {
        for place in std::mem::take(&mut self.relative) {
            self.corners[place] = self.corners[place].wrapping_add(before as u32);
        }
        (self.ahead <= before as i64).then_some(())
    }
}

/// Reads one range.
struct Reader<'a> {
    range: Range,
    namings: Vec<Naming<'a>>,
    /// The positions so far, as `tobj` gets them: it hands out those that faces use, so that faces of the latest ones stand between them.
    out: Vec<u8>,
    positions: usize,
    face: String,
}

/// So many positions are corners of one face.
const BLOCK: usize = 64;

impl<'a> Reader<'a> {
    fn new() -> Reader<'a> {
        let (range, namings, out) = (Range::default(), Vec::new(), Vec::new());
        Reader { range, namings, out, positions: 0, face: face_of(BLOCK) }
    }

    fn read(mut self, text: &'a [u8]) -> (Option<Range>, Vec<Naming<'a>>) {
        let mut lines = Lines::new(text);
        while !lines.rest().is_empty() {
            if self.plain_line(&mut lines).or_else(|| self.statement(lines.take().trim_ascii())).is_none() {
                return (None, Vec::new());
            }
        }
        if !self.positions.is_multiple_of(BLOCK) {
            self.out.extend_from_slice(face_of(self.positions % BLOCK).as_bytes());
        }
        let Some(positions) = coordinates(&self.out, self.positions) else { return (None, Vec::new()) };
        self.range.positions = positions;
        (Some(self.range), self.namings)
    }

    /// Take a line as most exporters write them; `None` and nothing done with any other.
    fn plain_line(&mut self, lines: &mut Lines<'a>) -> Option<()> {
        let text = lines.rest();
        let length = match text {
            [b'v', b' ' | b'\t', ..] => {
                let length = plain::copy_position(text, &mut self.out)?;
                self.note_position();
                length
            }
            [b'f', b' ' | b'\t', ..] => {
                let (first, ahead) = (self.range.corners.len(), self.range.ahead);
                let read = plain::read_face(text, |vertex| self.add_corner(vertex));
                let Some((length, _)) = read.filter(|(_, corners)| self.end_face(*corners).is_some()) else {
                    self.range.corners.truncate(first);
                    self.range.ahead = ahead;
                    return None;
                };
                length
            }
            [b'v', b'n' | b't', b' ' | b'\t', ..] => plain::passed_over(text)?,
            [b'#', ..] => line_end(text).1,
            _ => return None,
        };
        lines.skip(length);
        Some(())
    }

    /// Take any statement of one line; `None` where it is not for this reader.
    fn statement(&mut self, line: &'a [u8]) -> Option<()> {
        if is_name_statement(line) {
            self.namings.push((self.range.faces, line));
            return Some(());
        }
        if line.last() == Some(&b'\\') {
            return None;
        }
        let (keyword, arguments) = split_word(line);
        match keyword {
            b"v" => {
                write_position(arguments, &mut self.out).ok()?;
                self.note_position();
            }
            b"f" | b"fo" => {
                let before = self.range.corners.len();
                for word in Words(arguments) {
                    match parse_digits(word) {
                        Some(vertex) if vertex > 0 => self.add_corner(vertex).then_some(())?,
                        _ => self.add_relative(word)?,
                    }
                }
                self.end_face((self.range.corners.len() - before) as u64)?;
            }
            _ if holds_no_triangle(keyword) => self.range.skipped += 1,
            _ if is_known(keyword) => {}
            _ => return None,
        }
        Some(())
    }

    fn note_position(&mut self) {
        self.positions += 1;
        if self.positions.is_multiple_of(BLOCK) {
            self.out.extend_from_slice(self.face.as_bytes());
        }
    }

    /// Add a corner by its number from 1. False where no list is so long.
    fn add_corner(&mut self, vertex: u64) -> bool {
        let Some(corner) = vertex.checked_sub(1).and_then(|v| u32::try_from(v).ok()) else { return false };
        self.range.ahead = self.range.ahead.max(vertex as i64 - self.positions as i64);
        self.range.corners.push(corner);
        true
    }

    /// Add a corner by a number that counts back from the latest position.
    fn add_relative(&mut self, word: &[u8]) -> Option<()> {
        let digits = word.split(|b| *b == b'/').next()?;
        let back = std::str::from_utf8(digits).ok()?.parse::<i32>().ok().filter(|number| *number < 0)?;
        let corner = self.positions as i64 + i64::from(back);
        self.range.ahead = self.range.ahead.max(-corner);
        self.range.relative.push(self.range.corners.len());
        self.range.corners.push(corner as u32); // less than 0 wraps around, and back when the positions before are added
        Some(())
    }

    /// The latest corners are a face. `None` where it is none, or one that many others decide about.
    fn end_face(&mut self, corners: u64) -> Option<()> {
        if !(3..=LARGE).contains(&corners) {
            return None;
        }
        let range = &mut self.range;
        if corners != 3 && range.arities.is_empty() {
            range.arities.resize(range.faces, 3);
        }
        if corners != 3 || !range.arities.is_empty() {
            range.arities.push(corners as u32);
        }
        range.faces += 1;
        range.triangles += corners - 2;
        Some(())
    }
}

/// A face of the latest positions, so many of them.
fn face_of(corners: usize) -> String {
    let numbers: String = (1..=corners).rev().map(|back| format!(" -{back}")).collect();
    format!("f{numbers}\n")
}

/// The coordinates of so many positions, as `tobj` reads them; `None` where it refuses a statement.
fn coordinates(statements: &[u8], count: usize) -> Option<Vec<f64>> {
    let options = tobj::LoadOptions::default();
    let (models, _) = tobj::load_obj_buf(&mut &*statements, &options, |_| Ok((Vec::new(), Default::default()))).ok()?;
    let positions = models.into_iter().next().map_or_else(Vec::new, |model| model.mesh.positions);
    (positions.len() == 3 * count).then_some(positions)
}
