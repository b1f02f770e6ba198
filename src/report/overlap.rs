//! [`EpoReport`]: the end-point overlap of a file's trees.

use crate::cache::{BlasView, View};
use crate::exec::Executor;
use crate::tree::quality::Subtrees;
use crate::tree::quality::epo::{EndPointOverlap, MOST_VISITS, exact, exact_within, sampled};
use serde::Serialize;
use std::ops::Add;

/// How [`EpoReport::of_view`] measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EpoMode {
    /// Clip every triangle with every node's box that it reaches into: minutes for millions of triangles or for a bad tree.
    Exact,
    /// Ask at this many points of the surface: bounded time, with a standard error.
    Points(u32),
    /// The first for each tree for which that takes about a second on one core at most, otherwise the second.
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
        let blases = || (0..view.blases.len()).filter_map(|i| view.blas(i));
        let surface: f64 = blases().map(|b| area(&b)).sum();
        let of_blas = |blas: BlasView| {
            let mesh = Slots::of_blas(&blas);
            let tree = Subtrees::new(blas.nodes, &mesh.refs, mesh.first_slot.len());
            let corners = |t: usize| blas.triangles[mesh.first_slot[t] as usize].corners();
            // Each tree gets points by its share of the surface, and some in any case.
            let share = if surface > 0.0 { area(&blas) / surface } else { 0.0 };
            let at_points = |points| sampled(&tree, corners, (f64::from(points) * share).ceil() as usize, exec);
            match mode {
                EpoMode::Exact => exact(&tree, corners, exec),
                EpoMode::Points(points) => at_points(points),
                EpoMode::Auto(points) => {
                    exact_within(&tree, corners, MOST_VISITS, exec).unwrap_or_else(|| at_points(points))
                }
            }
        };
        let sum = blases().map(of_blas).fold(EndPointOverlap::default(), Add::add);
        EpoReport { value: sum.epo(), standard_error: sum.standard_error(), points: sum.points() }
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
    use crate::build::{BuildOptions, NoProgress};
    use crate::cache::Image;
    use crate::compile::build_tree;
    use crate::scene::{Mesh, Part};
    use crate::tree::Accel;

    /// Long slivers that cross each other, so that spatial splits happen.
    fn crossing() -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..200u32 {
            let (t, n) = (i as f32 / 200.0, 3 * i);
            let (a, b) = if i % 2 == 0 { ([t, 0.0, t], [t, 1.0, 0.5]) } else { ([0.0, t, t], [1.0, t, 0.5]) };
            mesh.positions.extend([a, b, [a[0] + 0.004, a[1] + 0.004, a[2]]]);
            mesh.triangles.push([n, n + 1, n + 2]);
        }
        mesh.parts = vec![Part { triangle_count: 200, prim_count: 200, ..Part::default() }];
        mesh
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
}
