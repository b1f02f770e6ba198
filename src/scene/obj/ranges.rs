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
use super::parts::{PartName, Parts};
use super::position::BYTES_PER_POSITION;
use super::range::{Range, Reader};
use crate::scene::options::BOM;
use crate::scene::source::Source;

/// About so many bytes of text are one range. Neither this nor the number of threads changes what is read.
pub(super) const RANGE: usize = 1 << 19;

/// So many ranges are read before progress is reported again.
pub(super) const GROUP: usize = 64;

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
    pub weighted: u64,
}

/// Read a text in ranges of about so many bytes; `None`, and nothing charged, where it holds anything else.
pub(super) fn read(text: &[u8], range: usize, source: &mut Source) -> Option<Everyday> {
    if !has_room(text.len() as u64, source) {
        return None;
    }
    let pieces = cut(text.strip_prefix(BOM).unwrap_or(text), range);
    let mut gathered = Gathered::default();
    for group in pieces.chunks(GROUP) {
        let read = source.exec().map_with(group.to_vec(), Reader::new, |reader, _, piece| reader.read(piece));
        read.into_iter().try_for_each(|range| gathered.add(range?))?;
    }
    let read = gathered.finish(source)?;
    source.advance(text.len() as u64);
    Some(read)
}

/// Whether there is memory for what ranges hold of the shortest statements, before it is known what there is to be charged for.
pub(super) fn has_room(text: u64, source: &Source) -> bool {
    source.available() / 5 >= text
}

/// The ranges so far, in their order.
#[derive(Default)]
pub(super) struct Gathered {
    ranges: Vec<Range>,
    positions: usize,
    corners: u64,
    triangles: u64,
}

impl Gathered {
    /// Add the range that follows. `None` where the text is not for this reader.
    pub fn add(&mut self, mut range: Range) -> Option<()> {
        range.begin_at(self.positions)?;
        self.positions += range.positions.len() / 3;
        self.corners += range.corners.len() as u64;
        self.triangles += range.triangles;
        self.ranges.push(range);
        let most = (self.positions as u64).max(self.corners).max(self.triangles);
        (most <= u64::from(u32::MAX)).then_some(())
    }

    /// What the text says, and charge for it.
    pub fn finish(self, source: &mut Source) -> Option<Everyday> {
        let Gathered { ranges, positions, corners, triangles } = self;
        let (mut parts, mut starts, mut bytes, mut faces) = (Parts::default(), Vec::new(), 0, 0usize);
        for range in &ranges {
            note_parts(&mut parts, range, |parts, face| {
                bytes += parts.begin(&mut Vec::new());
                starts.push(faces + face);
            });
            faces += range.faces;
        }
        let numbers = if source.options.vertices { size_of::<[u32; 3]>() as u64 * triangles } else { 0 };
        let lists = BYTES_PER_POSITION * positions as u64 + BYTES_PER_FACE * faces as u64 + BYTES_PER_CORNER * corners;
        if triangles == 0 || source.charge(lists + numbers + bytes, "its geometry").is_err() {
            return None;
        }
        let parts = starts.into_iter().zip(parts.into_names()).collect();
        let skipped = ranges.iter().map(|range| range.skipped).sum();
        let weighted = ranges.iter().map(|range| range.weighted).sum();
        Some(Everyday { ranges, parts, positions, triangles: triangles as usize, skipped, weighted })
    }
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
fn note_parts<'a>(parts: &mut Parts<'a>, range: &'a Range, mut begin: impl FnMut(&mut Parts<'a>, usize)) {
    let mut face = 0;
    let ends = range.namings().map(|(before, line)| (before, Some(line))).chain([(range.faces, None)]);
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
