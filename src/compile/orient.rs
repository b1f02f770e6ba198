//! The pass behind a finished tree that turns subtrees: where counted rays say that boxes along other axes pay.

use crate::cache::{CacheError, Image, TurnRecord, View};
use crate::exec::Executor;
use crate::layout::{BlasView, NEST, Node, TriangleRecord};
use crate::oriented::{Basis, Choice, OrientedBox, Segment, Turned, orient};
use crate::trace::probe::{Camera, ProbeRays, SETS};
use crate::trace::{Turns, closest_hit};

/// Raised when the pass turns other subtrees of an equal tree, and only then. Build keys have it.
const REVISION: u32 = 1;

/// What META and the build key say of a file that was built with the pass.
pub(crate) fn orient_option() -> (String, String) {
    ("orient".into(), REVISION.to_string())
}

/// Rays in a set, of those that choose and of those that judge.
const RAYS: usize = 1300;
/// Rays that nothing was chosen by must pay at least so much less in all: on the clock, a node of a turned subtree takes about three times as long as one along the axes,
/// which `verify` shows side by side.
const LEAST_SAVING: f64 = 0.7;
/// 2¹⁰⁰: beyond, coordinates along other axes come near the end of `f32`.
const LARGEST: f32 = f32::from_bits((127 + 100) << 23);

/// Bytes that [`orient_image`] sets aside at most: the boxes and corners that it tries bases on, and the records that it writes.
pub fn bytes_to_orient(image: &Image) -> u64 {
    /// A triangle and six cuts.
    const MOST_CORNERS: usize = 9;
    let corners = |t: &TriangleRecord| if t.flags & TriangleRecord::DUPLICATED == 0 { 3 } else { MOST_CORNERS };
    let corners: usize = image.triangles.iter().map(corners).sum();
    let of_points = size_of::<[f64; 3]>() * corners + size_of::<usize>() * (image.triangles.len() + 1);
    let of_node = size_of::<Basis>() + size_of::<OrientedBox>() + (NEST + 1) * size_of::<Node>() + size_of::<u64>();
    (of_points + of_node * image.nodes.len()) as u64
}

/// What turning did to a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Oriented {
    /// Subtrees that were turned.
    pub turns: usize,
    /// What a ray pays, in triangle tests, over what it pays along the axes: of rays that nothing was chosen by. 1 where nothing was turned.
    pub cost: f64,
}

impl std::fmt::Display for Oriented {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.turns {
            0 => f.write_str("no subtree is turned: along other axes boxes would not pay"),
            1 => write!(f, "1 subtree is turned: rays pay {:.2} of what they pay along the axes", self.cost),
            n => write!(f, "{n} subtrees are turned: rays pay {:.2} of what they pay along the axes", self.cost),
        }
    }
}

/// Turn subtrees of an image's one tree where it pays.
///
/// Rays of two cameras choose, from the root down: a subtree is turned where each half of those that come to it pays at least 5 % less below. Rays of two
/// others judge: all is left as it is where they save less than 70 % in the whole tree. Everything else in the image stays what it is.
///
/// # Errors
/// Where the image has instances: their trees are shared, and each place is seen by other rays. Where it has compact trees, which rays would
/// be traced in.
pub fn orient_image(image: &mut Image, exec: &Executor) -> Result<Oriented, CacheError> {
    let nothing = Oriented { turns: 0, cost: 1.0 };
    let refuse = |detail: &str| Err(CacheError::Unwritable { name: "the image".into(), detail: detail.into() });
    if !image.instances.is_empty() {
        return refuse("subtrees are turned in a file of one level, and this one has instances");
    }
    if image.compact.is_some() {
        return refuse("rays would be traced in its compact trees, so turned subtrees would never be entered");
    }
    image.turns = None;
    let view = image.view();
    let Some(tree) = view.blas(0).filter(|tree| tree.nodes.len() > 2) else { return Ok(nothing) };
    let bounds = tree.nodes[0].bounds();
    if bounds.min.iter().chain(&bounds.max).any(|c| c.abs() > LARGEST) {
        return Ok(nothing);
    }
    let [front, left, back, right] = Camera::around(&view);
    let [forming, judging] = [[front, back], [left, right]].map(|cameras| segments(&view, &tree, &cameras, exec));
    let mut turned = Turned::new(tree);
    let plain = turned.work(0, &Basis::AXES, judging.iter()).cost();
    if orient(&mut turned, &forming, &Choice::Free, exec) == 0 {
        return Ok(nothing);
    }
    let work = turned.work(0, &Basis::AXES, judging.iter());
    let cost = work.cost() / plain;
    // Written so that NaN is refused too.
    if !(cost <= 1.0 - LEAST_SAVING) || work.lost > 0 {
        return Ok(nothing);
    }
    let Some(turns) = Turns::new(&tree, rows(&tree, &turned), exec) else { return Ok(nothing) };
    let oriented = Oriented { turns: turns.rows.len(), cost };
    image.turns = Some(turns);
    Ok(oriented)
}

/// A row for each node whose children lie along other axes than itself.
fn rows(tree: &BlasView<'_>, turned: &Turned<'_>) -> Vec<TurnRecord> {
    // Behind the last record below each node.
    let mut ends = vec![0u32; tree.nodes.len()];
    let mut above = vec![Basis::AXES; tree.nodes.len()];
    let inner = || (0..tree.nodes.len()).filter(|i| *i != 1).filter_map(|i| Some((i, turned.children(i)?)));
    for (i, [a, b]) in inner().collect::<Vec<_>>().into_iter().rev() {
        ends[i] = ends[a].max(ends[b]).max(b as u32 + 1);
    }
    let mut found = Vec::new();
    for (i, [a, b]) in inner() {
        let basis = turned.basis(i);
        (above[a], above[b]) = (basis, basis);
        if basis != above[i] {
            let axes = basis.axes().map(|axis| axis.map(|c| c as f32));
            found.push(TurnRecord { axes, first: a as u32, end: ends[i], node_offset: 0, reserved: [0; 4] });
        }
    }
    found.sort_by_key(|row| row.first);
    found
}

/// All three sets of rays, up to what they hit.
pub fn segments(view: &View<'_>, tree: &BlasView<'_>, cameras: &[Camera], exec: &Executor) -> Vec<Segment> {
    let probe = ProbeRays::around(view, cameras, RAYS);
    let rays: Vec<_> = (0..SETS.len()).flat_map(|set| probe.rays(set)).collect();
    let bounds = tree.nodes[0].bounds();
    exec.map_range(rays.len(), |i| {
        let hit = closest_hit(view, rays[i]).ok().flatten();
        Segment::new(rays[i], hit.map(|hit| (hit.t, (hit.geom, hit.prim))), &bounds)
    })
}
