/// One wide tree among all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WideRow {
    /// First of its nodes, which is the root.
    pub node_offset: u64,
    /// How many nodes it has; 0 for a tree without triangles.
    pub node_count: u32,
    /// The most children that wait to be entered at once, those of the node that is being entered included.
    pub waiting: u32,
}
