//! Subtrees whose boxes lie along axes of their own.

/// Turned subtrees lie in one another at most so deep: a traversal keeps the ray in the coordinates of each.
pub const NEST: usize = 3;

/// `OROW`: all that is below one inner node, in boxes along three axes of its own, 64 bytes.
///
/// The pairs below a node are consecutive in `NODE`, and so they are in `ONOD`: record `first + i` of the tree has its turned twin in record
/// `node_offset + i`. A turned subtree within another shares the other's records.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnRecord {
    /// The axes x, y and z of the boxes, each of length 1 and at right angles to the others, to rounding. A point's coordinates are its products with them.
    pub axes: [[f32; 3]; 3],
    /// The first child of the node that is turned, counted from the tree's own start; even.
    pub first: u32,
    /// Behind the last record below the node.
    pub end: u32,
    /// The record of `ONOD` that is the twin of `first`.
    pub node_offset: u32,
    /// All zero.
    pub reserved: [u32; 4],
}

const _: () = assert!(size_of::<TurnRecord>() == 64);

crate::pod::plain! {
    TurnRecord = [[[f32; 3]; 3], [u32; 7]];
}

impl TurnRecord {
    /// Whether another subtree lies within this one.
    pub fn holds(&self, other: &TurnRecord) -> bool {
        self.first < other.first && other.end <= self.end
    }
}

/// A bit for each pair of `nodes` records that a turned subtree begins with: the walk asks it at every node. Rows that lead out of the records
/// have none.
pub fn marks_of(rows: &[TurnRecord], nodes: usize) -> Vec<u64> {
    let mut marks = vec![0u64; if rows.is_empty() { 0 } else { nodes.div_ceil(128) }];
    for row in rows {
        let pair = row.first / 2;
        if let Some(word) = marks.get_mut(pair as usize / 64) {
            *word |= 1 << (pair % 64);
        }
    }
    marks
}
