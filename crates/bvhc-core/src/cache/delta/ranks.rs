use crate::layout::PoseRecord;

/// The poses of each topology in the order of their rows, and which of them each is stored relative to.
///
/// The first pose of a topology stands by itself. The one of rank `r`, counted from 0, is stored relative to that of rank `r & (r - 1)`: the lowest bit
/// that is set is cleared. So half of the poses follow the one right before them, and none is more than log2 of their number away from the first.
pub struct Ranks {
    /// For each topology its rows of `POSE`, ascending.
    rows: Vec<Vec<u32>>,
    /// For each row its rank.
    ranks: Vec<u32>,
}

impl Ranks {
    /// Of the rows of a file. A row of a topology that is not there has rank 0.
    pub fn new(poses: &[PoseRecord], topologies: usize) -> Ranks {
        let mut rows = vec![Vec::new(); topologies];
        let rank = |(row, pose): (usize, &PoseRecord)| {
            let Some(mine) = rows.get_mut(pose.topology as usize) else { return 0 };
            mine.push(row as u32);
            mine.len() as u32 - 1
        };
        let ranks = poses.iter().enumerate().map(rank).collect();
        Ranks { rows, ranks }
    }

    /// The row that a row is stored relative to, always a smaller one; `None` for the first of its topology.
    pub fn base(&self, row: u32, topology: u32) -> Option<u32> {
        let rank = *self.ranks.get(row as usize).filter(|rank| **rank > 0)?;
        self.rows.get(topology as usize)?.get(base_of(rank) as usize).copied()
    }

    /// The first row of a topology.
    pub fn first(&self, topology: u32) -> Option<u32> {
        self.rows.get(topology as usize)?.first().copied()
    }
}

/// The rank that a rank above 0 is stored relative to.
pub fn base_of(rank: u32) -> u32 {
    rank & (rank - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn chains_are_short_and_lead_to_the_first() {
        // Two topologies take turns, and the second is seldom.
        let topology = |row: u32| u32::from(row % 5 == 4);
        let poses: Vec<_> =
            (0..1000).map(|row| PoseRecord { topology: topology(row), ..PoseRecord::zeroed() }).collect();
        let ranks = Ranks::new(&poses, 2);
        let mut right_before = 0;
        for row in 0..1000 {
            let (mut at, mut steps) = (row, 0);
            while let Some(base) = ranks.base(at, topology(row)) {
                assert!(base < at && topology(base) == topology(row));
                (at, steps) = (base, steps + 1);
            }
            assert_eq!(Some(at), ranks.first(topology(row)));
            assert!(steps <= 10, "{steps}");
            right_before += u32::from(ranks.base(row, topology(row)).is_some_and(|b| row - b < 6));
        }
        assert!(right_before >= 500);
        assert_eq!((ranks.base(2000, 0), ranks.base(3, 7), ranks.first(2)), (None, None, None));
    }
}
