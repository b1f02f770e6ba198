//! Faces: their statement, and how many of them and of their corners there are.

use super::corners::Gap;
use super::words::{Words, parse_digits};

/// What is held for each face (`tobj`'s enum) and for each corner (its three indices, the model's index, our triangle).
pub(super) const BYTES_PER_FACE: u64 = 112;
pub(super) const BYTES_PER_CORNER: u64 = 48;

/// The faces so far.
#[derive(Debug)]
pub(super) struct Faces {
    count: u64,
    triangles: u64,
    /// Whether corners are numbered; then the corners of `f` and `fo` so far, and those of them that belong to no face.
    numbered: bool,
    corners: u64,
    gaps: Vec<Gap>,
}

impl Faces {
    pub fn new(numbered: bool) -> Faces {
        Faces { count: 0, triangles: 0, numbered, corners: 0, gaps: Vec::new() }
    }

    /// Count a statement of so many corners; fewer than three are no face. The memory that it takes, or what there is too much of.
    pub fn add(&mut self, corners: u64) -> Result<u64, &'static str> {
        let mut bytes = 0;
        if self.numbered {
            self.corners += corners;
            if self.corners > u64::from(u32::MAX) {
                return Err("corners of faces");
            }
            if corners < 3 {
                self.gaps.push(Gap { face: self.count, corners });
                bytes += size_of::<Gap>() as u64;
            } else {
                bytes += (corners - 2) * size_of::<[u32; 3]>() as u64;
            }
        }
        if corners < 3 {
            return Ok(bytes);
        }
        self.count += 1;
        self.triangles += corners - 2;
        if self.triangles > u64::from(u32::MAX) {
            return Err("triangles");
        }
        Ok(bytes + BYTES_PER_FACE + BYTES_PER_CORNER * corners)
    }

    /// The corners that belong to no face, where corners are numbered.
    pub fn into_gaps(self) -> Vec<Gap> {
        self.gaps
    }
}

/// The vertex numbers of `f v/vt/vn …`, counted from 1, or what is wrong with them. `positions` is how many there are so far.
pub(super) fn read_corners(arguments: &[u8], positions: u64, corners: &mut Vec<u64>) -> Result<(), String> {
    corners.clear();
    for word in Words(arguments) {
        corners.push(match parse_digits(word) {
            Some(n) if n > 0 => n,
            _ => vertex_number(word, positions)?,
        });
    }
    Ok(())
}

/// A face's vertex number. Negative numbers count back from the latest position.
fn vertex_number(word: &[u8], positions: u64) -> Result<u64, String> {
    let digits = word.split(|&b| b == b'/').next().unwrap_or_default();
    let shown = || String::from_utf8_lossy(digits).into_owned();
    let number = std::str::from_utf8(digits).ok().and_then(|d| d.parse::<i64>().ok());
    let vertex = match number {
        None => return Err(format!("'{}' is not a vertex number", shown())),
        Some(0) => return Err("a face uses vertex 0; vertices are numbered from 1".into()),
        Some(n) if n > 0 => n as u64,
        Some(n) => (positions + 1).saturating_sub(n.unsigned_abs()),
    };
    match vertex {
        0 => Err(format!("a face uses vertex {}, but there are only {positions}", shown())),
        _ => Ok(vertex),
    }
}

/// Write `f a b c …`.
pub(super) fn write_face(corners: &[u64], out: &mut Vec<u8>) {
    out.push(b'f');
    for vertex in corners {
        out.push(b' ');
        out.extend_from_slice(vertex.to_string().as_bytes());
    }
    out.push(b'\n');
}
