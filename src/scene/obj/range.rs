//! One range of a text of everyday statements.

use super::keyword::{holds_no_triangle, is_known, is_name_statement};
use super::lines::{Lines, line_end};
use super::plain;
use super::polygon::LARGE;
use super::position::write_numbers;
use super::words::{Words, parse_digits, split_word};

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
    pub triangles: u64,
    pub skipped: u64,
    /// Positions with a weight other than 1.
    pub weighted: u64,
    /// Places in `corners` of numbers that count from the range's first position on.
    relative: Vec<usize>,
    /// Fewest positions before the range with which each face names what is there.
    ahead: i64,
    /// Statements that name what the faces behind them belong to, one after the other; of each, how many faces of the range are before it and where it ends.
    names: Vec<u8>,
    namings: Vec<(usize, usize)>,
}

impl Range {
    /// Make vertices count from the text's first position; `before` are those before this range. `None` where one is not there.
    pub fn begin_at(&mut self, before: usize) -> Option<()> {
        for place in std::mem::take(&mut self.relative) {
            self.corners[place] = self.corners[place].wrapping_add(before as u32);
        }
        (self.ahead <= before as i64).then_some(())
    }

    /// The statements that name what the faces behind them belong to, and how many faces of the range are before each.
    pub fn namings(&self) -> impl Iterator<Item = (usize, &[u8])> {
        let mut start = 0;
        self.namings.iter().map(move |(faces, end)| (*faces, &self.names[std::mem::replace(&mut start, *end)..*end]))
    }
}

/// Reads ranges one after the other.
pub(super) struct Reader {
    range: Range,
    /// Coordinates that `tobj` has not read yet, in its own statements, and how many positions these are.
    out: Vec<u8>,
    waiting: usize,
    positions: usize,
    /// A face of [`BLOCK`] of its vertices.
    face: String,
}

/// So many vertices are corners of one face.
const BLOCK: usize = 64;

/// `tobj` reads about so many bytes at once: what it makes of them stays in a near cache.
const BATCH: usize = 1 << 16;

impl Reader {
    pub fn new() -> Reader {
        Reader { range: Range::default(), out: Vec::new(), waiting: 0, positions: 0, face: face_of(BLOCK) }
    }

    /// Read a range; `None` where it holds anything but everyday statements.
    pub fn read(&mut self, text: &[u8]) -> Option<Range> {
        (self.range, self.waiting, self.positions) = (Range::default(), 0, 0);
        self.out.clear();
        let mut lines = Lines::new(text);
        while !lines.rest().is_empty() {
            self.plain_line(&mut lines).or_else(|| self.statement(lines.take().trim_ascii()))?;
            if self.out.len() > BATCH {
                self.read_coordinates()?;
            }
        }
        self.read_coordinates()?;
        Some(std::mem::take(&mut self.range))
    }

    /// Take a line as most exporters write them; `None` and nothing done with any other.
    fn plain_line(&mut self, lines: &mut Lines) -> Option<()> {
        let text = lines.rest();
        let length = match text {
            [b'v', b' ' | b'\t', ..] => {
                let position = plain::read_position(text)?;
                self.begin_position();
                self.out.extend_from_slice(&text[position.numbers]);
                self.end_position();
                self.range.weighted += u64::from(position.weighted);
                position.length
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
    fn statement(&mut self, line: &[u8]) -> Option<()> {
        if is_name_statement(line) {
            self.range.names.extend_from_slice(line);
            self.range.namings.push((self.range.faces, self.range.names.len()));
            return Some(());
        }
        if line.last() == Some(&b'\\') {
            return None;
        }
        let (keyword, arguments) = split_word(line);
        match keyword {
            b"v" => {
                self.begin_position();
                self.range.weighted += u64::from(write_numbers(arguments, &mut self.out).ok()?);
                self.end_position();
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

    /// Two positions are one statement for `tobj`, the second in the place of the colour that a vertex may have: each statement costs it more than its
    /// numbers do.
    fn begin_position(&mut self) {
        if self.waiting.is_multiple_of(2) {
            self.out.push(b'v');
        }
    }

    fn end_position(&mut self) {
        self.positions += 1;
        self.waiting += 1;
        if self.waiting.is_multiple_of(2) {
            self.out.push(b'\n');
        }
        // It hands out vertices that faces use.
        if self.waiting.is_multiple_of(2 * BLOCK) {
            self.out.extend_from_slice(self.face.as_bytes());
        }
    }

    /// Let `tobj` read the coordinates that wait for it; `None` where it refuses a statement.
    fn read_coordinates(&mut self) -> Option<()> {
        if self.waiting == 0 {
            return Some(());
        }
        let vertices = self.waiting.div_ceil(2);
        if !self.waiting.is_multiple_of(2) {
            self.out.extend_from_slice(b" 0 0 0\n");
        }
        let handed_out = self.waiting / (2 * BLOCK) * BLOCK;
        if vertices > handed_out {
            self.out.extend_from_slice(face_of(vertices - handed_out).as_bytes());
        }
        let options = tobj::LoadOptions::default();
        let read = tobj::load_obj_buf(&mut &self.out[..], &options, |_| Ok((Vec::new(), Default::default())));
        let mesh = read.ok()?.0.into_iter().next()?.mesh;
        if [mesh.positions.len(), mesh.vertex_color.len()] != [3 * vertices; 2] {
            return None;
        }
        let (first, second) = (mesh.positions.chunks_exact(3), mesh.vertex_color.chunks_exact(3));
        self.range.positions.extend(first.zip(second).flat_map(|(a, b)| [a[0], a[1], a[2], b[0], b[1], b[2]]));
        self.range.positions.truncate(3 * self.positions);
        self.out.clear();
        self.waiting = 0;
        Some(())
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

/// A face of the latest vertices, so many of them.
fn face_of(corners: usize) -> String {
    let numbers: String = (1..=corners).rev().map(|back| format!(" -{back}")).collect();
    format!("f{numbers}\n")
}
