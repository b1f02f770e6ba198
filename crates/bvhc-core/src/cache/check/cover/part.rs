use std::cmp::Ordering;

use super::corner::{Corner, Whole};
use crate::geom::{Aabb, clip};

/// A triangle has three corners, and each of six sides of a box adds one at most; planes of one axis are parallel, so that only two of
/// them bound a part.
const MOST: usize = 9;

/// What runs from one corner to the next.
#[derive(Clone, Copy, Debug)]
enum Line {
    Edge(u8),
    Plane { axis: u8, plane: f32 },
}

/// A convex part of a triangle with an area, or of a triangle without area a part with a length.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    corners: [(Corner, Line); MOST],
    len: usize,
    /// A box around the part, rounded outward.
    pub outer: Aabb,
}

impl Part {
    /// The whole triangle; if it has no area, the longest of its edges; `None` if it is a point.
    pub fn whole(whole: &Whole) -> Option<Part> {
        let outer = Aabb::from_points(&whole.corners);
        let none = (Corner::Own(0), Line::Edge(0));
        let mut part = Part { corners: [none; MOST], len: 0, outer };
        if whole.normal.iter().any(|n| n.is_ne()) {
            (0..3).for_each(|i| part.push(Corner::Own(i), Line::Edge(i)));
            return Some(part);
        }
        let axis = (0..3).find(|axis| outer.min[*axis] < outer.max[*axis])?;
        let end = |at: f32| (0..3u8).find(|i| whole.corners[usize::from(*i)][axis] == at).unwrap_or(0);
        let (low, high) = (end(outer.min[axis]), end(outer.max[axis]));
        let edge = if (low + 1) % 3 == high { low } else { high };
        part.push(Corner::Own(low), Line::Edge(edge));
        part.push(Corner::Own(high), Line::Edge(edge));
        Some(part)
    }

    /// How a plane `x[axis] = plane` lies to the part: `Less` where the part lies below or on it, `Greater` where it lies above or on
    /// it, `Equal` where it has something on both sides.
    pub fn side(&self, whole: &Whole, axis: usize, plane: f32) -> Ordering {
        if self.outer.max[axis] <= plane {
            return Ordering::Less;
        }
        if self.outer.min[axis] >= plane {
            return Ordering::Greater;
        }
        let (mut below, mut above) = (false, false);
        for (corner, _) in &self.corners[..self.len] {
            match whole.compare(corner, axis, plane) {
                Ordering::Less => below = true,
                Ordering::Equal => {}
                Ordering::Greater => above = true,
            }
            if below && above {
                return Ordering::Equal;
            }
        }
        if above { Ordering::Greater } else { Ordering::Less }
    }

    /// The parts below and above a plane that crosses the part.
    pub fn cut(&self, whole: &Whole, axis: usize, plane: f32) -> [Part; 2] {
        let mut sides = [Ordering::Equal; MOST];
        for (side, (corner, _)) in sides.iter_mut().zip(&self.corners[..self.len]) {
            *side = whole.compare(corner, axis, plane);
        }
        // Tight boxes decide most comparisons to come, and builders' boxes are the same ones.
        let (below, above) = clip::split(&whole.corners, axis, plane, &self.outer);
        let line = Line::Plane { axis: axis as u8, plane };
        [self.keep(&sides, Ordering::Less, line, below), self.keep(&sides, Ordering::Greater, line, above)]
    }

    /// What lies on one side of a plane, the plane's line included (I. E. Sutherland and G. W. Hodgman, "Reentrant Polygon Clipping", 1974).
    fn keep(&self, sides: &[Ordering; MOST], kept: Ordering, cut: Line, outer: Aabb) -> Part {
        let mut out = Part { len: 0, outer, ..*self };
        for i in 0..self.len {
            let next = if i + 1 == self.len { 0 } else { i + 1 };
            let ((corner, line), here, there) = (self.corners[i], sides[i], sides[next]);
            if here == kept {
                out.push(corner, line);
            } else if here == Ordering::Equal {
                out.push(corner, if there == kept.reverse() { cut } else { line });
            }
            // The way back along a length meets the plane where the way there did.
            let crosses = here != Ordering::Equal && there == here.reverse() && (self.len > 2 || i == 0);
            if crosses {
                out.push(meet(line, cut), if here == kept { cut } else { line });
            }
        }
        out
    }

    fn push(&mut self, corner: Corner, line: Line) {
        if let Some(slot) = self.corners.get_mut(self.len) {
            *slot = (corner, line);
            self.len += 1;
        }
    }

    /// A point inside, roughly.
    pub fn middle(&self, whole: &Whole) -> [f64; 3] {
        let share = 1.0 / self.len as f64;
        let points = self.corners[..self.len].iter().map(|(corner, _)| whole.about(corner));
        points.fold([0.0; 3], |sum, p| [0, 1, 2].map(|k| sum[k] + share * p[k]))
    }
}

/// Where a line of the part meets the plane that cuts it.
fn meet(line: Line, cut: Line) -> Corner {
    match (line, cut) {
        (Line::Edge(edge), Line::Plane { axis, plane }) => Corner::OnEdge { edge, axis, plane },
        (Line::Plane { axis: a, plane: m }, Line::Plane { axis: b, plane: n }) => {
            Corner::Inside { axes: [a, b], planes: [m, n] }
        }
        // Nothing is cut along an edge.
        (_, Line::Edge(edge)) => Corner::Own(edge),
    }
}
