//! Numbers of the corners of faces.

/// Numbers the corners of all `f` and `fo` statements from 0, also of those that have too few corners to be a face.
///
/// `tobj` is given faces alone, in the order of the file, so that the corners of the others are told here.
#[derive(Debug)]
pub(super) struct Corners {
    gaps: std::iter::Peekable<std::vec::IntoIter<Gap>>,
    face: u64,
    next: u64,
}

/// So many corners stand before a face, faces numbered from 0, that belong to none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gap {
    pub face: u64,
    pub corners: u64,
}

impl Corners {
    /// `gaps` ascend.
    pub fn new(gaps: Vec<Gap>) -> Corners {
        Corners { gaps: gaps.into_iter().peekable(), face: 0, next: 0 }
    }

    /// The number of the first corner of the next face, which has so many. The reader of statements saw to it that all numbers fit.
    pub fn take(&mut self, corners: u32) -> u32 {
        while let Some(gap) = self.gaps.next_if(|gap| gap.face == self.face) {
            self.next += gap.corners;
        }
        let first = self.next as u32;
        self.next += u64::from(corners);
        self.face += 1;
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_points_and_lines_are_counted_where_they_stand() {
        let gap = |face, corners| Gap { face, corners };
        let mut corners = Corners::new(vec![gap(0, 2), gap(0, 1), gap(2, 2), gap(4, 1)]);
        assert_eq!([3, 4, 3, 5].map(|n| corners.take(n)), [3, 6, 12, 15]);
    }
}
