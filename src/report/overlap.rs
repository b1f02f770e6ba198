//! [`EpoReport`]: the end-point overlap of a file's trees.

use crate::cache::{BlasView, View};
use crate::exec::Executor;
use crate::tree::quality::Subtrees;
use crate::tree::quality::epo::{EndPointOverlap, MOST_VISITS, exact, exact_within, fair_visits, sampled};
use serde::Serialize;

/// How [`EpoReport::of_view`] measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EpoMode {
    /// Clip every triangle with every node's box that it reaches into: minutes for millions of triangles or for a bad tree.
    Exact,
    /// Ask at this many points of the surface: bounded time, with a standard error.
    Points(u32),
    /// The first for each tree for which that takes no more than a few times the work of a good tree of its size, and about a second on one
    /// core at most; otherwise the second, within a third of that bound.
    Auto(u32),
}

/// The end-point overlap of all BLASes together, weighted by the areas of their surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EpoReport {
    pub value: f64,
    /// One standard deviation of `value`; 0 where it is exact.
    pub standard_error: f64,
    /// Points of the surface asked at; 0 where it is exact.
    pub points: u64,
}

impl EpoReport {
    pub fn of_view(view: &View, mode: EpoMode, exec: &Executor) -> EpoReport {
        EpoReport::measured(view, mode, exec).0
    }

    /// And how many nodes were visited for it.
    fn measured(view: &View, mode: EpoMode, exec: &Executor) -> (EpoReport, u64) {
        let blases = || (0..view.blases.len()).filter_map(|i| view.blas(i));
        let surface: f64 = blases().map(|b| area(&b)).sum();
        let of_blas = |blas: BlasView| {
            let mesh = Slots::of_blas(&blas);
            let tree = Subtrees::new(blas.nodes, &mesh.refs, mesh.first_slot.len());
            let corners = |t: usize| blas.triangles[mesh.first_slot[t] as usize].corners();
            // Each tree gets points by its share of the surface, and some in any case.
            let share = if surface > 0.0 { area(&blas) / surface } else { 0.0 };
            let at_points = |points, most_visits| {
                sampled(&tree, corners, (f64::from(points) * share).ceil() as usize, most_visits, exec)
            };
            match mode {
                EpoMode::Exact => (exact(&tree, corners, exec), 0),
                EpoMode::Points(points) => (at_points(points, MOST_VISITS), 0),
                EpoMode::Auto(points) => {
                    let most = fair_visits(tree.triangles());
                    match exact_within(&tree, corners, most, exec) {
                        Ok(overlap) => (overlap, 0),
                        // Both together take about as long as an exact answer for a good tree.
                        Err(in_vain) => (at_points(points, most / 3), in_vain),
                    }
                }
            }
        };
        let parts = blases().map(of_blas);
        let (sum, in_vain) =
            parts.fold((EndPointOverlap::default(), 0), |(sum, vain), (one, more)| (sum + one, vain + more));
        let report = EpoReport { value: sum.epo(), standard_error: sum.standard_error(), points: sum.points() };
        (report, sum.visits().saturating_add(in_vain))
    }
}

/// Of the leaf-ordered records, duplicates included: what shares points among trees need not be exact.
fn area(blas: &BlasView) -> f64 {
    blas.triangles.iter().map(|t| crate::geom::clip::Polygon::triangle(&t.corners()).area()).sum()
}

/// The distinct triangles of a BLAS, numbered by part and primitive.
struct Slots {
    /// For each slot of the leaf order the triangle there.
    refs: Vec<u32>,
    /// For each triangle the first slot in which it stands.
    first_slot: Vec<u32>,
}

impl Slots {
    fn of_blas(blas: &BlasView) -> Slots {
        let key = |slot: u32| {
            let t = &blas.triangles[slot as usize];
            (t.geom, t.prim)
        };
        let mut order: Vec<u32> = (0..blas.triangles.len() as u32).collect();
        order.sort_by_key(|slot| (key(*slot), *slot));
        let mut out = Slots { refs: vec![0; order.len()], first_slot: Vec::new() };
        for (i, &slot) in order.iter().enumerate() {
            if i == 0 || key(order[i - 1]) != key(slot) {
                out.first_slot.push(slot);
            }
            out.refs[slot as usize] = out.first_slot.len() as u32 - 1;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Method, NoProgress};
    use crate::cache::Image;
    use crate::compile::build_tree;
    use crate::scene::Mesh;
    use crate::tree::Accel;

    /// Long slivers that cross each other, so that spatial splits happen.
    fn crossing() -> Mesh {
        soup((0..200u32).map(|i| {
            let t = i as f32 / 200.0;
            let (a, b) = if i % 2 == 0 { ([t, 0.0, t], [t, 1.0, 0.5]) } else { ([0.0, t, t], [1.0, t, 0.5]) };
            [a, b, [a[0] + 0.004, a[1] + 0.004, a[2]]]
        }))
    }

    #[test]
    fn a_file_gives_what_its_tree_gives() {
        let (mesh, exec) = (crossing(), Executor::sequential());
        let tree = build_tree(&mesh, &BuildOptions::default(), &exec, &NoProgress).unwrap();
        assert!(tree.refs.len() > 200, "splits");
        let subtrees = Subtrees::new(&tree.nodes, &tree.refs, 200);
        let expected = exact(&subtrees, |t| mesh.corners(t), &exec).epo();
        let accel =
            |n: usize| Accel { meshes: vec![mesh.clone(); n], blases: vec![tree.clone(); n], ..Accel::default() };
        for copies in [1, 3] {
            let image = Image::new(&accel(copies), &Executor::sequential()).unwrap();
            let report = EpoReport::of_view(&image.view(), EpoMode::Exact, &exec);
            assert!((report.value - expected).abs() < 1e-9 * expected && report.points == 0, "{report:?}, {expected}");
            let rough = EpoReport::of_view(&image.view(), EpoMode::Points(6000), &exec);
            assert!((rough.value - expected).abs() < 4.0 * rough.standard_error, "{rough:?} for {expected}");
            assert!((6000..=6000 + copies as u64).contains(&rough.points));
        }
    }

    fn soup(triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Mesh {
        let positions: Vec<[f32; 3]> = triangles.flatten().collect();
        let corners = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh::new("", positions, corners).unwrap()
    }

    fn work(mesh: &Mesh) -> (EpoReport, u64) {
        let exec = Executor::sequential();
        let options = BuildOptions { method: Method::Binned, ..BuildOptions::default() };
        let tree = build_tree(mesh, &options, &exec, &NoProgress).unwrap();
        let image = Image::of_tree(mesh, &tree, &exec).unwrap();
        EpoReport::measured(&image.view(), EpoMode::Auto(1 << 18), &exec)
    }

    /// The same triangle again and again, slivers that cross everything, triangles as large as the scene: every triangle lies in every node.
    #[test]
    fn the_work_on_bad_trees_is_a_few_times_that_on_a_good_one() {
        let count = 20_000u32;
        let share = |i: u32| f64::from(i) / f64::from(count);
        let at = |i: u32, k: u32| (share(i) * f64::from(1 + 7 * k)).fract() as f32;
        let sheet = soup((0..count).map(|i| {
            let (x, y) = ((i % 141) as f32, (i / 141) as f32);
            [[x, y, 0.0], [x + 1.0, y, 0.0], [x, y + 1.0, 0.0]]
        }));
        let (good, regular) = work(&sheet);
        assert_eq!(good.points, 0, "a good tree is measured exactly");
        let identical = soup((0..count).map(|_| [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
        let slivers = soup((0..count).map(|i| {
            let (a, b) = ([at(i, 0), at(i, 1), 0.0], [at(i, 2), at(i, 3), 1.0]);
            [a, b, [a[0] + 1e-3, a[1], 0.0]]
        }));
        let spanning =
            soup((0..count).map(|i| [[0.0, at(i, 0), at(i, 1)], [1.0, at(i, 2), at(i, 3)], [at(i, 4), at(i, 5), 1.0]]));
        for (name, mesh) in [("identical", identical), ("slivers", slivers), ("spanning", spanning)] {
            let (report, visits) = work(&mesh);
            assert!(report.points > 0, "{name}: too much to clip, so it is sampled");
            assert!(visits < fair_visits(count as usize), "{name}: {visits} visits, the regular scene {regular}");
        }
    }
}
