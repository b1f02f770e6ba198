//! Reinsertion over several poses of one mesh: each node has a box in each of them, and the weighted mean of their areas stands in the place of its
//! area (Bittner and Meister, "T-SAH: Animation Optimized Bounding Volume Hierarchies", 2015).
//!
//! What a pose weighs is put into its coordinates: lengths are multiplied by the root of the weight. So areas of all poses are simply added,
//! four poses at a time, a lane each.

use super::emit::{Collapse, emit};
use super::reinsert::reinsert;
use super::slot::{LEAF, Slot};
use super::volumes::Volumes;
use super::work_tree::WorkTree;
use crate::build::cost::Sah;
use crate::build::error::BuildError;
use crate::build::progress::Progress;
use crate::build::recipe::options::BuildOptions;
use crate::exec::Executor;
use crate::geom::Point;
use crate::simd::Lanes;
use crate::tree::Tree;

/// Where a mesh's vertices are at some moment, and how lengths are measured there.
pub struct ScaledPose<'a> {
    pub positions: &'a [Point],
    /// What lengths are multiplied by: the square of it is what an area weighs.
    pub scale: f64,
    /// Near corner of the box around all: coordinates are measured from there, so that they keep their digits.
    pub origin: Point,
}

/// Most poses that a tree can be fitted to at once.
pub const MOST_POSES: usize = 16;

/// Bytes that each node takes for so many poses.
pub const fn bytes_per_node(poses: usize) -> usize {
    groups(poses) * size_of::<Group>()
}

/// Rows and leaves that a task computes. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 10;

/// Groups of four that so many poses take.
const fn groups(poses: usize) -> usize {
    match poses.div_ceil(4) {
        3 => 4,
        n => n,
    }
}

/// The tree with its subtrees moved, at most `options.reinsert` rounds, and with leaves in the place of subtrees where that is cheaper over all poses;
/// `None` where there is nothing to gain. `poses` are at most [`MOST_POSES`], and in each the root has an area. The boxes of the result are to be
/// fitted by the caller.
pub fn over_poses(
    tree: &Tree,
    triangles: &[[u32; 3]],
    poses: &[ScaledPose],
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Option<Tree>, BuildError> {
    match groups(poses.len()) {
        0 => Ok(None),
        1 => moved::<1>(tree, triangles, poses, options, exec, progress),
        2 => moved::<2>(tree, triangles, poses, options, exec, progress),
        _ => moved::<4>(tree, triangles, poses, options, exec, progress),
    }
}

fn moved<const GROUPS: usize>(
    tree: &Tree,
    triangles: &[[u32; 3]],
    poses: &[ScaledPose],
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Option<Tree>, BuildError> {
    progress.phase("reinsert: links");
    let Some(mut work) = WorkTree::new(tree, exec) else { return Ok(None) };
    let mut rows = Rows::<GROUPS>::of(tree, &work, triangles, poses, exec);
    work.set_areas(|slot| area(&rows.held(slot)), exec);
    let before = work.inner_area;
    exec.run(|| reinsert(&mut work, &mut rows, options.reinsert, exec, progress))?;
    // Moves of one round can spoil each other's gain. If so little is left of it that rounding could be all, only leaves are joined.
    if options.reinsert > 0 && !(work.inner_area < before * (1.0 - 1e-6)) {
        let Some(again) = WorkTree::new(tree, exec) else { return Ok(None) };
        work = again;
        rows = Rows::of(tree, &work, triangles, poses, exec);
        work.set_areas(|slot| area(&rows.held(slot)), exec);
    }
    if progress.is_cancelled() {
        return Err(BuildError::Cancelled);
    }
    progress.phase("reinsert: put together");
    let sah = Sah { traversal: options.traversal_cost, intersection: options.intersection_cost };
    let collapse = Collapse { sah, max_leaf: options.max_leaf as usize };
    Ok(Some(emit(&work, &tree.refs, Some(collapse), exec)))
}

/// A node's boxes in four poses.
#[derive(Clone, Copy, PartialEq)]
struct Group {
    min: [Lanes; 3],
    max: [Lanes; 3],
}

const EMPTY: Group = Group { min: [Lanes::splat(f32::INFINITY); 3], max: [Lanes::splat(f32::NEG_INFINITY); 3] };

impl Group {
    #[inline(always)]
    fn union(&self, other: &Group) -> Group {
        Group {
            min: [0, 1, 2].map(|k| self.min[k].min(other.min[k])),
            max: [0, 1, 2].map(|k| self.max[k].max(other.max[k])),
        }
    }

    #[inline(always)]
    fn grow(&self, corner: &[Lanes; 3]) -> Group {
        self.union(&Group { min: *corner, max: *corner })
    }

    #[inline(always)]
    fn areas(&self) -> Lanes {
        let [x, y, z] = [0, 1, 2].map(|k| self.max[k].minus(self.min[k]));
        x.times(y).plus(y.times(z)).plus(z.times(x))
    }
}

#[inline(always)]
fn sum(lanes: Lanes) -> f32 {
    let [a, b, c, d] = lanes.0;
    (a + c) + (b + d)
}

/// The sum over all poses.
#[inline(always)]
fn area<const GROUPS: usize>(boxes: &[Group; GROUPS]) -> f32 {
    sum(boxes.iter().fold(Lanes::splat(0.0), |all, group| all.plus(group.areas())))
}

/// The boxes of all nodes. A row belongs to what a slot's link names, so it need not move when what the slot holds does.
struct Rows<const GROUPS: usize> {
    /// By pair the boxes of the node that has it as its children; behind them, by the first reference, those of leaves.
    rows: Vec<[Group; GROUPS]>,
    pairs: usize,
}

impl<const GROUPS: usize> Rows<GROUPS> {
    fn of(tree: &Tree, work: &WorkTree, triangles: &[[u32; 3]], poses: &[ScaledPose], exec: &Executor) -> Rows<GROUPS> {
        let vertices = vertices::<GROUPS>(poses, exec);
        let pairs = tree.nodes.len() / 2;
        let mut rows = vec![[EMPTY; GROUPS]; pairs + tree.refs.len()];
        exec.map_chunks_mut(&mut rows[pairs..], CHUNK, |chunk_index, chunk| {
            for (i, row) in chunk.iter_mut().enumerate() {
                let first = chunk_index * CHUNK + i;
                // Empty where no leaf begins.
                let refs = &tree.refs[first..first + work.leaf_count(first)];
                let corners = refs.iter().flat_map(|&triangle| triangles[triangle as usize]);
                for vertex in corners.map(|v| &vertices[v as usize]) {
                    for (group, corner) in row.iter_mut().zip(vertex) {
                        *group = group.grow(corner);
                    }
                }
            }
        });
        let mut out = Rows { rows, pairs };
        // Children stand behind their parents.
        for slot in work.slots.iter().rev().filter(|slot| !slot.is_leaf() && slot.link != 0) {
            out.around(slot.link, &work.slots);
        }
        out
    }

    #[inline(always)]
    fn row(&self, slot: &Slot) -> &[Group; GROUPS] {
        let row = if slot.is_leaf() { self.pairs + (slot.link & !LEAF) as usize } else { slot.link as usize };
        &self.rows[row]
    }

    /// Let the row of a pair's parent be around both.
    fn around(&mut self, pair: u32, slots: &[Slot]) {
        let [first, second] = [0, 1].map(|k| self.row(&slots[2 * pair as usize + k]));
        self.rows[pair as usize] = std::array::from_fn(|g| first[g].union(&second[g]));
    }
}

/// All vertices in all poses, as lengths are measured there; the origin where there is no pose.
fn vertices<const GROUPS: usize>(poses: &[ScaledPose], exec: &Executor) -> Vec<[[Lanes; 3]; GROUPS]> {
    let count = poses.iter().map(|pose| pose.positions.len()).min().unwrap_or(0);
    exec.generate(count, |v| {
        let mut all = [[Lanes::splat(0.0); 3]; GROUPS];
        for (i, pose) in poses.iter().enumerate() {
            for axis in 0..3 {
                let along = f64::from(pose.positions[v][axis]) - f64::from(pose.origin[axis]);
                all[i / 4][axis].0[i % 4] = (along * pose.scale) as f32;
            }
        }
        all
    })
}

impl<const GROUPS: usize> Volumes for Rows<GROUPS> {
    type Held = [Group; GROUPS];

    #[inline(always)]
    fn held(&self, slot: &Slot) -> [Group; GROUPS] {
        *self.row(slot)
    }

    #[inline(always)]
    fn area_with(&self, slot: &Slot, held: &[Group; GROUPS]) -> f32 {
        let row = self.row(slot);
        sum((0..GROUPS).fold(Lanes::splat(0.0), |all, g| all.plus(row[g].union(&held[g]).areas())))
    }

    #[inline(always)]
    fn join(&self, slot: &Slot, held: &mut [Group; GROUPS]) -> f32 {
        let row = self.row(slot);
        for g in 0..GROUPS {
            held[g] = held[g].union(&row[g]);
        }
        area(held)
    }

    #[inline(always)]
    fn is(&self, slot: &Slot, held: &[Group; GROUPS]) -> bool {
        self.row(slot) == held
    }

    #[inline(always)]
    fn enclose(&mut self, slots: &mut [Slot], at: u32) -> f32 {
        let pair = slots[at as usize].link;
        self.around(pair, slots);
        area(&self.rows[pair as usize])
    }
}
