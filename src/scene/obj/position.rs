//! Positions: their statement, and which of them faces use.

use super::words::Words;

/// What `tobj` and this reader hold for each position: the list itself, the model's copy, the index map's entry, the mesh's.
pub(super) const BYTES_PER_POSITION: u64 = 112;

/// The positions so far.
#[derive(Debug, Default)]
pub(super) struct Positions {
    /// For each, whether a face uses it.
    used: Vec<bool>,
    /// Vertex numbers that faces use before their positions are there, and the largest of them with its line.
    ahead: Vec<u64>,
    farthest: Option<(u64, u64)>,
}

impl Positions {
    pub fn count(&self) -> u64 {
        self.used.len() as u64
    }

    /// Add one; false where there are as many as 32 bits count.
    pub fn add(&mut self) -> bool {
        let fits = self.count() < u64::from(u32::MAX);
        if fits {
            self.used.push(false);
        }
        fits
    }

    /// Note that a face uses a vertex, counted from 1. False, and nothing done, where its position is not there yet.
    pub fn mark(&mut self, vertex: u64) -> bool {
        let used = vertex.checked_sub(1).and_then(|v| self.used.get_mut(v as usize));
        used.map(|used| *used = true).is_some()
    }

    /// Note that the face in a line uses a vertex whose position is yet to come.
    pub fn mark_ahead(&mut self, vertex: u64, line: u64) {
        self.ahead.push(vertex);
        if self.farthest.is_none_or(|(v, _)| v < vertex) {
            self.farthest = Some((vertex, line));
        }
    }

    /// The largest vertex number that a face used before its position was there, and the face's line.
    pub fn farthest_ahead(&self) -> Option<(u64, u64)> {
        self.farthest
    }

    /// How many no face uses, at the end of the file. All that were used ahead must have come.
    pub fn unreferenced(&mut self) -> u64 {
        for vertex in std::mem::take(&mut self.ahead) {
            self.mark(vertex);
        }
        self.used.iter().filter(|used| !**used).count() as u64
    }
}

/// Whether a position has a weight other than 1, given what follows its three numbers: one number alone, since three are a colour. Only rational
/// curves and surfaces have weights, but some programs write homogeneous coordinates.
pub(super) fn has_weight(rest: &[u8]) -> bool {
    let mut words = Words(rest);
    let (Some(word), None) = (words.next(), words.next()) else { return false };
    let weight = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f64>().ok());
    weight.is_some_and(|weight| weight != 1.0)
}

/// Write `v x y z` from the statement's arguments, or say what is wrong with them. What follows is cut off, a weight ([`has_weight`]) or a colour;
/// whether it is such a weight.
pub(super) fn write_position(arguments: &[u8], out: &mut Vec<u8>) -> Result<bool, String> {
    out.push(b'v');
    let weighted = write_numbers(arguments, out)?;
    out.push(b'\n');
    Ok(weighted)
}

/// Write ` x y z` of [`write_position`].
pub(super) fn write_numbers(arguments: &[u8], out: &mut Vec<u8>) -> Result<bool, String> {
    let mut words = Words(arguments);
    let [Some(x), Some(y), Some(z)] = [words.next(), words.next(), words.next()] else {
        return Err(format!("a position has {} coordinates; it needs 3", Words(arguments).count()));
    };
    for word in [x, y, z] {
        if !word.is_ascii() {
            return Err(format!("'{}' is not a number", String::from_utf8_lossy(word)));
        }
        out.push(b' ');
        out.extend_from_slice(if is_no_number(word) { b"nan" } else { word });
    }
    Ok(has_weight(words.0))
}

/// Whether a word is infinity, or is NaN or infinity as old C libraries print them: `1.#IND`, `-1.#QNAN0`, `1.#INF`, `nan(ind)`. None of them is a
/// position. What is infinite after this is a number that is too large.
fn is_no_number(word: &[u8]) -> bool {
    let word = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
    let starts =
        |text: &[u8], with: &[u8]| text.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with));
    match word.strip_prefix(b"1.#") {
        Some(kind) => [&b"IND"[..], b"INF", b"QNAN", b"SNAN"].iter().any(|known| starts(kind, known)),
        None => starts(word, b"inf") || starts(word, b"nan(") && word.ends_with(b")"),
    }
}
