use super::corners::Gap;
use super::names::{part_name, readable};
use super::words::{Words, parse_digits, split_word};
use crate::scene::options::BOM;
use crate::scene::source::Source;
use crate::scene::{Resemblance, SceneError};
use std::io::{self, BufRead, Read};

/// The file's statements as `tobj` gets them: one `v`, `f` or `g` statement at a time and nothing else.
///
/// It stands between the file and `tobj` because `tobj` alone would take a polyline for a polygon, refuse text that is not
/// UTF-8, split no lines at a lone carriage return, join none at a backslash, and name no line in its errors. Faces come
/// out with plain vertex numbers from 1, proved to be in range; part names go out as numbers and come back by
/// [`Counts::part_name`].
pub(super) struct Statements<'a, 's> {
    rest: &'a [u8],
    source: &'a mut Source<'s>,
    /// The statement that `tobj` is reading, with its newline, and how much of it is read: a line of the file where that can
    /// pass as it is, otherwise what was made of it.
    plain: &'a [u8],
    out: Vec<u8>,
    taken: usize,
    /// Number of the first line of the current statement, and lines used up so far.
    line: u64,
    lines: u64,
    /// For each position so far, whether a face uses it.
    used: Vec<bool>,
    positions: u64,
    triangles: u64,
    /// Faces and corners of `f` and `fo` so far, and those corners that belong to no face, where corners are numbered.
    faces: u64,
    corners: u64,
    gaps: Vec<Gap>,
    /// Vertex numbers that faces use before their positions are there, and the largest of them with its line.
    ahead: Vec<u64>,
    farthest: Option<(u64, u64)>,
    /// What the statements so far say of the next face, and what held for the latest.
    run: Run<'a>,
    latest: Option<Run<'a>>,
    parts: Vec<PartName>,
    skipped: u64,
    /// Whether any line is a statement that OBJ files are made of, and the first line that is none and no comment either.
    is_obj: bool,
    foreign: Option<&'a [u8]>,
    /// Bytes of memory noted but not yet charged, and bytes of text not yet reported as done.
    unpaid: u64,
    unreported: u64,
    failure: Option<SceneError>,
}

/// What a face belongs to, as bytes. Faces next to each other that belong to the same are one part.
#[derive(Clone, Copy, Default, PartialEq)]
struct Run<'a> {
    /// How many `o` there were: two objects of one name are two.
    objects: u64,
    object: &'a [u8],
    group: &'a [u8],
    material: &'a [u8],
}

/// What a part is called; see [`part_name`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PartName {
    pub name: String,
    pub material: String,
}

/// What only this reader knows about the file.
pub(super) struct Counts {
    pub skipped: u64,
    pub unreferenced: u64,
    parts: Vec<PartName>,
}

impl Counts {
    /// The names of the part that `tobj` knows by number.
    pub fn part_name(&self, number: &str) -> PartName {
        number.parse::<usize>().ok().and_then(|n| self.parts.get(n)).cloned().unwrap_or_default()
    }
}

/// What `tobj` and this reader hold for each position (the list itself, the model's copy, the index map's entry, the mesh's) …
const BYTES_PER_POSITION: u64 = 112;
/// … for each face (`tobj`'s enum) and for each corner (its three indices, the model's index, our triangle).
const BYTES_PER_FACE: u64 = 112;
const BYTES_PER_CORNER: u64 = 48;

impl<'a, 's> Statements<'a, 's> {
    pub fn new(text: &'a [u8], source: &'a mut Source<'s>) -> Self {
        Statements {
            rest: text.strip_prefix(BOM).unwrap_or(text),
            source,
            plain: &[],
            out: Vec::new(),
            taken: 0,
            line: 0,
            lines: 0,
            used: Vec::new(),
            positions: 0,
            triangles: 0,
            faces: 0,
            corners: 0,
            gaps: Vec::new(),
            ahead: Vec::new(),
            farthest: None,
            run: Run::default(),
            latest: None,
            parts: Vec::new(),
            skipped: 0,
            is_obj: false,
            foreign: None,
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
        if let Some((vertex, line)) = self.farthest
            && (vertex > self.positions || error.is_some())
        {
            let reason = format!("a face uses vertex {vertex}, but there are {} before its group ends", self.positions);
            return Err(SceneError::malformed_line(self.source.path, line, reason));
        }
        if let Some(error) = error {
            let text = String::from_utf8_lossy(self.current());
            let not_number = text.split_ascii_whitespace().skip(1).find(|t| t.parse::<f64>().is_err());
            let reason = match not_number {
                Some(token) => format!("'{token}' is not a number"),
                None => error.to_string(),
            };
            return Err(SceneError::malformed_line(self.source.path, self.line, reason));
        }
        if let Some(line) = self.foreign.filter(|_| !self.is_obj) {
            return Err(not_obj(line, self.source));
        }
        for vertex in self.ahead.drain(..) {
            self.used[vertex as usize - 1] = true;
        }
        self.pay()?;
        let counts = Counts {
            skipped: self.skipped,
            unreferenced: self.used.iter().filter(|u| !**u).count() as u64,
            parts: self.parts,
        };
        Ok((counts, self.gaps))
    }

    /// The statement at hand; empty at the end of the file.
    fn current(&self) -> &[u8] {
        if self.plain.is_empty() { &self.out } else { self.plain }
    }

    /// Go to the next statement that `tobj` shall see.
    fn advance(&mut self) -> Result<(), SceneError> {
        (self.plain, self.taken) = (&[], 0);
        self.out.clear();
        while self.current().is_empty() && !self.rest.is_empty() {
            let before = self.rest;
            self.line = self.lines + 1;
            let line = self.take_line();
            let length = before.len() - self.rest.len();
            let trimmed = line.trim_ascii();
            self.note_keyword(trimmed);
            if trimmed.last() == Some(&b'\\') && !is_name_statement(trimmed) {
                let joined = self.join_lines(trimmed);
                let joined = joined.trim_ascii();
                self.is_obj |= KEYWORDS.contains(&split_word(joined).0);
                if self.statement(joined)? {
                    self.write_line(joined);
                }
            } else if self.name(trimmed) {
                // Names are kept as they stand in the file.
            } else if self.statement(trimmed)? {
                match before[length - 1] {
                    b'\n' if self.out.is_empty() => self.plain = &before[..length],
                    _ => self.write_line(trimmed),
                }
            }
            self.unreported += length as u64;
            if self.unreported > 1 << 20 {
                self.pay()?;
            }
        }
        Ok(())
    }

    /// The text up to the next newline, which may be `\n`, `\r\n` or `\r`.
    fn take_line(&mut self) -> &'a [u8] {
        let text = self.rest;
        self.lines += 1;
        match text.iter().position(|&b| b == b'\n' || b == b'\r') {
            Some(end) => {
                let newline = if text[end..].starts_with(b"\r\n") { 2 } else { 1 };
                self.rest = &text[end + newline..];
                &text[..end]
            }
            None => {
                self.rest = &[];
                text
            }
        }
    }

    /// A statement that goes on where its lines end in a backslash.
    fn join_lines(&mut self, first: &[u8]) -> Vec<u8> {
        let mut joined = first.to_vec();
        while joined.last() == Some(&b'\\') {
            joined.pop();
            joined.push(b' ');
            if self.rest.is_empty() {
                break;
            }
            joined.extend_from_slice(self.take_line().trim_ascii());
        }
        joined
    }

    /// Note whether a line speaks for or against the file being an OBJ model.
    fn note_keyword(&mut self, line: &'a [u8]) {
        let keyword = split_word(line).0;
        if KEYWORDS.contains(&keyword) {
            self.is_obj = true;
        } else if self.foreign.is_none() && !line.is_empty() && !line.starts_with(b"#") && line != b"\\" {
            self.foreign = Some(line);
        }
    }

    /// Take in a statement that names what the faces after it belong to. False for any other statement.
    fn name(&mut self, line: &'a [u8]) -> bool {
        let (keyword, name) = split_word(line);
        let name = name.trim_ascii();
        match keyword {
            b"o" => {
                self.run.objects += 1;
                self.run.object = name;
            }
            b"g" => self.run.group = name,
            b"usemtl" => self.run.material = name,
            _ => return false,
        }
        true
    }

    fn write_line(&mut self, line: &[u8]) {
        self.out.extend_from_slice(line);
        self.out.push(b'\n');
    }

    /// Take in one statement. True if `tobj` can have its text as it stands; otherwise what it shall have is in `out`.
    fn statement(&mut self, line: &[u8]) -> Result<bool, SceneError> {
        let (keyword, arguments) = split_word(line);
        match keyword {
            b"v" => return self.position(arguments),
            b"f" | b"fo" => {
                let passes = self.face(arguments)?;
                if keyword == b"f" || !passes {
                    return Ok(passes);
                }
                // `fo` is an old name for the same thing, which `tobj` does not know.
                self.out.push(b'f');
                self.write_line(arguments);
            }
            b"l" | b"p" | b"curv" | b"curv2" | b"surf" => self.skipped += 1,
            _ => {}
        }
        Ok(false)
    }

    /// `v x y z`. What follows is cut off: a weight, which only rational curves and surfaces have, or a colour.
    fn position(&mut self, arguments: &[u8]) -> Result<bool, SceneError> {
        let mut words = Words(arguments);
        let mut first: [&[u8]; 3] = [&[]; 3];
        let mut count = 0;
        let mut is_odd = false;
        for word in &mut words {
            if count < 3 {
                first[count] = word;
                is_odd |= !word.is_ascii() || word.contains(&b'#') || word.contains(&b'(');
            }
            count += 1;
        }
        if count < 3 {
            return Err(self.error(format!("a position has {count} coordinates; it needs 3")));
        }
        self.positions += 1;
        if self.positions > u64::from(u32::MAX) {
            return Err(self.too_many("positions"));
        }
        self.used.push(false);
        self.unpaid += BYTES_PER_POSITION;
        if count == 3 && !is_odd && words.0.is_empty() {
            return Ok(true);
        }

        self.out.push(b'v');
        for word in &first {
            if !word.is_ascii() {
                let shown = String::from_utf8_lossy(word).into_owned();
                return Err(self.error(format!("'{shown}' is not a number")));
            }
            // Old C libraries print NaN and infinity as 1.#IND, 1.#QNAN, 1.#INF or nan(ind); none of them is a position.
            let is_finite = !word.contains(&b'#') && !word.contains(&b'(');
            self.out.push(b' ');
            self.out.extend_from_slice(if is_finite { word } else { b"nan" });
        }
        self.out.push(b'\n');
        Ok(false)
    }

    /// `f v/vt/vn …` as absolute vertex numbers. One or two corners make a point or a line.
    fn face(&mut self, arguments: &[u8]) -> Result<bool, SceneError> {
        let mut words = Words(arguments);
        let mut corners = 0u64;
        let mut is_plain = true;
        for word in &mut words {
            let (vertex, is_number_alone) = match parse_digits(word) {
                Some((n, length)) if n > 0 => (n, length == word.len()),
                _ => (self.vertex_number(word)?, false),
            };
            is_plain &= is_number_alone;
            if vertex <= self.positions {
                self.used[vertex as usize - 1] = true;
            } else {
                self.ahead.push(vertex);
                self.unpaid += 8;
                if self.farthest.is_none_or(|(v, _)| v < vertex) {
                    self.farthest = Some((vertex, self.line));
                }
            }
            corners += 1;
        }
        self.number_corners(corners)?;
        if corners < 3 {
            self.skipped += 1;
            return Ok(false);
        }
        self.faces += 1;
        self.triangles += corners - 2;
        if self.triangles > u64::from(u32::MAX) {
            return Err(self.too_many("triangles"));
        }
        self.unpaid += BYTES_PER_FACE + BYTES_PER_CORNER * corners;
        self.start_part();
        if is_plain && words.0.is_empty() {
            return Ok(true);
        }

        self.out.push(b'f');
        for word in Words(arguments) {
            self.out.push(b' ');
            match parse_digits(word) {
                Some((n, length)) if n > 0 => self.out.extend_from_slice(&word[..length]),
                _ => {
                    let vertex = self.vertex_number(word)?;
                    self.out.extend_from_slice(vertex.to_string().as_bytes());
                }
            }
        }
        self.out.push(b'\n');
        Ok(false)
    }

    /// Count the corners of a statement, if they are to have numbers.
    fn number_corners(&mut self, corners: u64) -> Result<(), SceneError> {
        if !self.source.options.vertices {
            return Ok(());
        }
        self.corners += corners;
        if self.corners > u64::from(u32::MAX) {
            return Err(self.too_many("corners of faces"));
        }
        if corners < 3 {
            self.gaps.push(Gap { face: self.faces, corners });
            self.unpaid += size_of::<Gap>() as u64;
        } else {
            self.unpaid += (corners - 2) * size_of::<[u32; 3]>() as u64;
        }
        Ok(())
    }

    /// A face's vertex number, counted from 1. Negative numbers count back from the latest position.
    fn vertex_number(&self, word: &[u8]) -> Result<u64, SceneError> {
        let digits = word.split(|&b| b == b'/').next().unwrap_or_default();
        let shown = || String::from_utf8_lossy(digits).into_owned();
        let number = std::str::from_utf8(digits).ok().and_then(|d| d.parse::<i64>().ok());
        let vertex = match number {
            None => return Err(self.error(format!("'{}' is not a vertex number", shown()))),
            Some(0) => return Err(self.error("a face uses vertex 0; vertices are numbered from 1".into())),
            Some(n) if n > 0 => n as u64,
            Some(n) => (self.positions + 1).saturating_sub(n.unsigned_abs()),
        };
        match vertex {
            0 => Err(self.error(format!("a face uses vertex {}, but there are only {}", shown(), self.positions))),
            _ => Ok(vertex),
        }
    }

    /// Tell `tobj` that a part begins, if this face belongs to something else than the latest.
    fn start_part(&mut self) {
        if self.latest == Some(self.run) {
            return;
        }
        self.latest = Some(self.run);
        let Run { object, group, material, .. } = self.run;
        let part = PartName { name: part_name(object, group), material: readable(material, "%") };
        self.unpaid += (part.name.len() + part.material.len() + size_of::<PartName>()) as u64 + 512; // and tobj's model
        self.out.extend_from_slice(format!("g {}\n", self.parts.len()).as_bytes());
        self.parts.push(part);
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
        SceneError::TooMany { path: self.source.path.to_owned(), what, limit: u32::MAX.into() }
    }
}

impl BufRead for Statements<'_, '_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken == self.current().len()
            && let Err(failure) = self.advance()
        {
            self.failure = Some(failure);
            return Err(io::ErrorKind::InvalidData.into());
        }
        Ok(&self.current()[self.taken..])
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

/// Statements whose text runs to the end of the line: a backslash there is part of a name.
fn is_name_statement(line: &[u8]) -> bool {
    line.starts_with(b"#") || matches!(split_word(line).0, b"o" | b"g" | b"usemtl" | b"mtllib")
}

/// Keywords that every exporter writes. Others, such as `end` or `call`, may begin a line of any text.
const KEYWORDS: [&[u8]; 13] =
    [b"v", b"vn", b"vt", b"vp", b"f", b"fo", b"l", b"p", b"o", b"g", b"s", b"usemtl", b"mtllib"];

/// A text without any statement of an OBJ file, which begins with `line`.
fn not_obj(line: &[u8], source: &Source) -> SceneError {
    let keyword = split_word(line).0.to_ascii_lowercase();
    let resembles = if line.starts_with(b"version https://git-lfs") {
        Resemblance::LfsPointer
    } else if line.starts_with(b"<") {
        Resemblance::WebPage
    } else if KEYWORDS.contains(&keyword.as_slice()) {
        Resemblance::Capitals
    } else if line.starts_with(b"{") {
        Resemblance::Json
    } else {
        Resemblance::Nothing
    };
    let shown: String = String::from_utf8_lossy(line).chars().take(40).collect();
    let cut = if shown.len() < line.len() { "…" } else { "" };
    SceneError::NotObj { path: source.path.to_owned(), found: format!("'{shown}{cut}'"), resembles }
}
