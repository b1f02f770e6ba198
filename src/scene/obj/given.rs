//! The positions of a text that was read in ranges.

use super::range::Range;

/// The positions of all ranges, where they were read to.
pub(super) struct Given {
    /// Of each range the number of its first position and its coordinates; ranges without any are left out.
    ranges: Vec<(usize, Vec<f64>)>,
}

/// Where the latest position was found. Faces name those next to each other, so that the next one is most often in the same range.
#[derive(Clone, Copy, Default)]
pub(super) struct Finger(usize);

impl Given {
    pub fn of(ranges: &mut [Range]) -> Given {
        let mut next = 0;
        let mut take = |range: &mut Range| {
            let positions = std::mem::take(&mut range.positions);
            let first = next;
            next += positions.len() / 3;
            (!positions.is_empty()).then_some((first, positions))
        };
        Given { ranges: ranges.iter_mut().filter_map(&mut take).collect() }
    }

    /// A position by its number in the text, which is below the number of all.
    pub fn position(&self, number: usize, finger: &mut Finger) -> [f64; 3] {
        let is_in = |(first, positions): &(usize, Vec<f64>)| (*first..first + positions.len() / 3).contains(&number);
        if !is_in(&self.ranges[finger.0]) {
            finger.0 = self.ranges.partition_point(|(first, _)| *first <= number) - 1;
        }
        let (first, positions) = &self.ranges[finger.0];
        let at = 3 * (number - first);
        [positions[at], positions[at + 1], positions[at + 2]]
    }
}
