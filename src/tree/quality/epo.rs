//! End-point overlap: how much of the surface lies in nodes that do not hold it.
//!
//! EPO = Σ_n C_n · area((S \ S_n) ∩ box_n) / area(S) (Aila, Karras and Laine, "On Quality Metrics of Bounding Volume Hierarchies",
//! 2013, section 4), with the report's costs: what a ray that ends somewhere on the surface S pays for nodes that contain its end
//! but not the triangle there. This is the pure value, not the paper's mix with the SAH. S_n is the set of triangles with a
//! reference below n: with spatial splits a triangle is in the S_n of every node that holds a piece of it. Boxes are closed, so a floor that lies
//! in the bottom face of a chair's box counts, as a ray that ends there does enter the box.
//!
//! [`exact`] clips every triangle with every such box; [`sampled`] asks the same at points of the surface, in bounded time, and says how
//! far off it may be.

use super::{Subtrees, cost_of_visit};
use crate::exec::Executor;
use crate::geom::clip::Polygon;
use crate::geom::{Aabb, Point};
use crate::random::Random;
use crate::tree::Node;
use std::ops::Add;

/// Sums over one tree or several; several together are weighted by the areas of their surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EndPointOverlap {
    /// Σ_n C_n · area((S \ S_n) ∩ box_n).
    cost: f64,
    /// area(S).
    area: f64,
    /// Variance of `cost`, from sampling; 0 if it is exact.
    variance: f64,
    /// Points asked at; 0 if it is exact.
    points: u64,
    /// Nodes visited to know all this.
    visits: u64,
}

impl EndPointOverlap {
    /// 0 where the surface has no area.
    pub fn epo(&self) -> f64 {
        if self.area > 0.0 { self.cost / self.area } else { 0.0 }
    }

    /// How many points were asked at; 0 where every triangle was clipped.
    pub fn points(&self) -> u64 {
        self.points
    }

    /// How many nodes were visited: the work that it took.
    pub fn visits(&self) -> u64 {
        self.visits
    }

    /// One standard deviation of [`EndPointOverlap::epo`] as an estimate, on the high side; 0 where it is exact.
    pub fn standard_error(&self) -> f64 {
        if self.area > 0.0 { self.variance.sqrt() / self.area } else { 0.0 }
    }
}

impl Add for EndPointOverlap {
    type Output = EndPointOverlap;

    fn add(self, other: EndPointOverlap) -> EndPointOverlap {
        EndPointOverlap {
            cost: self.cost + other.cost,
            area: self.area + other.area,
            variance: self.variance + other.variance,
            points: self.points + other.points,
            visits: self.visits.saturating_add(other.visits),
        }
    }
}

/// Triangles or points that one task handles; fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 256;

/// Clip every triangle. The time grows with the number of pairs of a triangle and a foreign node that it reaches into, which is some tens a
/// triangle for a good tree and without bound for a bad one.
pub fn exact(tree: &Subtrees, corners: impl Fn(usize) -> [Point; 3] + Sync, exec: &Executor) -> EndPointOverlap {
    exact_within(tree, corners, u64::MAX, exec).unwrap_or_default()
}

/// [`exact`], as long as it visits about `most_visits` nodes at most.
///
/// # Errors
/// The number of nodes visited before it was clear that there are more.
pub fn exact_within(
    tree: &Subtrees,
    corners: impl Fn(usize) -> [Point; 3] + Sync,
    most_visits: u64,
    exec: &Executor,
) -> Result<EndPointOverlap, u64> {
    // A chunk takes every so manieth triangle, so that each tells what the others will cost. One that takes many times its share is stopped:
    // the whole would take too long, and a single triangle of a bad tree visits every node.
    let count = tree.triangles();
    let chunks = count.div_ceil(CHUNK);
    let most_of_chunk = (most_visits / (chunks.max(1) as u64)).saturating_mul(UNEVEN).saturating_add(LEAST_OF_CHUNK);
    let of_chunk = |chunk: usize| {
        let mut sum = EndPointOverlap::default();
        let mut left = most_of_chunk;
        for t in (chunk..count).step_by(chunks) {
            sum = sum + of_triangle(tree, t, &corners(t), &mut left);
        }
        EndPointOverlap { visits: most_of_chunk - left, ..sum }
    };
    let (mut sum, mut done) = (EndPointOverlap::default(), 0);
    while done < chunks {
        // Rounds of growing size, so that what the ones before cost tells in time what the next one may.
        let round = done.clamp(1, ROUND).min(chunks - done);
        let parts = exec.map_range(round, |k| of_chunk(done + k));
        let stopped = parts.iter().any(|part| part.visits >= most_of_chunk);
        sum = parts.into_iter().fold(sum, Add::add);
        done += round;
        if stopped || sum.visits > most_visits {
            return Err(sum.visits);
        }
    }
    Ok(sum)
}

/// Most chunks a round of [`exact_within`].
const ROUND: usize = 32;
/// A chunk may visit so many times its share of all visits.
const UNEVEN: u64 = 8;
/// And so many in any case.
const LEAST_OF_CHUNK: u64 = 1 << 16;

/// Parts of a triangle below this share of it are rounding, left where it only touches a box.
const TOUCH: f64 = 1e-12;

/// `left`: how many nodes may still be visited. At 0 the answer is worth nothing.
fn of_triangle(tree: &Subtrees, triangle: usize, corners: &[Point; 3], left: &mut u64) -> EndPointOverlap {
    let whole = Polygon::triangle(corners);
    let area = whole.area();
    let bounds = Aabb::from_points(corners);
    let mut cost = 0.0;
    let mut stack = if tree.nodes().is_empty() { Vec::new() } else { vec![0u32] };
    while let Some(i) = stack.pop() {
        if *left == 0 {
            break;
        }
        *left -= 1;
        if bounds.intersection(tree.nodes()[i as usize].bounds()).is_empty() {
            continue;
        }
        if tree.owns(i, triangle) {
            stack.extend(tree.children(i).into_iter().flatten());
        } else {
            cost += below_foreign(tree, i, whole, TOUCH * area, left);
        }
    }
    EndPointOverlap { cost, area, ..EndPointOverlap::default() }
}

/// Σ C_n · area of the polygon's part in n, over a node that does not hold the triangle and all below it. A child's box lies in its
/// parent's, so what the parent left is cut further.
fn below_foreign(tree: &Subtrees, top: u32, whole: Polygon, least: f64, left: &mut u64) -> f64 {
    let mut cost = 0.0;
    let mut stack = vec![(top, whole)];
    while let Some((i, mut part)) = stack.pop() {
        if *left == 0 {
            break;
        }
        *left -= 1;
        let node = &tree.nodes()[i as usize];
        part.cut_exactly(&node.bounds());
        let area = part.area();
        if area <= least {
            continue;
        }
        cost += cost_of_visit(node) * area;
        if let Some(children) = tree.children(i) {
            let reach = part.reach();
            let reached = |c: &u32| !reach.intersection(tree.nodes()[*c as usize].bounds()).is_empty();
            stack.extend(children.into_iter().filter(reached).map(|c| (c, part)));
        }
    }
    cost
}

/// Ask at `points` points, spread over the surface in proportion to area; at fewer where so many nodes contain each of them that more than
/// about `most_visits` would be visited, so that the time is bounded on every tree.
///
/// How far along the accumulated area the points stand follows the golden ratio, which spreads any number of them evenly; where in their
/// triangles, pseudo-random numbers that are the same each time.
pub fn sampled(
    tree: &Subtrees,
    corners: impl Fn(usize) -> [Point; 3] + Sync,
    points: usize,
    most_visits: u64,
    exec: &Executor,
) -> EndPointOverlap {
    let mut area = 0.0;
    let until = |t| {
        area += Polygon::triangle(&corners(t)).area();
        area
    };
    let accumulated: Vec<f64> = (0..tree.triangles()).map(until).collect();
    if points == 0 || area <= 0.0 || !area.is_finite() {
        return EndPointOverlap::default();
    }
    let at_number = |j: u32| {
        let (along, mut random) = ((GOLDEN * (f64::from(j) + 0.5)).fract(), Random::new(u64::from(j)));
        let (u, v) = (random.unit(), random.unit());
        let t = accumulated.partition_point(|a| *a <= along * area).min(tree.triangles() - 1);
        at_point(tree, t, &point_of(&corners(t), u, v))
    };

    // Rounds that double: whether there is another one depends on what the ones before cost, and on nothing else.
    let (mut total, mut done) = (Tally::default(), 0);
    while done < points && total.visits < most_visits {
        let round: Vec<u32> = (done..points.min((2 * done).max(CHUNK))).map(|j| j as u32).collect();
        done += round.len();
        let parts = exec.map_chunks(&round, CHUNK, |_, chunk| {
            let mut sum = Tally::default();
            for j in chunk {
                sum = sum + at_number(*j);
                // Each point may visit every node: a chunk alone could be too much.
                if sum.visits >= most_visits {
                    break;
                }
            }
            sum
        });
        total = parts.into_iter().fold(total, Add::add);
    }
    let count = total.points as f64;
    let mean = total.cost / count;
    let spread = (total.squares / count - mean * mean).max(0.0);
    let variance = spread / count * area * area;
    EndPointOverlap { cost: mean * area, area, variance, points: total.points, visits: total.visits }
}

/// Nodes that may be visited, whatever the tree: about a second's worth on one core.
pub const MOST_VISITS: u64 = 1 << 27;

/// Nodes that may be visited to measure a tree over so many triangles: three times what a good tree takes, so that a bad one takes no
/// longer than a few good ones.
pub fn fair_visits(triangles: usize) -> u64 {
    MOST_VISITS.min((1 << 20) + 128 * triangles as u64)
}

/// The golden ratio less one.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Costs at points: their sum, the sum of their squares, how many points there are and how many nodes were visited to know them.
#[derive(Clone, Copy, Default)]
struct Tally {
    cost: f64,
    squares: f64,
    points: u64,
    visits: u64,
}

impl Add for Tally {
    type Output = Tally;

    fn add(self, other: Tally) -> Tally {
        Tally {
            cost: self.cost + other.cost,
            squares: self.squares + other.squares,
            points: self.points + other.points,
            visits: self.visits + other.visits,
        }
    }
}

/// The point at `(u, v)` of the unit square folded onto the triangle. A coordinate that all corners share comes out exact, so that points of a
/// floor lie in the faces that the floor lies in.
fn point_of(corners: &[Point; 3], u: f64, v: f64) -> [f64; 3] {
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]))
}

/// Σ C_n over the nodes that contain the point and hold no piece of its triangle.
fn at_point(tree: &Subtrees, triangle: usize, point: &[f64; 3]) -> Tally {
    let contains = |n: &Node| (0..3).all(|k| f64::from(n.min[k]) <= point[k] && point[k] <= f64::from(n.max[k]));
    let (mut cost, mut visits) = (0.0, 0);
    let mut stack = if tree.nodes().is_empty() { Vec::new() } else { vec![(0u32, true)] };
    while let Some((i, held)) = stack.pop() {
        visits += 1;
        let node = &tree.nodes()[i as usize];
        if !contains(node) {
            continue;
        }
        let held = held && tree.owns(i, triangle);
        cost += if held { 0.0 } else { cost_of_visit(node) };
        stack.extend(tree.children(i).into_iter().flatten().map(|c| (c, held)));
    }
    Tally { cost, squares: cost * cost, points: 1, visits }
}

#[cfg(test)]
mod tests;
