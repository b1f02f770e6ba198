//! Whether boxes cover a triangle, exactly.
//!
//! What no box covers is open in the triangle, so where there is any of it, it has an area (or, in a triangle without area, a
//! length). Parts without one are therefore left out, and the rest is cut with the planes of the boxes until a box contains a part, which is
//! then covered, or no box reaches into it, which is then a hole. Corners of parts are told by the planes and edges that meet in them and
//! compared by exact predicates ([`corner`]): nothing is rounded, and there is no tolerance.
//!
//! No way is known to decide this for any `k` boxes in less than about `k²` steps: whether strips of three directions cover a triangle is
//! as hard as 3SUM (A. Gajentaan and M. H. Overmars, "On a class of O(n²) problems in computational geometry", 1995). The leaves of trees that
//! were built are no such strips; for all others there is a bound on steps, [`most_steps`].

mod corner;
mod part;

use std::cmp::Ordering;

use crate::geom::{Aabb, Point};
use corner::Whole;
use part::Part;

/// What is known of a triangle and its leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Covered {
    /// The leaves' boxes together contain all of it.
    Whole,
    /// About in the middle of what no leaf covers.
    Hole([f64; 3]),
    /// The bound on steps was reached before.
    Unknown,
}

/// Steps after which a triangle with this many leaves is given up: a step is a look at one box, or a cut.
///
/// What the builders make takes some ten steps a leaf. A few leaves may have any shape: all cells between their planes are within the
/// bound.
pub fn most_steps(boxes: usize) -> u64 {
    (1 << 16) + 512 * boxes as u64
}

/// Finds holes; keeps its memory from one triangle to the next.
#[derive(Default)]
pub struct Cover {
    /// Parts that are left to look at, each with the range of `lists` that has its boxes.
    parts: Vec<(Part, usize, usize)>,
    lists: Vec<u32>,
    planes: Vec<(u8, f32)>,
    /// Steps of all triangles so far.
    steps: u64,
}

/// Up to this many boxes, the plane is sought that leaves least to do; beyond, one that halves them.
const FEW: usize = 8;

impl Cover {
    /// How many steps were taken so far: what tests of the work count.
    #[cfg(any(test, feature = "testing"))]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Whether the closed boxes cover the triangle. All numbers are finite.
    pub fn look(&mut self, corners: [Point; 3], boxes: &[Aabb]) -> Covered {
        let whole = Whole::new(corners);
        let Some(first) = Part::whole(&whole) else {
            let point = Aabb::from_points(&corners);
            self.steps += boxes.len() as u64;
            let held = boxes.iter().any(|b| b.contains(&point));
            return if held { Covered::Whole } else { Covered::Hole(corners[0].map(f64::from)) };
        };
        let end = self.steps + most_steps(boxes.len());
        self.lists.clear();
        self.lists.extend(0..boxes.len() as u32);
        self.parts.clear();
        self.parts.push((first, 0, boxes.len()));
        while let Some((part, from, to)) = self.parts.pop() {
            // What lies behind belongs to parts that are done.
            self.lists.truncate(to);
            self.steps += (to - from) as u64 + 1;
            if self.steps > end {
                return Covered::Unknown;
            }
            match self.next_plane(&whole, &part, boxes, from, to) {
                Next::Done => {}
                Next::Nobody => return Covered::Hole(part.middle(&whole)),
                Next::Cut { axis, plane } => {
                    let reached = self.lists.len();
                    self.parts.extend(part.cut(&whole, axis, plane).map(|half| (half, to, reached)));
                }
            }
        }
        Covered::Whole
    }

    /// Put the boxes that reach into the part behind the lists, unless one contains it, and choose where to cut.
    fn next_plane(&mut self, whole: &Whole, part: &Part, boxes: &[Aabb], from: usize, to: usize) -> Next {
        self.planes.clear();
        let mut best: Option<(usize, f32, Next)> = None;
        for i in from..to {
            let index = self.lists[i];
            let b = &boxes[index as usize];
            let start = self.planes.len();
            if !reaches(whole, part, b, &mut self.planes) {
                self.planes.truncate(start);
                continue;
            }
            let crossing = &self.planes[start..];
            if crossing.is_empty() {
                return Next::Done;
            }
            self.lists.push(index);
            // The box with the fewest planes that cut the part, and of these the plane that halves it best.
            let off_middle = |axis: u8, plane: f32| {
                let (low, high) = (part.outer.min[usize::from(axis)], part.outer.max[usize::from(axis)]);
                ((plane - low) / (high - low) - 0.5).abs()
            };
            for (axis, plane) in crossing.iter().copied() {
                let off = off_middle(axis, plane);
                if best.as_ref().is_none_or(|(n, o, _)| (crossing.len(), off) < (*n, *o)) {
                    best = Some((crossing.len(), off, Next::Cut { axis: usize::from(axis), plane }));
                }
            }
        }
        if self.lists.len() - to > FEW {
            return self.halving_plane();
        }
        best.map_or(Next::Nobody, |best| best.2)
    }

    /// The middle one of the planes that cut a part, of the axis that has most of them.
    fn halving_plane(&mut self) -> Next {
        let count = |axis: u8| self.planes.iter().filter(|p| p.0 == axis).count();
        let (axis, most) = (0..3).map(|axis| (axis, count(axis))).fold((0, 0), |a, b| if b.1 > a.1 { b } else { a });
        self.planes.retain(|p| p.0 == axis);
        let (_, middle, _) = self.planes.select_nth_unstable_by(most / 2, |a, b| a.1.total_cmp(&b.1));
        Next::Cut { axis: usize::from(axis), plane: middle.1 }
    }
}

enum Next {
    /// A box contains the part.
    Done,
    /// No box reaches into it.
    Nobody,
    Cut {
        axis: usize,
        plane: f32,
    },
}

/// Whether a box has more in common with the part than a border; `planes` gets those of its planes that cut the part.
fn reaches(whole: &Whole, part: &Part, b: &Aabb, planes: &mut Vec<(u8, f32)>) -> bool {
    for axis in 0..3 {
        match part.side(whole, axis, b.max[axis]) {
            Ordering::Less => {}
            Ordering::Equal => planes.push((axis as u8, b.max[axis])),
            Ordering::Greater => return false,
        }
        // A part in the plane lies on both sides of it: `side` says `Less`, and the box holds it.
        match part.side(whole, axis, b.min[axis]) {
            Ordering::Greater => {}
            Ordering::Equal => planes.push((axis as u8, b.min[axis])),
            Ordering::Less if part.outer.min[axis] >= b.min[axis] => {}
            Ordering::Less => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests;
