//! The shape of a tree, once for all poses of its topology: `first` and `count` of its nodes in five planes of a byte for each node, four for
//! `first` less what was expected, lowest byte first, and one for `count`.

use crate::geom::Point;
use crate::layout::{IndexedTriangleRecord, Node};
use crate::refit::refit;

/// `first` and `count` of a node.
pub type Link = [u32; 2];

/// Four of `first` and one of `count`.
pub const PLANES: usize = 5;

/// Bytes for so many nodes.
pub fn packed_len(nodes: u64) -> u64 {
    PLANES as u64 * nodes
}

/// What `first` of the next node is expected to be: of a leaf the end of the leaf before it, of an inner node that of the inner node before it.
#[derive(Default)]
struct Expected {
    leaf: u32,
    inner: u32,
}

impl Expected {
    fn of(&self, count: u32) -> u32 {
        if count > 0 { self.leaf } else { self.inner }
    }

    fn take(&mut self, [first, count]: Link) {
        if count > 0 {
            self.leaf = first.wrapping_add(count);
        } else {
            self.inner = first;
        }
    }
}

/// The bytes of a tree's shape. `None` where a leaf has more references than a byte holds.
pub fn encode(nodes: &[Node]) -> Option<Vec<u8>> {
    let mut out = vec![0; packed_len(nodes.len() as u64) as usize];
    let mut expected = Expected::default();
    for (i, node) in nodes.iter().enumerate() {
        let bytes = node.first.wrapping_sub(expected.of(node.count)).to_le_bytes();
        for (plane, byte) in bytes.into_iter().chain([u8::try_from(node.count).ok()?]).enumerate() {
            out[plane * nodes.len() + i] = byte;
        }
        expected.take([node.first, node.count]);
    }
    Some(out)
}

/// The shape of a tree of `count` nodes.
///
/// # Errors
/// Where there are not the bytes of so many.
pub fn decode(packed: &[u8], count: usize) -> Result<Vec<Link>, String> {
    if packed.len() as u64 != packed_len(count as u64) {
        return Err(format!("the shape of {count} nodes has {} bytes", packed.len()));
    }
    let mut expected = Expected::default();
    let link = |i: usize| {
        let byte = |plane: usize| packed[plane * count + i]; // five planes of `count` bytes, as was asked above
        let references = u32::from(byte(4));
        let more = u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)]);
        let link = [expected.of(references).wrapping_add(more), references];
        expected.take(link);
        link
    };
    Ok((0..count).map(link).collect())
}

/// The nodes of a pose: each leaf has the smallest box around its triangles, each inner node that around its children. Record 1 is unused, and zero but for
/// its link.
///
/// # Errors
/// Where a link leads to nothing, or a corner is no vertex.
pub fn fit(
    links: &[Link],
    triangles: &[IndexedTriangleRecord],
    vertices: &[Point],
    out: &mut [Node],
) -> Result<(), String> {
    if out.len() != links.len() {
        return Err(format!("there is room for {} of {} nodes", out.len(), links.len()));
    }
    for (node, [first, count]) in out.iter_mut().zip(links) {
        *node = Node { min: [0.0; 3], first: *first, max: [0.0; 3], count: *count };
    }
    refit(out, triangles, vertices).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;
    use bytemuck::Zeroable;

    fn tree() -> (Vec<Node>, Vec<IndexedTriangleRecord>, Vec<Point>) {
        let vertices: Vec<Point> = (0..9).map(|i| [i as f32, (i * i % 7) as f32, -(i as f32)]).collect();
        let corners = |i: u32| IndexedTriangleRecord {
            corners: [3 * i, 3 * i + 1, 3 * i + 2],
            ..IndexedTriangleRecord::zeroed()
        };
        let triangles: Vec<_> = (0..3).map(corners).collect();
        let leaf = |first: u32, count: u32| Node { first, count, ..Node::zeroed() };
        let nodes = vec![leaf(2, 0), leaf(0, 0), leaf(4, 0), leaf(2, 1), leaf(0, 1), leaf(1, 1)];
        (nodes, triangles, vertices)
    }

    #[test]
    fn shapes_come_back_and_boxes_follow() {
        let (nodes, triangles, vertices) = tree();
        let links = decode(&encode(&nodes).unwrap(), nodes.len()).unwrap();
        assert_eq!(links, nodes.iter().map(|n| [n.first, n.count]).collect::<Vec<_>>());
        let mut out = vec![Node::zeroed(); nodes.len()];
        fit(&links, &triangles, &vertices, &mut out).unwrap();
        assert_eq!(out[0].bounds(), Aabb::from_points(&vertices));
        assert_eq!(out[2].bounds(), Aabb::from_points(&vertices[..6]));
        assert_eq!(out[3].bounds(), Aabb::from_points(&vertices[6..]));
        assert_eq!(out[1], Node::zeroed());
    }

    #[test]
    fn links_that_lead_nowhere_are_refused() {
        let (nodes, triangles, vertices) = tree();
        let links: Vec<Link> = nodes.iter().map(|n| [n.first, n.count]).collect();
        let mut out = vec![Node::zeroed(); nodes.len()];
        for (i, link) in [(0, [0, 0]), (0, [5, 0]), (2, [2, 0]), (0, [u32::MAX, 0]), (3, [3, 1]), (4, [u32::MAX, 255])]
        {
            let mut broken = links.clone();
            broken[i] = link;
            assert!(fit(&broken, &triangles, &vertices, &mut out).is_err(), "{i} {link:?}");
        }
        assert!(fit(&links, &triangles, &vertices[..8], &mut out).is_err());
        assert!(fit(&links, &triangles, &vertices, &mut out[..5]).is_err());
        assert!(decode(&[0; 9], 2).is_err() && encode(&[Node { count: 256, ..Node::zeroed() }]).is_none());
    }
}
