//! Rounds of merging until one cluster is left.

use super::window::{self, NONE};
use crate::build::cost::Sah;
use crate::build::error::BuildError;
use crate::build::exec::Executor;
use crate::build::prim_ref::PrimRef;
use crate::build::progress::Progress;
use crate::geom::Aabb;

/// Clusters that one task looks at. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 12;
/// In a round of more clusters than this, at least one of [`FEWEST`] must merge, or pairs are made of clusters that are not each
/// other's best match. Growing boxes in a row, each of which likes the smaller one before it, would otherwise take a
/// round for every merge.
const MANY: usize = 256;
const FEWEST: usize = 16;

/// How clusters are merged and valued.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rules {
    pub sah: Sah,
    pub max_leaf: u32,
    /// Neighbours to either side that a cluster looks at.
    pub radius: usize,
    pub scale: f32,
}

/// Two clusters that became one.
#[derive(Clone, Copy, Debug, bytemuck::Zeroable)]
pub(super) struct Merge {
    pub bounds: Aabb,
    /// Numbers below the number of references are references, the others merges made before.
    pub children: [u32; 2],
    /// References below.
    pub count: u32,
    /// Longest way down to a leaf; 0 where the subtree is cheaper as a leaf.
    pub height: u32,
    /// SAH of the subtree times the area of the root.
    pub cost: f32,
}

/// All merges; children stand before their parents, and the last is the root.
pub(super) struct Forest {
    pub merges: Vec<Merge>,
}

/// What a cluster weighs in the comparison of its parent with a leaf.
#[derive(Clone, Copy)]
struct Weight {
    count: u32,
    height: u32,
    cost: f32,
}

/// A power of two that brings the longest side to between 1 and 2, so that no area over- or underflows.
pub(super) fn scale_of(bounds: &Aabb) -> f32 {
    let longest = (0..3).map(|a| f64::from(bounds.max[a]) - f64::from(bounds.min[a])).fold(0.0, f64::max);
    let exponent = if longest > 0.0 { longest.log2().floor() as i32 } else { 0 };
    2f32.powi((-exponent).clamp(-126, 126))
}

/// Merge the references, which stand in the order in which they are neighbours, until one cluster is left. `scratch` is room for as many.
pub(super) fn cluster(
    refs: &[PrimRef],
    scratch: Vec<PrimRef>,
    rules: &Rules,
    exec: &Executor,
    progress: &dyn Progress,
    share: u64,
) -> Result<Forest, BuildError> {
    let mut merges = bytemuck::zeroed_vec(refs.len() - 1);
    let mut rounds = Rounds::new(refs, scratch, rules, exec);
    let (mut made, mut reported) = (0, 0);
    while rounds.left > 1 {
        if progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        made += rounds.merge(&mut merges, made);

        let done = (u128::from(share) * made as u128 / refs.len() as u128) as u64;
        progress.advance(done - reported);
        reported = done;
    }
    progress.advance(share - reported);
    Ok(Forest { merges })
}

/// The clusters, and room for those of the next round: all memory that the rounds need.
struct Rounds<'a> {
    clusters: Vec<PrimRef>,
    next: Vec<PrimRef>,
    partners: Vec<u32>,
    /// How many clusters there are.
    left: usize,
    references: usize,
    rules: &'a Rules,
    exec: &'a Executor,
}

impl<'a> Rounds<'a> {
    /// Every reference is a cluster of one.
    fn new(refs: &[PrimRef], scratch: Vec<PrimRef>, rules: &'a Rules, exec: &'a Executor) -> Rounds<'a> {
        let (mut clusters, left) = (scratch, refs.len());
        exec.map_chunks_mut(&mut clusters, CHUNK, |chunk, clusters| {
            for (i, (cluster, r)) in clusters.iter_mut().zip(&refs[chunk * CHUNK..]).enumerate() {
                *cluster = PrimRef { prim: (chunk * CHUNK + i) as u32, ..*r };
            }
        });
        let (next, partners) = (bytemuck::zeroed_vec(left), vec![NONE; left]);
        Rounds { clusters, next, partners, left, references: left, rules, exec }
    }

    /// A round. Each merged pair takes the place of its first cluster; `merges[..made]` are those of earlier rounds, and this one's
    /// follow. Returns how many.
    fn merge(&mut self, merges: &mut [Merge], made: usize) -> usize {
        let (exec, count) = (self.exec, self.left);
        let (clusters, partners) = (&self.clusters[..count], &mut self.partners[..count]);
        let (radius, scale) = (self.rules.radius, self.rules.scale);
        exec.map_chunks_mut(partners, CHUNK, |chunk, partners| {
            window::best_matches(clusters, chunk * CHUNK, radius, scale, partners);
        });
        let mut pairs = count_pairs(partners, exec);
        let merging = |pairs: &[[usize; 2]]| pairs.iter().map(|[firsts, _]| firsts).sum::<usize>();
        if count > MANY && merging(&pairs) * FEWEST < count {
            make_pairs(partners);
            pairs = count_pairs(partners, exec);
        }

        // Give every chunk its run of the new clusters and of the new merges.
        let (total, partners) = (merging(&pairs), &*partners);
        let (known, mut new_merges) = merges.split_at_mut(made);
        let known = Known { merges: known, references: self.references, rules: self.rules };
        let mut rest = self.next.as_mut_slice();
        let mut number = (self.references + made) as u32;
        let mut jobs = Vec::with_capacity(pairs.len());
        for (chunk, [firsts, seconds]) in pairs.into_iter().enumerate() {
            let all = chunk * CHUNK..((chunk + 1) * CHUNK).min(count);
            let (out, others) = std::mem::take(&mut rest).split_at_mut(all.len() - seconds);
            let (merges, other_merges) = std::mem::take(&mut new_merges).split_at_mut(firsts);
            (rest, new_merges) = (others, other_merges);
            jobs.push((all, out, merges, number));
            number += firsts as u32;
        }
        exec.map(jobs, |_, (all, out, merges, number)| {
            let (mut out, mut merges) = (out.iter_mut(), merges.iter_mut().zip(number..));
            for i in all {
                let cluster = match pair_at(partners, i) {
                    Pair::Second => continue,
                    Pair::None => clusters[i],
                    Pair::First => {
                        // Counted above: there is a place for each.
                        let Some((place, number)) = merges.next() else { continue };
                        *place = known.merged(&clusters[i], &clusters[partners[i] as usize]);
                        PrimRef { prim: number, ..PrimRef::new(&place.bounds, 0) }
                    }
                };
                if let Some(place) = out.next() {
                    *place = cluster;
                }
            }
        });
        std::mem::swap(&mut self.clusters, &mut self.next);
        self.left -= total;
        total
    }
}

/// How many clusters of each chunk are the first of a pair, and how many the second.
fn count_pairs(partners: &[u32], exec: &Executor) -> Vec<[usize; 2]> {
    exec.map_chunks(partners, CHUNK, |chunk, some| {
        let mut counts = [0; 2];
        for i in chunk * CHUNK..chunk * CHUNK + some.len() {
            match pair_at(partners, i) {
                Pair::First => counts[0] += 1,
                Pair::Second => counts[1] += 1,
                Pair::None => {}
            }
        }
        counts
    })
}

/// What a cluster is to its partner.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pair {
    First,
    Second,
    None,
}

fn pair_at(partners: &[u32], i: usize) -> Pair {
    match partners.get(partners[i] as usize) {
        Some(&back) if back as usize == i => {
            if partners[i] as usize > i {
                Pair::First
            } else {
                Pair::Second
            }
        }
        _ => Pair::None,
    }
}

/// Beside the mutual best matches, pair in order every cluster that is left with its best match if that is left too. At least one in
/// `4·radius + 2` clusters merges then, and in practice a third.
fn make_pairs(partners: &mut [u32]) {
    let mut taken: Vec<bool> = (0..partners.len()).map(|i| pair_at(partners, i) != Pair::None).collect();
    for i in 0..partners.len() {
        let partner = partners[i] as usize;
        if !taken[i] && !taken[partner] {
            (taken[i], taken[partner]) = (true, true);
            partners[partner] = i as u32;
        }
    }
}

/// Clusters with what is known of the merges below them.
struct Known<'a> {
    merges: &'a [Merge],
    references: usize,
    rules: &'a Rules,
}

impl Known<'_> {
    fn area(&self, bounds: &Aabb) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|a| bounds.max[a] * self.rules.scale - bounds.min[a] * self.rules.scale);
        x * y + y * z + z * x
    }

    fn weight(&self, cluster: &PrimRef) -> Weight {
        match (cluster.prim as usize).checked_sub(self.references) {
            Some(merge) => {
                let Merge { count, height, cost, .. } = self.merges[merge];
                Weight { count, height, cost }
            }
            None => Weight { count: 1, height: 0, cost: self.rules.sah.intersection * self.area(&cluster.bounds()) },
        }
    }

    /// The first child is the one of larger area: rays that look for any hit find one sooner there.
    fn merged(&self, a: &PrimRef, b: &PrimRef) -> Merge {
        let bounds = a.bounds().union(b.bounds());
        let swap = self.area(&b.bounds()) > self.area(&a.bounds());
        let children = if swap { [b.prim, a.prim] } else { [a.prim, b.prim] };
        let (a, b, area) = (self.weight(a), self.weight(b), self.area(&bounds));
        let (count, Sah { traversal, intersection }) = (a.count + b.count, self.rules.sah);
        let split = traversal * area + (a.cost + b.cost);
        let leaf = intersection * count as f32 * area;
        if count <= self.rules.max_leaf && leaf <= split {
            Merge { bounds, children, count, height: 0, cost: leaf }
        } else {
            Merge { bounds, children, count, height: a.height.max(b.height) + 1, cost: split }
        }
    }
}
