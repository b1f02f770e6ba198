//! A tree is fitted to triangles that have moved: its boxes are computed anew, bottom-up, and its topology stays.
//!
//! ```text
//! nodes, from the last to the first, in blocks:   leaves of a block ─▶ their inner nodes ─▶ the block before it
//! ```
//!
//! Children stand behind their parents, so one pass suffices. A processor would guess wrong at every other node whether it is a leaf, and of how many
//! triangles: so a block is sorted by that first, without a branch, and what is alike is done in one loop.
//!
//! The pairs below a node are consecutive in a file, so subtrees are slices that threads can share out. Whoever computes a box, it is the same to the bit.

mod turned;

pub use turned::{Held, turned_nodes};

use crate::exec::Executor;
use crate::geom::Point;
use crate::layout::{IndexedTriangleRecord, Node};
use crate::simd::Register;

/// Nodes that are sorted at a time.
const BLOCK: usize = 256;
/// Largest subtree that is one task, in records. A constant, though nothing would depend on the number of threads.
const TASK: usize = 1 << 13;

/// What makes records unfit to be refitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// An inner node names children that do not stand behind it, or beyond the records.
    Child {
        /// The node.
        node: usize,
        /// First child that it names.
        first: u32,
        /// Records of the tree.
        nodes: usize,
    },
    /// A leaf names triangles beyond those of the tree.
    Leaf {
        /// The node.
        node: usize,
        /// First triangle that it names.
        first: u32,
        /// How many it names.
        count: u32,
        /// Triangles of the tree.
        triangles: usize,
    },
    /// A triangle names a vertex that is not there.
    Vertex {
        /// The triangle's place in the leaf order.
        triangle: usize,
        /// The vertex.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
}

impl std::fmt::Display for RefitError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("cannot refit: ")?;
        match *self {
            RefitError::Child { node, first, nodes } => write!(
                f,
                "node {node} names children {first} and the next, which must stand behind it among {nodes} records"
            ),
            RefitError::Leaf { node, first, count, triangles } => {
                write!(f, "leaf {node} names {count} triangles from {first} on, and there are {triangles}")
            }
            RefitError::Vertex { triangle, vertex, vertices } => {
                write!(f, "triangle {triangle} of the leaf order names vertex {vertex}, and there are {vertices}")
            }
        }
    }
}

impl std::error::Error for RefitError {}

/// Fit the boxes of a tree to where its vertices stand, and leave everything else of it as it is.
///
/// `triangles` are those of the tree's leaf order, whose corners are numbers of `vertices`: the records of a topology in `TRIX`, with the positions of any
/// pose, or with positions of your own. Each leaf gets the smallest box around its triangles, and each inner node the union of its children's. Positions
/// that are no number may or may not count. A tree that was built over these positions without spatial splits is not changed by one bit.
///
/// # Errors
/// Where nodes or triangles lead nowhere; which boxes are new then, nobody knows. Records that were opened with their topology checked are sound.
///
/// ```
/// use bvhc_core::layout::{IndexedTriangleRecord, Node};
/// use bvhc_core::{geom::Aabb, refit};
///
/// let mut nodes = [Node::leaf(Aabb::EMPTY, 0, 1), Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 }];
/// let triangles = [IndexedTriangleRecord { corners: [0, 1, 2], prim: 0, geom: 0, flags: 0 }];
/// refit::refit(&mut nodes, &triangles, &[[0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, -3.0]])?;
/// assert_eq!((nodes[0].min, nodes[0].max), ([0.0, 0.0, -3.0], [2.0, 1.0, 0.0]));
/// # Ok::<(), refit::RefitError>(())
/// ```
pub fn refit(nodes: &mut [Node], triangles: &[IndexedTriangleRecord], vertices: &[Point]) -> Result<(), RefitError> {
    refit_on(nodes, triangles, vertices, &Executor::sequential())
}

/// [`refit`] with the threads of `exec`.
///
/// # Errors
/// As [`refit`].
pub fn refit_on(
    nodes: &mut [Node],
    triangles: &[IndexedTriangleRecord],
    vertices: &[Point],
    exec: &Executor,
) -> Result<(), RefitError> {
    let flat: &[f32] = vertices.as_flattened();
    let vertex = |number: u32| {
        let at = (number as usize).checked_mul(3)?;
        // Four floats are one load; the fourth lane is nobody's. Behind the last vertex there is none.
        match flat.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
            Some(four) => Some(Register::of(*four)),
            None => flat.get(at..).and_then(|rest| rest.first_chunk()).map(last),
        }
    };
    let triangle = |slot: usize| {
        let [a, b, c] = triangles.get(slot)?.corners;
        Some(Span::of([vertex(a)?, vertex(b)?, vertex(c)?]))
    };
    match fit(nodes, &triangle, exec) {
        Some(()) => Ok(()),
        None => Err(fault(nodes, triangles, vertices.len())),
    }
}

/// The same by the corners of what stands in each place of the leaf order, for trees of other records.
///
/// # Errors
/// [`RefitError::Child`]; or [`RefitError::Leaf`] where a leaf names more than `triangles`.
pub fn refit_by(
    nodes: &mut [Node],
    triangles: usize,
    corners: impl Fn(usize) -> [Point; 3] + Sync,
    exec: &Executor,
) -> Result<(), RefitError> {
    let triangle = |slot: usize| (slot < triangles).then(|| Span::of(corners(slot).map(|p| last(&p))));
    match fit(nodes, &triangle, exec) {
        Some(()) => Ok(()),
        None => Err(broken(nodes, triangles).unwrap_or(RefitError::Leaf { node: 0, first: 0, count: 0, triangles })),
    }
}

fn last(p: &Point) -> Register {
    Register::of([p[0], p[1], p[2], 0.0])
}

/// A box in two registers, whose fourth lanes are nobody's.
#[derive(Clone, Copy)]
struct Span {
    min: Register,
    max: Register,
}

impl Span {
    #[inline(always)]
    fn of([a, b, c]: [Register; 3]) -> Span {
        Span { min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    #[inline(always)]
    fn of_node(node: &Node) -> Span {
        let [min, max]: &[[f32; 4]; 2] = bytemuck::cast_ref(node);
        Span { min: Register::of(*min), max: Register::of(*max) }
    }

    #[inline(always)]
    fn union(self, other: Span) -> Span {
        Span { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Give a node this box. What else it holds is in the fourth lanes, and goes with them: a box that is written by parts cannot be read again at once.
    #[inline(always)]
    fn write(self, node: &mut Node) {
        let before = Span::of_node(node);
        let fourth = Register::of([0.0, 0.0, 0.0, f32::from_bits(u32::MAX)]);
        let keep = |new: Register, old: Register| new ^ ((new ^ old) & fourth);
        let [min, max]: &mut [[f32; 4]; 2] = bytemuck::cast_mut(node);
        *min = keep(self.min, before.min).array();
        *max = keep(self.max, before.max).array();
    }
}

/// Of all nodes. `None` where something leads nowhere.
fn fit(nodes: &mut [Node], triangle: &(impl Fn(usize) -> Option<Span> + Sync), exec: &Executor) -> Option<()> {
    if exec.is_sequential() || nodes.len() < 4 * TASK {
        return fit_part(nodes, 0, triangle);
    }
    let Some(cut) = cut(nodes) else { return fit_part(nodes, 0, triangle) };
    let mut parts = Vec::with_capacity(cut.parts.len());
    let (mut rest, mut at) = (&mut *nodes, 0);
    for (start, end) in cut.parts {
        let (part, behind) = rest.split_at_mut(start - at).1.split_at_mut(end - start);
        parts.push((start, part));
        (rest, at) = (behind, end);
    }
    let done = exec.map(parts, |_, (start, part)| fit_part(part, start, triangle));
    if done.iter().any(Option::is_none) {
        // Something leads nowhere, or out of its part.
        return fit_part(nodes, 0, triangle);
    }
    // What is above the parts, from the last pair to the root.
    for pair in cut.above.into_iter().rev() {
        for node in [pair + 1, pair] {
            if node != 1 {
                fit_node(nodes, 0, node, triangle)?;
            }
        }
    }
    Some(())
}

/// Subtrees whose pairs are consecutive, ascending; and the pairs above them, ascending too.
#[derive(Default)]
struct Cut {
    parts: Vec<(usize, usize)>,
    above: Vec<usize>,
}

/// `None` where the pairs are in another order than a file has them in.
fn cut(nodes: &[Node]) -> Option<Cut> {
    let mut cut = Cut::default();
    // What is left to be cut, the first on top: pairs from one record to another.
    let mut stack = vec![(0, nodes.len())];
    while let Some((start, end)) = stack.pop() {
        if end.checked_sub(start)? <= TASK {
            cut.parts.push((start, end));
            continue;
        }
        cut.above.push(start);
        let pair = nodes.get(start..start + 2)?;
        let below = |node: &Node| (!node.is_leaf()).then_some(node.first as usize);
        // Record 1 is none.
        let (first, second) = if start == 0 { (below(&pair[0]), None) } else { (below(&pair[0]), below(&pair[1])) };
        let is_within = second.is_none_or(|second| (start + 2..end).contains(&second));
        if first.or(second)? != start + 2 || !is_within {
            return None;
        }
        stack.extend(second.map(|second| (second, end)));
        stack.extend(first.map(|first| (first, second.unwrap_or(end))));
    }
    Some(cut)
}

/// Of consecutive records from number `start` of the tree on, which name no children beyond them.
fn fit_part(nodes: &mut [Node], start: usize, triangle: &impl Fn(usize) -> Option<Span>) -> Option<()> {
    let mut kinds = [[0u32; BLOCK]; 3];
    let mut end = nodes.len();
    while end > 0 {
        let from = end.saturating_sub(BLOCK);
        let [mut inner, mut small, mut large] = [0usize; 3];
        // Each number is written to every list and counted in one.
        for i in (from..end).rev() {
            let count = nodes[i].count;
            kinds[0][inner % BLOCK] = i as u32;
            inner += usize::from(count == 0);
            kinds[1][small % BLOCK] = i as u32;
            small += usize::from(count.wrapping_sub(1) < 2);
            kinds[2][large % BLOCK] = i as u32;
            large += usize::from(count > 2);
        }
        // Leaves of one or two triangles, then of three or four, and few of more. A triangle that is taken twice changes nothing.
        for &i in &kinds[1][..small] {
            let node = &mut nodes[i as usize];
            let (first, count) = (node.first as usize, node.count as usize);
            let [a, b] = [triangle(first)?, triangle(first.saturating_add(count - 1))?];
            a.union(b).write(node);
        }
        for &i in &kinds[2][..large] {
            let node = &mut nodes[i as usize];
            let (first, count) = (node.first as usize, node.count as usize);
            let at = |i: usize| triangle(first.saturating_add(i));
            let [a, b, c, d] = [at(0)?, at(1)?, at(2)?, at(count - 1)?];
            let mut span = a.union(b).union(c.union(d));
            for i in 3..count - 1 {
                span = span.union(at(i)?);
            }
            span.write(node);
        }
        for &i in &kinds[0][..inner] {
            if start + i as usize != 1 {
                fit_node(nodes, start, i as usize, triangle)?;
            }
        }
        end = from;
    }
    Some(())
}

/// Of one node, `i` counted from `start`.
#[inline(always)]
fn fit_node(nodes: &mut [Node], start: usize, i: usize, triangle: &impl Fn(usize) -> Option<Span>) -> Option<()> {
    let Node { first, count, .. } = nodes[i];
    let first = first as usize;
    let span = if count > 0 {
        let mut span = triangle(first)?;
        for i in 1..count as usize {
            span = span.union(triangle(first.saturating_add(i))?);
        }
        span
    } else {
        let first = first.checked_sub(start).filter(|first| *first > i)?;
        let [a, b] = nodes.get(first..)?.first_chunk::<2>()?;
        Span::of_node(a).union(Span::of_node(b))
    };
    span.write(&mut nodes[i]);
    Some(())
}

/// What of the nodes leads nowhere.
fn broken(nodes: &[Node], triangles: usize) -> Option<RefitError> {
    let all = nodes.len();
    nodes.iter().enumerate().filter(|(i, _)| *i != 1).find_map(|(node, &Node { first, count, .. })| {
        let from = first as usize;
        if count > 0 {
            let fits = from.checked_add(count as usize).is_some_and(|end| end <= triangles);
            (!fits).then_some(RefitError::Leaf { node, first, count, triangles })
        } else {
            let fits = from > node && from.checked_add(2).is_some_and(|end| end <= all);
            (!fits).then_some(RefitError::Child { node, first, nodes: all })
        }
    })
}

/// What leads nowhere, once it is known that something does.
fn fault(nodes: &[Node], triangles: &[IndexedTriangleRecord], vertices: usize) -> RefitError {
    let lost = |(triangle, record): (usize, &IndexedTriangleRecord)| {
        let vertex = *record.corners.iter().find(|corner| **corner as usize >= vertices)?;
        Some(RefitError::Vertex { triangle, vertex, vertices })
    };
    let all = triangles.len();
    let found = broken(nodes, all).or_else(|| triangles.iter().enumerate().find_map(lost));
    found.unwrap_or(RefitError::Leaf { node: 0, first: 0, count: 0, triangles: all })
}

#[cfg(test)]
mod tests;
