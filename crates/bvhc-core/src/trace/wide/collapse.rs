/// What a wide tree is expected to cost, by which its collapse decides.
///
/// The cost of a tree is `node_cost`·A for each node, and `group_cost`·A for each group of four triangles of a leaf, where A is the area of the box:
/// four triangles are tested at once, so three cost as much as one and what is left of a group is filled where that is cheaper.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Collapse {
    /// Triangles of a leaf that several leaves of the binary tree become, at most; a number above 255 counts as 255. A leaf of
    /// the binary tree stays, however large it is.
    pub max_leaf: u32,
    /// Cost of entering a node, with the tests of all its boxes.
    pub node_cost: f64,
    /// Cost of a group of up to four triangles.
    pub group_cost: f64,
}

impl Default for Collapse {
    fn default() -> Collapse {
        Collapse { max_leaf: 8, node_cost: 1.0, group_cost: 1.0 }
    }
}

impl Collapse {
    /// Cost of testing so many triangles in a box of area 1.
    pub fn leaf_cost(&self, count: u32) -> f64 {
        self.group_cost * f64::from(count.div_ceil(4))
    }
}
