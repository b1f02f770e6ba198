use super::corners::Gap;
use super::face::{Faces, read_corners, write_face};
use super::keyword::{Evidence, holds_no_triangle, is_known, is_name_statement};
use super::lines::{Lines, line_end};
use super::parts::{PartName, Parts};
use super::plain;
use super::polygon::{self, LargeFaces};
use super::position::{BYTES_PER_POSITION, Positions, write_position};
use super::words::split_word;
use crate::scene::excerpt::clipped;
use crate::scene::options::BOM;
use crate::scene::source::Source;
use crate::scene::{SceneError, Statement};
use std::io::{self, BufRead, Read};

/// The file's statements as `tobj` gets them: `v`, `f` and `g` statements and nothing else.
///
/// It stands between the file and `tobj` because `tobj` alone would take a polyline for a polygon, refuse text that is not
/// UTF-8, split no lines at a lone carriage return, join none at a backslash, and name no line in its errors. Faces come
/// out with plain vertex numbers from 1, proved to be in range; part names go out as numbers and come back by
/// [`Counts::part_name`].
///
/// A statement that `tobj` may refuse goes out alone, so that its error belongs to the current line. [`plain`] lines, which it cannot, go
/// out many at a time.
pub(super) struct Statements<'a, 's> {
    lines: Lines<'a>,
    source: &'a mut Source<'s>,
    /// What `tobj` is reading, in whole lines, and how much of it is read.
    out: Vec<u8>,
    taken: usize,
    /// Number of the first line of the current statement.
    line: u64,
    positions: Positions,
    faces: Faces,
    /// Vertex numbers of the current face.
    corners: Vec<u64>,
    /// How much cutting large faces takes.
    large: LargeFaces,
    parts: Parts<'a>,
    skipped: u64,
    short_faces: u64,
    /// Positions with a weight other than 1.
    weighted: u64,
    unknown: u64,
    first_unknown: Option<Statement>,
    evidence: Evidence<'a>,
    /// Bytes of memory noted but not yet charged, and bytes of text not yet reported as done.
    unpaid: u64,
    unreported: u64,
    failure: Option<SceneError>,
}

/// What only this reader knows about the file.
pub(super) struct Counts {
    pub skipped: u64,
    pub short_faces: u64,
    pub weighted: u64,
    pub unreferenced: u64,
    /// Statements with a keyword that is not known, and the first of them.
    pub unknown: u64,
    pub first_unknown: Option<Statement>,
    parts: Vec<PartName>,
}

impl Counts {
    /// The names of the part that `tobj` knows by number.
    pub fn part_name(&self, number: &str) -> PartName {
        number.parse::<usize>().ok().and_then(|n| self.parts.get(n)).cloned().unwrap_or_default()
    }
}

/// About so many bytes of plain lines go to `tobj` at once: few enough to stay in the nearest cache.
const BATCH: usize = 1 << 14;

/// Memory is charged and progress reported each time that so many bytes of text are read.
const STEP: u64 = 1 << 20;

impl<'a, 's> Statements<'a, 's> {
    pub fn new(text: &'a [u8], source: &'a mut Source<'s>) -> Self {
        let faces = Faces::new(source.options.vertices);
        Statements {
            lines: Lines::new(text.strip_prefix(BOM).unwrap_or(text)),
            source,
            out: Vec::new(),
            taken: 0,
            line: 0,
            positions: Positions::default(),
            faces,
            corners: Vec::new(),
            large: LargeFaces::default(),
            parts: Parts::default(),
            skipped: 0,
            short_faces: 0,
            weighted: 0,
            unknown: 0,
            first_unknown: None,
            evidence: Evidence::default(),
            unpaid: 0,
            unreported: 0,
            failure: None,
        }
    }

    /// The counts and the corners without a face, or the reason why reading stopped: this reader's own, or what `tobj` found at the current line.
    pub fn finish(mut self, error: Option<&tobj::LoadError>) -> Result<(Counts, Vec<Gap>), SceneError> {
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        let positions = self.positions.count();
        if let Some((vertex, line)) = self.positions.farthest_ahead()
            && (vertex > positions || error.is_some())
        {
            let reason = format!("a face uses vertex {vertex}, but there are {positions} before its group ends");
            return Err(SceneError::malformed_line(self.source.path, line, reason));
        }
        if let Some(error) = error {
            let text = String::from_utf8_lossy(&self.out);
            let not_number = text.split_ascii_whitespace().skip(1).find(|t| t.parse::<f64>().is_err());
            return Err(self.error(match not_number {
                Some(token) => format!("'{token}' is not a number"),
                None => error.to_string(),
            }));
        }
        if let Some((line, resembles)) = self.evidence.foreign() {
            let shown: String = String::from_utf8_lossy(line).chars().take(40).collect();
            let cut = if shown.len() < line.len() { "…" } else { "" };
            let path = self.source.path.to_owned();
            return Err(SceneError::NotObj { path, found: format!("'{shown}{cut}'"), resembles });
        }
        self.pay()?;
        let unreferenced = self.positions.unreferenced();
        let counts = Counts {
            skipped: self.skipped,
            short_faces: self.short_faces,
            weighted: self.weighted,
            unreferenced,
            unknown: self.unknown,
            first_unknown: self.first_unknown,
            parts: self.parts.into_names(),
        };
        Ok((counts, self.faces.into_gaps()))
    }

    /// Go to the next lines that `tobj` shall see.
    fn advance(&mut self) -> Result<(), SceneError> {
        self.taken = 0;
        self.out.clear();
        while self.out.is_empty() && !self.lines.rest().is_empty() {
            let before = self.lines.rest().len();
            self.take_plain_lines()?;
            if self.out.is_empty() && !self.lines.rest().is_empty() {
                self.take_statement()?;
            }
            self.unreported += (before - self.lines.rest().len()) as u64;
            if self.unreported > STEP {
                self.pay()?;
            }
        }
        Ok(())
    }

    /// Take lines as long as they are plain and few enough.
    fn take_plain_lines(&mut self) -> Result<(), SceneError> {
        let (before, in_part) = (self.lines.rest().len(), self.parts.go_on());
        loop {
            let text = self.lines.rest();
            if before - text.len() > BATCH {
                return Ok(());
            }
            let length = match text {
                [b'v', b' ' | b'\t', ..] => {
                    let position = plain::copy_position(text, &mut self.out);
                    if let Some(position) = &position {
                        self.add_position()?;
                        self.weighted += u64::from(position.weighted);
                    }
                    position.map(|position| position.length)
                }
                [b'f', b' ' | b'\t', ..] if in_part => {
                    match plain::copy_face(text, &mut self.positions, &mut self.out) {
                        Some((length, corners)) => {
                            self.line = self.lines.number();
                            self.add_face(corners)?;
                            Some(length)
                        }
                        None => None,
                    }
                }
                [b'v', b'n' | b't', b' ' | b'\t', ..] => plain::passed_over(text),
                [b'#', ..] => {
                    self.lines.skip(line_end(text).1);
                    continue;
                }
                _ => None,
            };
            let Some(length) = length else { return Ok(()) };
            self.evidence.confirm();
            self.lines.skip(length);
        }
    }

    /// Take one statement, of one line or of several.
    fn take_statement(&mut self) -> Result<(), SceneError> {
        self.line = self.lines.number();
        let line = self.lines.take().trim_ascii();
        self.evidence.note(line);
        if line.last() == Some(&b'\\') && !is_name_statement(line) {
            let joined = self.lines.join(line);
            let joined = joined.trim_ascii();
            self.evidence.note_joined(joined);
            self.statement(joined)
        } else if self.parts.name(line) {
            Ok(())
        } else {
            self.statement(line)
        }
    }

    fn statement(&mut self, line: &[u8]) -> Result<(), SceneError> {
        let (keyword, arguments) = split_word(line);
        match keyword {
            b"v" => {
                self.add_position()?;
                let written = write_position(arguments, &mut self.out);
                self.weighted += u64::from(written.map_err(|reason| self.error(reason))?);
            }
            // `fo` is an old name for the same thing, which `tobj` does not know.
            b"f" | b"fo" => self.face(arguments)?,
            _ if holds_no_triangle(keyword) => self.skipped += 1,
            _ if is_known(keyword) => {}
            _ => self.note_unknown(keyword),
        }
        Ok(())
    }

    /// A face; of one or two corners it is a point or a line.
    fn face(&mut self, arguments: &[u8]) -> Result<(), SceneError> {
        let read = read_corners(arguments, self.positions.count(), &mut self.corners);
        read.map_err(|reason| self.error(reason))?;
        for vertex in &self.corners {
            if !self.positions.mark(*vertex) {
                self.positions.mark_ahead(*vertex, self.line);
                self.unpaid += size_of::<u64>() as u64;
            }
        }
        self.add_face(self.corners.len() as u64)?;
        if self.corners.len() < 3 {
            self.skipped += 1;
            self.short_faces += 1;
            return Ok(());
        }
        if !self.parts.go_on() {
            self.unpaid += self.parts.begin(&mut self.out);
        }
        write_face(&self.corners, &mut self.out);
        Ok(())
    }

    fn note_unknown(&mut self, keyword: &[u8]) {
        self.unknown += 1;
        let word = || clipped(&String::from_utf8_lossy(keyword));
        self.first_unknown.get_or_insert_with(|| Statement { line: self.line, word: word() });
    }

    fn add_position(&mut self) -> Result<(), SceneError> {
        self.unpaid += BYTES_PER_POSITION;
        if self.positions.add() { Ok(()) } else { Err(self.too_many("positions")) }
    }

    fn add_face(&mut self, corners: u64) -> Result<(), SceneError> {
        self.unpaid += self.faces.add(corners).map_err(|what| self.too_many(what))?;
        let too_large =
            |what, limit| SceneError::TooMany { path: self.source.path.to_owned(), line: Some(self.line), what, limit };
        if corners > polygon::MAX_CORNERS as u64 {
            return Err(too_large(format!("a face has {corners} corners"), polygon::MAX_CORNERS as u64));
        }
        if !self.large.afford(corners) {
            let what = "the large faces up to here are too many to cut into triangles: their squared numbers of corners add up to more";
            return Err(too_large(what.into(), self.large.allowance()));
        }
        Ok(())
    }

    /// Charge the memory noted so far and report the text read so far.
    fn pay(&mut self) -> Result<(), SceneError> {
        let (unpaid, unreported) = (std::mem::take(&mut self.unpaid), std::mem::take(&mut self.unreported));
        self.source.advance(unreported);
        self.source.charge(unpaid, "its geometry")
    }

    fn error(&self, reason: String) -> SceneError {
        SceneError::malformed_line(self.source.path, self.line, reason)
    }

    fn too_many(&self, what: &str) -> SceneError {
        let what = format!("it has too many {what}");
        SceneError::TooMany { path: self.source.path.to_owned(), line: None, what, limit: u32::MAX.into() }
    }
}

impl BufRead for Statements<'_, '_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken == self.out.len()
            && let Err(failure) = self.advance()
        {
            self.failure = Some(failure);
            return Err(io::ErrorKind::InvalidData.into());
        }
        Ok(&self.out[self.taken..])
    }

    fn consume(&mut self, amount: usize) {
        self.taken += amount;
    }
}

impl Read for Statements<'_, '_> {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        let amount = self.fill_buf()?.read(buf)?;
        self.consume(amount);
        Ok(amount)
    }
}
