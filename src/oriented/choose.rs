//! Which subtrees of a finished tree are worth a basis of their own, by counted rays.

use super::turned::{Segment, Turned, Work};
use super::{Basis, Extremes, OrientedBox, ditetrahedron, hull_facets, least};
use crate::exec::Executor;
use crate::layout::NEST;

/// Subtrees of fewer triangles stay as they are, and those that fewer rays come to.
const FEWEST_TRIANGLES: usize = 8;
const FEWEST_RAYS: usize = 128;
/// Rays of a task: an even number, so that halves do not depend on it.
const CHUNK: usize = 256;
/// A basis is taken where rays then pay at least so much less below: one half of the rays, and the other.
const GAIN: f64 = 0.05;

/// Where bases come from.
#[derive(Clone, Debug)]
pub enum Choice {
    /// Any rotation: DiTO-14 and the hull's facets.
    Free,
    /// The one of these in which a subtree's box is least.
    Among(Vec<Basis>),
}

/// Rotations by quaternions of whole numbers up to 3, each once but for turns that swap axes: spread over all there are.
pub fn discrete() -> Vec<Basis> {
    let mut found: Vec<Basis> = Vec::new();
    let part = |code: u32, place: u32| f64::from(code / 7u32.pow(place) % 7) - 3.0;
    for code in 0..7u32.pow(4) {
        let [w, x, y, z] = [0, 1, 2, 3].map(|place| part(code, place));
        let x_axis = [w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)];
        let y_axis = [2.0 * (x * y - w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z + w * x)];
        let basis = Basis::along(x_axis, y_axis);
        let is_like = |other: &Basis| {
            let along = |axis: &[f64; 3]| other.coordinates(*axis).iter().any(|c| c.abs() > 1.0 - 1e-9);
            basis.axes().iter().all(along)
        };
        if !found.iter().any(is_like) {
            found.push(basis);
        }
    }
    found
}

/// Turn what pays, from the root down; returns how many subtrees have a basis that the node above has not.
pub fn orient(turned: &mut Turned, rays: &[Segment], choice: &Choice, exec: &Executor) -> usize {
    let all: Vec<u32> = (0..rays.len() as u32).collect();
    Chooser { rays, choice, exec }.below(turned, 0, (Basis::AXES, 0), &all)
}

struct Chooser<'a> {
    rays: &'a [Segment],
    choice: &'a Choice,
    exec: &'a Executor,
}

impl Chooser<'_> {
    /// `above` is the basis above the node, and how many turns lie in one another there.
    fn below(&self, turned: &mut Turned, node: usize, (above, nest): (Basis, usize), come: &[u32]) -> usize {
        let Some(children) = turned.children(node) else { return 0 };
        if turned.points(node).len() < 3 * FEWEST_TRIANGLES || come.len() < FEWEST_RAYS || nest == NEST {
            return 0;
        }
        // All that is below lies along what is above.
        let costs = |turned: &Turned| {
            let of_chunk = |chunk: &[u32], half: usize| {
                let rays = chunk.iter().skip(half).step_by(2).map(|ray| &self.rays[*ray as usize]);
                turned.work(node, &above, rays)
            };
            let chunks: Vec<&[u32]> = come.chunks(CHUNK).collect();
            let parts = self.exec.map_range(chunks.len(), |i| [0, 1].map(|half| of_chunk(chunks[i], half)));
            [0, 1].map(|half| parts.iter().fold(Work::default(), |sum, part| sum + part[half]).cost())
        };
        let plain = costs(turned);
        let (mut best, mut least_cost) = (above, f64::INFINITY);
        for basis in candidates(turned.points(node), self.choice).into_iter().filter(|basis| *basis != above) {
            turned.turn(node, basis);
            let found = costs(turned);
            let pays = (0..2).all(|half| found[half] < plain[half] * (1.0 - GAIN));
            if pays && found[0] + found[1] < least_cost {
                (best, least_cost) = (basis, found[0] + found[1]);
            }
        }
        turned.turn(node, best);
        let parts = turned.divided(node, come, self.rays);
        let changed = usize::from(best != above);
        let below = children.into_iter().zip(parts);
        changed + below.map(|(child, part)| self.below(turned, child, (best, nest + changed), &part)).sum::<usize>()
    }
}

/// The axes, and what suits the points.
fn candidates(points: &[[f64; 3]], choice: &Choice) -> Vec<Basis> {
    let mut found = vec![Basis::AXES];
    let Some(extremes) = Extremes::of_points(points) else { return found };
    let outer = extremes.points();
    let roughly = |basis| OrientedBox::in_basis(basis, &outer);
    match choice {
        Choice::Free => {
            found.extend(least(ditetrahedron(&extremes), roughly).map(|b| b.basis));
            found.extend(least(hull_facets(&outer), roughly).map(|b| b.basis));
        }
        Choice::Among(bases) => found.extend(least(bases.iter().copied(), roughly).map(|b| b.basis)),
    }
    found
}
