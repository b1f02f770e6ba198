//! Levels of groups, each of which becomes a few clusters, until one group becomes one.

use super::forest::{Cluster, Forest, Merge, Rules};
use super::group::{GROUP, Group, Inputs};
use crate::build::error::BuildError;
use crate::build::prim_ref::PrimRef;
use crate::build::progress::Progress;
use crate::exec::Executor;
use crate::simd::widest;

/// Clusters that a group leaves to the next level, at most. Few enough that most of the work is done where it is cheap, many enough
/// that borders between groups leave no mark on the tree.
const LEFT: usize = GROUP / 4;
/// From level to level clusters look at so many times as many neighbours, up to [`WIDE`]: there are so much fewer of them, and rays
/// meet the upper ones most.
const WIDER: usize = 4;
const WIDE: usize = 14;

/// References whose numbers, with those of the places for merges on all levels, fit 32 bits.
pub(super) const MOST_REFS: u64 = 3 << 29;

/// Merge the references, which stand in the order in which they are neighbours, until one cluster is left.
///
/// A group's clusters stay close to a processor for several rounds. Neighbours on both sides of a border meet on the next level, whose borders are
/// half a group further on. `share` is reported as the references' groups are finished.
pub(super) fn cluster<'a>(
    refs: &'a [PrimRef],
    rules: &Rules,
    exec: &Executor,
    progress: &dyn Progress,
    share: u64,
) -> Result<Forest<'a>, BuildError> {
    // Each level has as many places for merges as clusters: each of its groups has its own from the start.
    let mut merges: Vec<Merge> = bytemuck::zeroed_vec(refs.len() + places_above(refs.len()));
    let level = Level { inputs: Inputs::References(refs, 0), rules, number: refs.len(), shifted: false };
    let mut clusters = level.merge(&mut merges, exec, progress, share);
    let (mut made, mut rules, mut shifted) = (refs.len(), *rules, false);
    while clusters.len() > 1 {
        shifted = !shifted;
        rules.radius = rules.radius.max((rules.radius * WIDER).min(WIDE));
        let level = Level { inputs: Inputs::Clusters(&clusters), rules: &rules, number: refs.len() + made, shifted };
        let above = level.merge(&mut merges[made..], exec, progress, 0);
        made += clusters.len();
        clusters = above;
    }
    match clusters.first() {
        Some(root) if !progress.is_cancelled() => Ok(Forest { refs, root: *root, merges }),
        _ => Err(BuildError::Cancelled),
    }
}

/// Places that the levels above one of `count` clusters need at most.
fn places_above(mut count: usize) -> usize {
    let mut places = 0;
    while count > GROUP {
        count = (count.div_ceil(GROUP) + 1) * LEFT;
        places += count;
    }
    places
}

struct Level<'a> {
    inputs: Inputs<'a>,
    rules: &'a Rules,
    /// Of the first merge.
    number: usize,
    /// Whether the borders are half a group further on.
    shifted: bool,
}

impl Level<'_> {
    /// The clusters that are left, in order: one if there is but one group.
    fn merge(self, mut merges: &mut [Merge], exec: &Executor, progress: &dyn Progress, share: u64) -> Vec<Cluster> {
        let count = self.inputs.len();
        let whole = count.div_ceil(GROUP);
        let (left, shift) = if whole > 1 { (LEFT, usize::from(self.shifted)) } else { (1, 0) };
        // Groups of equal size, but for a half one at either end where the others are shifted.
        let groups = whole + shift;
        let border = |group: usize| {
            let halves = (2 * group).saturating_sub(shift).min(2 * whole);
            (count as u64 * halves as u64 / (2 * whole as u64)) as usize
        };
        let mut found: Vec<Cluster> = bytemuck::zeroed_vec(groups * left);
        let mut jobs = Vec::with_capacity(groups);
        for (group, found) in found.chunks_mut(left).enumerate() {
            let range = border(group)..border(group + 1);
            let (own, others) = std::mem::take(&mut merges).split_at_mut(range.len());
            merges = others;
            jobs.push((range, own, found));
        }
        let counts = exec.map_with(jobs, Group::boxed, |group, _, (range, merges, found)| {
            if progress.is_cancelled() {
                return 0;
            }
            let done = |at: usize| (u128::from(share) * at as u128 / count as u128) as u64;
            progress.advance(done(range.end) - done(range.start));
            let number = (self.number + range.start) as u32;
            widest(
                #[inline(always)]
                || {
                    group.load(self.inputs.slice(range), self.rules);
                    group.merge(found.len(), self.rules, merges, number);
                    group.clusters(found)
                },
            )
        });

        // Close the gaps that groups leave which became fewer clusters than they might.
        let mut end = 0;
        for (group, count) in counts.into_iter().enumerate() {
            found.copy_within(group * left..group * left + count, end);
            end += count;
        }
        found.truncate(end);
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::agglomerative::build;
    use crate::build::prim_ref::PrimRefs;
    use crate::build::progress::NoProgress;
    use crate::build::recipe::options::BuildOptions;
    use crate::geom::Aabb;
    use crate::tree::MAX_DEPTH;

    fn cube(at: [f32; 3], half: f32) -> Aabb {
        Aabb { min: at.map(|v| v - half), max: at.map(|v| v + half) }
    }

    #[test]
    fn every_reference_is_in_the_tree_once_whatever_the_boxes_and_the_threads() {
        let spread = |i: usize| cube([(i * 7919 % 10_007) as f32, (i * 104_729 % 1_009) as f32, 0.0], 0.5);
        let same = |_: usize| cube([1.0, -2.0, 3.0], 0.5);
        let points = |_: usize| cube([1.0, -2.0, 3.0], 0.0);
        let series = |i: usize| cube([0.5f32.powi(i as i32 % 149), 0.0, 0.0], 0.0);
        // Each likes the smaller one before it.
        let growing = |i: usize| cube([1.002f32.powi(i as i32 % 20_000), 0.0, 0.0], 1.002f32.powi(i as i32 % 20_000));
        let huge = |i: usize| Aabb { min: [-3e38; 3], max: [3e38, 3e38, i as f32] };
        let places: [&dyn Fn(usize) -> Aabb; 6] = [&spread, &same, &points, &series, &growing, &huge];
        let sizes = [1, 2, 3, LEFT + 1, GROUP, GROUP + 1, 2 * GROUP + 1, 4 * GROUP + 1, 9000];
        for (place, radius) in places.into_iter().zip([14, 1, 2, 31, 2, 3]) {
            for count in sizes {
                let boxes: Vec<Aabb> = (0..count).map(place).collect();
                let options = BuildOptions { radius, ..BuildOptions::default() };
                let [one, three] = [1, 3].map(|jobs| {
                    let exec = Executor::new(jobs).unwrap();
                    let refs = PrimRefs::of_boxes(&boxes, &exec);
                    build(refs, &options, &exec, &NoProgress, 0).unwrap()
                });
                assert!(one == three, "{count} boxes");
                let mut prims = one.refs.clone();
                prims.sort_unstable();
                assert!(prims.into_iter().eq(0..count as u32));
                assert!(one.max_depth() <= MAX_DEPTH);
            }
        }
    }

    #[test]
    fn a_level_is_smaller_than_the_one_below_and_has_the_places_that_were_reserved() {
        for refs in [GROUP + 1, 2 * GROUP, 2 * GROUP + 1, 3 * GROUP + 1, 100_000, 10_000_000] {
            let (mut count, mut places) = (refs, 0);
            while count > GROUP {
                let above = (count.div_ceil(GROUP) + 1) * LEFT;
                assert!(above < count);
                (count, places) = (above, places + above);
            }
            assert_eq!(places, places_above(refs));
        }
    }

    #[test]
    fn the_most_references_and_their_merges_have_numbers_and_more_are_refused() {
        let most = MOST_REFS as usize;
        assert!(u32::try_from(2 * most + places_above(most)).is_ok());
        assert!(u32::try_from(2 * (most + most / 4) + places_above(most + most / 4)).is_err(), "the limit is near");
        let check = crate::build::agglomerative::check_numbers;
        assert!(check(MOST_REFS).is_ok());
        assert!(matches!(check(MOST_REFS + 1), Err(BuildError::TooLarge { limit: MOST_REFS, .. })));
    }
}
