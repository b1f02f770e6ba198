//! The records of a file in few bytes, and every bit of them: what the page's `data.js` unpacks.
//!
//! Most of a file's records follow from the rest. The order of nodes is canonical, so `count` alone tells where children and references
//! begin. Most planes of boxes are those of the triangles or boxes below, so only the others are stored. Corners that stand in one place are
//! one vertex. What is left is differences from the value before, as planes of bytes, since bytes of one weight are alike.

use crate::cache::{InstanceRecord, View};
use crate::tree::Node;
use flate2::{Compression, write::ZlibEncoder};
use serde::Serialize;
use std::collections::HashMap;
use std::io::Write;

/// Why a scene cannot stand in a page.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PackError {
    /// A record names another that is not there, or the nodes do not stand in the order that SPEC.md, section 5.1, asks for.
    #[error("The records of {0} are not those of a checked file.")]
    Malformed(&'static str),
    /// Nodes, triangles and instances take more bytes than a browser handles smoothly.
    #[error("The scene has {bytes} bytes of nodes, triangles and instances, and a page takes at most {most}.")]
    TooLarge {
        /// Of nodes, triangles and instances.
        bytes: u64,
        /// [`MOST_BYTES`].
        most: u64,
    },
}

/// The most bytes of nodes, triangles and instances that a page takes.
pub const MOST_BYTES: u64 = 100 << 20;

/// How many records of each kind the data holds: what a reader needs to take the data apart.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Records of `NODE`.
    pub nodes: usize,
    /// Records of `TNOD`.
    pub top_nodes: usize,
    /// Records of `TRIS`.
    pub triangles: usize,
    /// Places in which the corners of each tree stand, summed over the trees.
    pub vertices: usize,
    /// Planes of boxes that do not follow from what is below.
    pub planes: usize,
    /// Records of `BLAS`.
    pub trees: usize,
    /// Records of `INST`.
    pub instances: usize,
    /// Records of `GEOM`.
    pub parts: usize,
}

/// A scene as compressed bytes (zlib).
#[derive(Clone, Debug)]
pub struct Packed {
    /// What the data holds.
    pub counts: Counts,
    /// Streams of [`pack`], one behind the other, compressed.
    pub data: Vec<u8>,
}

/// Bytes of the records that [`MOST_BYTES`] is about.
pub fn bytes_of(view: &View<'_>) -> u64 {
    let trees = size_of_val(view.nodes) + size_of_val(view.triangles);
    (trees + size_of_val(view.tlas_nodes) + size_of_val(view.instances)) as u64
}

/// Pack the records of a scene whose nodes were checked.
///
/// # Errors
/// Records that contradict each other, and scenes of more than [`MOST_BYTES`].
pub fn pack(view: &View<'_>) -> Result<Packed, PackError> {
    let bytes = bytes_of(view);
    if bytes > MOST_BYTES {
        return Err(PackError::TooLarge { bytes, most: MOST_BYTES });
    }
    let mut counts = Counts {
        nodes: view.nodes.len(),
        top_nodes: view.tlas_nodes.len(),
        triangles: view.triangles.len(),
        trees: view.blases.len(),
        instances: view.instances.len(),
        parts: view.geoms.len(),
        ..Counts::default()
    };
    let mut out = Streams::default();

    out.words(view.blases.iter().map(|b| b.node_count));
    out.words(view.blases.iter().map(|b| b.ref_count));
    out.words(view.blases.iter().map(|b| b.prim_count));
    out.words(view.blases.iter().map(|b| b.sah.to_bits()));
    out.bytes(leaf_counts(view.nodes)?);
    out.bytes(leaf_counts(view.tlas_nodes)?);

    let (vertices, corners) = vertices(view)?;
    counts.vertices = vertices.len();
    for axis in 0..3 {
        out.words(differences(vertices.iter().map(|v| ordered(v[axis]))));
    }
    out.words(corners.into_iter());
    out.words(differences(view.triangles.iter().map(|t| t.prim)));
    out.words(differences(view.triangles.iter().map(|t| t.geom)));
    out.bytes(view.triangles.iter().map(|t| t.flags as u8).collect());

    let (masks, planes) = boxes(view)?;
    counts.planes = planes.len();
    out.bytes(masks);
    out.words(planes.into_iter());

    for word in 0..24 {
        out.words(view.instances.iter().map(|i| matrix_word(i, word).to_bits()));
    }
    out.words(view.instances.iter().map(|i| i.blas));
    out.words(view.instances.iter().map(|i| i.id));
    out.words(view.instances.iter().map(|i| i.node));
    out.words(view.geoms.iter().map(|g| g.source_mesh));
    out.words(view.geoms.iter().map(|g| g.source_part));
    out.words(view.geoms.iter().map(|g| g.first_prim));
    out.words(view.geoms.iter().map(|g| g.kept_count));
    Ok(Packed { counts, data: out.compressed() })
}

/// Streams that stand one behind the other.
#[derive(Default)]
struct Streams(Vec<u8>);

impl Streams {
    fn bytes(&mut self, bytes: Vec<u8>) {
        self.0.extend(bytes);
    }

    /// Numbers as four planes: the lowest byte of each, then the next.
    fn words(&mut self, words: impl Iterator<Item = u32> + Clone) {
        for plane in 0..4 {
            self.0.extend(words.clone().map(|w| w.to_le_bytes()[plane]));
        }
    }

    fn compressed(&self) -> Vec<u8> {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        // Writing into memory does not fail.
        encoder.write_all(&self.0).and_then(|()| encoder.finish()).unwrap_or_default()
    }
}

fn matrix_word(instance: &InstanceRecord, word: usize) -> f32 {
    if word < 12 { instance.object_to_world[word] } else { instance.world_to_object[word - 12] }
}

/// The place of a number in the order of all, so that near numbers have near places. 0.0 has 0.
fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 0 { bits } else { bits ^ 0x7FFF_FFFF }
}

/// 0, −1, 1, −2, … as 0, 1, 2, 3, …
fn folded(difference: u32) -> u32 {
    (difference << 1) ^ ((difference as i32 >> 31) as u32)
}

/// Each number less the one before it.
fn differences(words: impl Iterator<Item = u32> + Clone) -> impl Iterator<Item = u32> + Clone {
    words.scan(0u32, |before, word| {
        let difference = word.wrapping_sub(*before);
        *before = word;
        Some(folded(difference))
    })
}

fn leaf_counts(nodes: &[Node]) -> Result<Vec<u8>, PackError> {
    nodes.iter().map(|n| u8::try_from(n.count).map_err(|_| PackError::Malformed("NODE or TNOD"))).collect()
}

/// The places of corners, tree after tree in the order of first use, and for each corner how far back its vertex is: 0 for a new one.
fn vertices(view: &View<'_>) -> Result<(Vec<[f32; 3]>, Vec<u32>), PackError> {
    let (mut vertices, mut corners) = (Vec::new(), Vec::with_capacity(3 * view.triangles.len()));
    for tree in 0..view.blases.len() {
        let tree = view.blas(tree).ok_or(PackError::Malformed("BLAS"))?;
        // Asked by key alone, so its order never shows.
        let mut known: HashMap<[u32; 3], usize> = HashMap::with_capacity(tree.triangles.len());
        for corner in tree.triangles.iter().flat_map(|t| t.corners()) {
            let next = vertices.len();
            let at = *known.entry(corner.map(f32::to_bits)).or_insert(next);
            if at == next {
                vertices.push(corner);
            }
            corners.push((next - at) as u32);
        }
    }
    if corners.len() != 3 * view.triangles.len() {
        return Err(PackError::Malformed("BLAS"));
    }
    Ok((vertices, corners))
}

/// For each node which of its six planes do not follow from what is below, and those planes: differences from what would follow.
fn boxes(view: &View<'_>) -> Result<(Vec<u8>, Vec<u32>), PackError> {
    let (mut masks, mut planes) = (Vec::new(), Vec::new());
    for tree in 0..view.blases.len() {
        let tree = view.blas(tree).ok_or(PackError::Malformed("BLAS"))?;
        tree_boxes(tree.nodes, &mut masks, &mut planes, |first, count| {
            let held = tree.triangles.get(first..first.checked_add(count)?)?;
            Some(held.iter().flat_map(|t| t.corners()).fold(NOTHING, |held, p| around(held, [p, p])))
        })?;
    }
    // What an instance's box is moved by is summed in f64: those boxes are stored.
    tree_boxes(view.tlas_nodes, &mut masks, &mut planes, |_, _| Some([[0.0; 3]; 2]))?;
    Ok((masks, planes))
}

type Planes = [[f32; 3]; 2];
const NOTHING: Planes = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];

/// The smallest box around two; of equal numbers the first is kept, as `data.js` does.
fn around(a: Planes, b: Planes) -> Planes {
    let pick = |end: usize, axis: usize| {
        let (x, y) = (a[end][axis], b[end][axis]);
        let other = if end == 0 { y < x } else { y > x };
        if other { y } else { x }
    };
    [0, 1].map(|end| [0, 1, 2].map(|axis| pick(end, axis)))
}

fn tree_boxes(
    nodes: &[Node],
    masks: &mut Vec<u8>,
    planes: &mut Vec<u32>,
    leaf: impl Fn(usize, usize) -> Option<Planes>,
) -> Result<(), PackError> {
    let bad = PackError::Malformed("NODE or TNOD");
    if !is_canonical(nodes) {
        return Err(bad);
    }
    for (number, node) in nodes.iter().enumerate() {
        let expected = match (number, node.count) {
            (1, _) => [[0.0; 3]; 2],
            (_, 0) => {
                let [a, b] = [0, 1].map(|side| &nodes[node.first as usize + side]);
                around([a.min, a.max], [b.min, b.max])
            }
            (_, count) => leaf(node.first as usize, count as usize).ok_or(bad.clone())?,
        };
        let mut mask = 0;
        for (bit, (is, would)) in [node.min, node.max].as_flattened().iter().zip(expected.as_flattened()).enumerate() {
            if is.to_bits() != would.to_bits() {
                mask |= 1 << bit;
                planes.push(folded(ordered(*is).wrapping_sub(ordered(*would))));
            }
        }
        masks.push(mask);
    }
    Ok(())
}

/// Whether children and references begin where the order of SPEC.md, section 5.1, has them, which is where `data.js` finds them.
fn is_canonical(nodes: &[Node]) -> bool {
    if nodes.is_empty() {
        return true;
    }
    let (mut pending, mut pair, mut reference) = (vec![0], 2, 0);
    while let Some(number) = pending.pop() {
        let Some(node) = nodes.get(number) else { return false };
        if node.count > 0 {
            if node.first != reference {
                return false;
            }
            reference += node.count;
        } else {
            if node.first as usize != pair || pair + 2 > nodes.len() {
                return false;
            }
            pending.extend([pair + 1, pair]);
            pair += 2;
        }
    }
    pair == nodes.len()
}
