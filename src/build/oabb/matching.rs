//! Every cluster's best match among its neighbours in the order.

use crate::build::progress::Progress;
use crate::exec::Executor;
use crate::oriented::OrientedBox;

/// Clusters whose matches one task finds. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 10;

/// The neighbour with which each cluster has the least common box; its own number where no common box has an area that is a number. And how many
/// common boxes were measured.
///
/// A proposal is as good for one as for the other, so a pair is measured once. Equal areas are told apart by a rank: the distance in the order,
/// and a bit that tells the neighbour before from the one behind. So pairs that share a cluster are never equal, the least pair of all is a
/// mutual one, and where all are equal, half of the clusters merge.
///
/// Nothing where the build is cancelled.
pub(super) fn best_matches(
    hulls: &[OrientedBox],
    radius: usize,
    exec: &Executor,
    progress: &dyn Progress,
) -> Option<(Vec<u32>, u64)> {
    let found = exec.map_chunks(hulls, CHUNK, |chunk_index, chunk| {
        let start = chunk_index * CHUNK;
        let end = start + chunk.len();
        if progress.is_cancelled() {
            return None;
        }
        let from = start.saturating_sub(radius);
        let mut best = vec![Best::NONE; chunk.len()];
        let mut measured = 0;
        for i in from..end {
            // A pair of which neither is in the chunk is another's.
            for j in (i + 1).max(start)..(i + radius + 1).min(hulls.len()) {
                let (area, _) = hulls[i].merged_half_area(&hulls[j]);
                measured += 1;
                let distance = j - i;
                let rank = (2 * distance as u32) | (i >> distance.trailing_zeros() & 1) as u32;
                if i >= start {
                    best[i - start].offer(area, rank, j as u32);
                }
                if j < end {
                    best[j - start].offer(area, rank, i as u32);
                }
            }
        }
        let partner =
            |(k, best): (usize, &Best)| if best.area < f64::INFINITY { best.partner } else { (start + k) as u32 };
        Some((best.iter().enumerate().map(partner).collect::<Vec<u32>>(), measured))
    });
    let found = found.into_iter().collect::<Option<Vec<_>>>()?;
    let measured = found.iter().map(|(_, measured)| measured).sum();
    Some((found.into_iter().flat_map(|(partners, _)| partners).collect(), measured))
}

/// The best that was offered so far.
#[derive(Clone, Copy)]
struct Best {
    area: f64,
    rank: u32,
    partner: u32,
}

impl Best {
    const NONE: Best = Best { area: f64::INFINITY, rank: u32::MAX, partner: 0 };

    #[inline(always)]
    fn offer(&mut self, area: f64, rank: u32, partner: u32) {
        if area < self.area || area == self.area && rank < self.rank {
            *self = Best { area, rank, partner };
        }
    }
}
