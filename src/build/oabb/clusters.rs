//! Rounds of proposals, until one cluster is left.

use super::matching::best_matches;
use super::outline::{Outline, PARTS};
use crate::build::agglomerative::forest::{Cluster, Merge, Rules, Weight};
use crate::build::agglomerative::morton;
use crate::build::agglomerative::pairs::{FEWEST, pair_the_rest};
use crate::build::error::BuildError;
use crate::build::prim_ref::{PrimRef, PrimRefs};
use crate::build::progress::Progress;
use crate::build::recipe::options::{BuildOptions, HullBasis};
use crate::build::top_down::driver::check_slots;
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::oriented::{BoundingVolume, Moments, OrientedBox};
use crate::scene::Mesh;

/// Triangles or pairs that one task takes. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 8;

/// All clusters that there ever were, by number: first one for each triangle, in the order of the Morton curve, then those that became of
/// two, children before their parents. The last one holds all.
pub struct Clusters {
    refs: Vec<PrimRef>,
    /// Of each cluster.
    hulls: Vec<OrientedBox>,
    /// Of those that became of two.
    merges: Vec<Merge>,
    root: Option<Cluster>,
    /// Common boxes of two clusters that were measured.
    pub measured: u64,
}

impl Clusters {
    /// The cluster's oriented box.
    pub fn hull(&self, cluster: usize) -> &OrientedBox {
        &self.hulls[cluster]
    }

    /// How many clusters there are: one less than twice the triangles.
    pub fn count(&self) -> usize {
        self.hulls.len()
    }

    /// The two that it became of; nothing for a triangle.
    pub fn children(&self, cluster: usize) -> Option<[usize; 2]> {
        Some(self.merges.get(cluster.checked_sub(self.refs.len())?)?.children.map(|child| child as usize))
    }

    /// How many triangles there are in the cluster.
    pub fn triangle_count(&self, cluster: usize) -> usize {
        cluster.checked_sub(self.refs.len()).map_or(1, |merge| self.merges[merge].count as usize)
    }

    /// The mesh's triangles in the cluster.
    pub fn triangles(&self, cluster: usize) -> Vec<u32> {
        let (mut found, mut open) = (Vec::new(), vec![cluster]);
        while let Some(cluster) = open.pop() {
            match self.children(cluster) {
                Some(children) => open.extend(children),
                None => found.push(self.refs[cluster].prim),
            }
        }
        found
    }

    /// Nothing where there is no triangle.
    pub(super) fn into_parts(self) -> Option<(Vec<PrimRef>, Vec<Merge>, Cluster)> {
        Some((self.refs, self.merges, self.root?))
    }
}

/// Merge the triangles until one cluster is left. Of the options, `radius`, `basis` and what leaves depend on are read.
///
/// # Errors
/// Where there are more triangles than numbers for references, or `progress` cancels.
pub fn cluster(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Clusters, BuildError> {
    check_slots(mesh.triangles.len())?;
    let input = PrimRefs::of_mesh(mesh, 0, exec);
    let rules = Rules::new(options, &input.bounds);
    let origin = if input.refs.is_empty() { [0.0; 3] } else { input.bounds.center2().map(|v| 0.5 * f64::from(v)) };
    progress.phase("sort");
    let refs = exec.run(|| morton::sort(input.refs, &input.centroids, exec));
    progress.phase("merge");
    let merger = Merger { mesh, rules, basis: options.basis, origin, exec, progress };
    exec.run(|| merger.run(refs))
}

/// Two live clusters, by their places, the first before the second.
type Pair = [usize; 2];

struct Merger<'a> {
    mesh: &'a Mesh,
    rules: Rules,
    basis: HullBasis,
    /// Moments are about it.
    origin: [f64; 3],
    exec: &'a Executor,
    progress: &'a dyn Progress,
}

/// What is known of all clusters so far.
struct Known {
    clusters: Clusters,
    /// Of each, where boxes are fitted.
    fits: Vec<Fit>,
}

/// How a cluster's box was fitted.
struct Fit {
    surface: Moments,
    /// How many triangles there were when all of them were last looked at.
    all_at: u32,
}

impl Merger<'_> {
    fn run(&self, refs: Vec<PrimRef>) -> Result<Clusters, BuildError> {
        let count = refs.len();
        let corners = |r: &PrimRef| self.corners(r.prim);
        let is_fitted = self.basis == HullBasis::Fit;
        let hulls = self.exec.generate(count, |i| OrientedBox::of_triangle(&corners(&refs[i])));
        let fits = self.exec.generate(if is_fitted { count } else { 0 }, |i| {
            let about_origin = corners(&refs[i]).map(|p| [0, 1, 2].map(|k| p[k] - self.origin[k]));
            Fit { surface: Moments::of_triangle(&about_origin), all_at: 1 }
        });
        let mut live: Vec<Cluster> = (refs.iter().enumerate())
            .map(|(i, r)| {
                let weight = Weight::of_one(self.rules.area(&r.bounds()), self.rules.sah);
                Cluster { weight, bounds: r.bounds(), number: i as u32 }
            })
            .collect();
        let clusters = Clusters { refs, hulls, merges: Vec::new(), root: None, measured: 0 };
        let mut known = Known { clusters, fits };
        known.clusters.hulls.reserve(count.saturating_sub(1));
        known.clusters.merges.reserve(count.saturating_sub(1));
        while live.len() > 1 {
            self.round(&mut live, &mut known)?;
        }
        let mut clusters = known.clusters;
        clusters.root = live.pop();
        Ok(clusters)
    }

    fn corners(&self, triangle: u32) -> [[f64; 3]; 3] {
        self.mesh.triangles[triangle as usize].map(|v| self.mesh.positions[v as usize].map(f64::from))
    }

    /// Proposals, and what comes of them. What becomes one stands in the place of the first.
    fn round(&self, live: &mut Vec<Cluster>, known: &mut Known) -> Result<(), BuildError> {
        let hulls: Vec<OrientedBox> = live.iter().map(|c| known.clusters.hulls[c.number as usize]).collect();
        let found = best_matches(&hulls, self.rules.radius, self.exec, self.progress);
        let (mut partners, measured) = found.ok_or(BuildError::Cancelled)?;
        known.clusters.measured += measured;
        let mut pairs = mutual(&partners);
        if pairs.len() * FEWEST < live.len() {
            pair_the_rest(&mut partners, &mut vec![false; live.len()]);
            pairs = mutual(&partners);
        }

        let joined = self.exec.map_chunks(&pairs, CHUNK, |_, pairs| {
            let mut outline = Outline::default();
            let joined = pairs.iter().map(|pair| self.joined(pair.map(|at| &live[at]), known, &mut outline));
            (!self.progress.is_cancelled()).then(|| joined.collect::<Vec<_>>())
        });
        let joined = joined.into_iter().collect::<Option<Vec<_>>>().ok_or(BuildError::Cancelled)?;
        for ([first, second], (hull, fit)) in pairs.into_iter().zip(joined.into_iter().flatten()) {
            let number = known.clusters.hulls.len() as u32;
            known.clusters.hulls.push(hull);
            known.fits.extend(fit);
            let (merge, cluster) = self.merge(&live[first], &live[second], number);
            known.clusters.merges.push(merge);
            live[first] = cluster;
            live[second].number = GONE;
        }
        live.retain(|cluster| cluster.number != GONE);
        Ok(())
    }

    /// The common box, and how it was fitted if it was.
    fn joined(&self, pair: [&Cluster; 2], known: &Known, outline: &mut Outline) -> (OrientedBox, Option<Fit>) {
        let numbers = pair.map(|cluster| cluster.number as usize);
        let [a, b] = numbers.map(|number| &known.clusters.hulls[number]);
        let plain = a.merged(b);
        if self.basis == HullBasis::Leaf {
            return (plain, None);
        }
        let [p, q] = numbers.map(|number| &known.fits[number]);
        let surface = p.surface.plus(&q.surface);
        let count = (known.clusters.triangle_count(numbers[0]) + known.clusters.triangle_count(numbers[1])) as u32;
        let all_at = if self.open(numbers, known, outline) { count } else { p.all_at.max(q.all_at) };
        let fitted = outline.fit([a.basis, b.basis], &surface);
        let least = fitted.filter(|fitted| fitted.half_area() < plain.half_area()).unwrap_or(plain);
        (least, Some(Fit { surface, all_at }))
    }

    /// What a box around two clusters is fitted to: all triangles where that is little work for what it gains, or else parts. Says whether it is all.
    ///
    /// All of them are looked at where they are an eighth more than when any of them were last looked at. So a triangle is looked at as often as an
    /// eighth can be added up to all triangles, and all work together grows as n·log n however the clusters are nested.
    fn open(&self, from: [usize; 2], known: &Known, outline: &mut Outline) -> bool {
        outline.clear();
        let clusters = &known.clusters;
        let all: usize = from.iter().map(|cluster| clusters.triangle_count(*cluster)).sum();
        let before = from.map(|cluster| known.fits[cluster].all_at).into_iter().fold(1, u32::max) as usize;
        if all <= PARTS || 8 * all >= 9 * before || all == clusters.refs.len() {
            for triangle in from.iter().flat_map(|cluster| clusters.triangles(*cluster)) {
                outline.add_triangle(self.corners(triangle));
            }
            return true;
        }

        // Open the largest cluster into its two, until there are so many or only triangles.
        // With their areas; a triangle has none, since it cannot be opened.
        let part = |cluster: usize| {
            (cluster, clusters.children(cluster).map_or(f64::NEG_INFINITY, |_| clusters.hulls[cluster].half_area()))
        };
        let mut parts = Vec::with_capacity(PARTS);
        parts.extend(from.map(part));
        while parts.len() < PARTS {
            let mut largest = 0;
            for i in 1..parts.len() {
                if parts[i].1 > parts[largest].1 {
                    largest = i;
                }
            }
            let Some([first, second]) = clusters.children(parts[largest].0) else { break };
            parts[largest] = part(first);
            parts.push(part(second));
        }
        for (cluster, _) in parts {
            match clusters.refs.get(cluster) {
                Some(r) => outline.add_triangle(self.corners(r.prim)),
                None => outline.add_box(clusters.hulls[cluster]),
            }
        }
        false
    }

    /// The first child is the one of larger area: its author's rays go there first.
    fn merge(&self, a: &Cluster, b: &Cluster, number: u32) -> (Merge, Cluster) {
        let bounds: Aabb = a.bounds.union(b.bounds);
        let weight = Weight::joined(a.weight, b.weight, self.rules.area(&bounds), &self.rules);
        let swap = self.rules.area(&b.bounds) > self.rules.area(&a.bounds);
        let children = if swap { [b.number, a.number] } else { [a.number, b.number] };
        (Merge { children, count: weight.count, inner: weight.inner }, Cluster { weight, bounds, number })
    }
}

/// What became a part of another. No cluster has this number.
const GONE: u32 = u32::MAX;

/// Who propose to each other.
fn mutual(partners: &[u32]) -> Vec<Pair> {
    let is_mutual = |i: usize| partners[partners[i] as usize] as usize == i;
    (0..partners.len())
        .filter(|i| partners[*i] as usize > *i && is_mutual(*i))
        .map(|i| [i, partners[i] as usize])
        .collect()
}
