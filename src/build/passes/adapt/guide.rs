//! The rays that a tree is adapted to, and how often they visit its nodes.

use crate::build::passes::work_tree::WorkTree;
use crate::exec::Executor;
use crate::geom::Ray;

/// Parts of the rays that are followed through the tree side by side, each with counts of its own.
const PARTS: usize = 4;
/// A ray that visits more nodes than this, because everything overlaps everything, is followed no further.
const MOST_VISITED: u32 = 1 << 12;
/// A direction's inverse stays below this, so that no distance is the product of infinity and zero.
const STEEPEST: f32 = 1e20;
/// By how much a ray is lengthened, so that rounding does not end it before the box of what it hits.
const BEYOND: f32 = 1.0 + 1e-5;

/// A ray from its origin to its hit, ready for boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    pub origin: [f32; 3],
    pub inverse: [f32; 3],
    pub end: f32,
}

impl Segment {
    pub fn of(ray: &Ray) -> Segment {
        let inverse = ray.direction.map(|d| (1.0 / d).clamp(-STEEPEST, STEEPEST));
        Segment { origin: ray.origin, inverse, end: (ray.t_max * BEYOND).min(f32::MAX) }
    }

    /// Whether it touches a box. A statistic: a box that is missed by rounding is not counted.
    #[inline(always)]
    pub fn meets(&self, min: &[f32; 3], max: &[f32; 3]) -> bool {
        let distances = |k: usize| {
            let (a, b) = ((min[k] - self.origin[k]) * self.inverse[k], (max[k] - self.origin[k]) * self.inverse[k]);
            (smaller(a, b), larger(a, b))
        };
        let [x, y, z] = [distances(0), distances(1), distances(2)];
        larger(larger(x.0, y.0), larger(z.0, 0.0)) <= smaller(smaller(x.1, y.1), smaller(z.1, self.end))
    }
}

/// The smaller of two numbers, of which none is NaN: one instruction, where [`f32::min`] is several.
#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Rays of a mesh, each up to what it hits: who traces them stands above this room.
#[derive(Clone, Debug)]
pub struct Guide {
    pub(super) segments: Vec<Segment>,
}

impl Guide {
    /// Rays that end at what they hit.
    pub fn new(rays: &[Ray]) -> Guide {
        Guide { segments: rays.iter().map(Segment::of).collect() }
    }

    /// The numbers of all rays.
    pub(super) fn all(&self) -> Vec<u32> {
        (0..self.segments.len() as u32).collect()
    }

    /// Those of the rays that meet a box.
    pub(super) fn among(&self, rays: &[u32], min: &[f32; 3], max: &[f32; 3]) -> Vec<u32> {
        let mut met = Vec::with_capacity(rays.len());
        for &ray in rays {
            if self.segments[ray as usize].meets(min, max) {
                met.push(ray);
            }
        }
        met
    }

    /// By slot: how many rays meet its box; fewer where rays visit thousands of nodes.
    pub(super) fn visits(&self, tree: &WorkTree, exec: &Executor) -> Vec<u32> {
        let size = self.segments.len().div_ceil(PARTS).max(1);
        let parts = exec.map_chunks(&self.segments, size, |_, chunk| {
            let (mut visits, mut open) = (vec![0u32; tree.slots.len()], Vec::new());
            for segment in chunk {
                if segment.meets(&tree.slots[0].min, &tree.slots[0].max) {
                    open.push(0);
                }
                let mut left = MOST_VISITED;
                while let Some(at) = open.pop() {
                    if left == 0 {
                        open.clear();
                        break;
                    }
                    left -= 1;
                    visits[at as usize] += 1;
                    let slot = &tree.slots[at as usize];
                    if slot.is_leaf() {
                        continue;
                    }
                    for index in slot.children() {
                        let child = &tree.slots[index as usize];
                        if segment.meets(&child.min, &child.max) {
                            open.push(index);
                        }
                    }
                }
            }
            visits
        });
        let sum = |mut a: Vec<u32>, b: Vec<u32>| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        };
        parts.into_iter().reduce(sum).unwrap_or_else(|| vec![0; tree.slots.len()])
    }
}
