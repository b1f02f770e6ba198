//! A handful of nodes and a way to put them together anew.

/// Nodes below a treelet's inner ones, at most. With fewer of them less is gained; eight gain a little more and
/// take twice as long.
pub const MOST: usize = 7;
/// Sets that there are of so many nodes.
pub const SETS: usize = 1 << MOST;

/// A set of the nodes below a treelet's inner ones, a bit for each.
pub type Part = usize;

/// A treelet and another way to put it together.
pub struct Treelet {
    /// Its inner nodes, the root first.
    pub inner: Vec<u32>,
    /// What they hold, the bits of a [`Part`] in this order.
    pub front: Vec<u32>,
    /// By set: one of the two that it is divided into.
    pub halves: [u8; SETS],
    /// By set: the rays that meet the box around it.
    pub visits: [u32; SETS],
}

impl Treelet {
    /// The two parts that a set of several is divided into.
    pub fn parts(&self, set: Part) -> [Part; 2] {
        let half = usize::from(self.halves[set]);
        [half, set & !half]
    }
}
