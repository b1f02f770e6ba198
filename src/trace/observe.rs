/// Told what a traversal does; all its methods do nothing unless they are overridden, and then cost nothing.
pub trait Observer {
    /// An inner node was entered: the boxes of its two children are tested.
    fn inner_node(&mut self) {}
    /// A triangle was tested.
    fn triangle(&mut self) {}
    /// A ray was mapped into an instance.
    fn instance(&mut self) {}
}

pub struct NoObserver;

impl Observer for NoObserver {}

/// Sums over any number of rays: the noise-free measure of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    pub inner_nodes: u64,
    pub triangles: u64,
    pub instances: u64,
}

impl Observer for Counters {
    fn inner_node(&mut self) {
        self.inner_nodes += 1;
    }

    fn triangle(&mut self) {
        self.triangles += 1;
    }

    fn instance(&mut self) {
        self.instances += 1;
    }
}

impl std::ops::Add for Counters {
    type Output = Counters;

    fn add(self, other: Counters) -> Counters {
        Counters {
            inner_nodes: self.inner_nodes + other.inner_nodes,
            triangles: self.triangles + other.triangles,
            instances: self.instances + other.instances,
        }
    }
}
