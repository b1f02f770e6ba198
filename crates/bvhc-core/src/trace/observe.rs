/// Told what a traversal does; all its methods do nothing unless they are overridden, and then cost nothing.
///
/// The first three count. The others tell a log where the traversal is: nodes, slots and instances are numbers of records, those
/// of a tree counted from the tree's own start.
pub trait Observer {
    /// A mistake that traversal makes on purpose, so that tests can show that verification finds it. A constant, so that
    /// traversal without one holds no trace of it.
    #[cfg(feature = "testing")]
    const FAULT: Option<Fault> = None;

    /// An inner node was entered: the boxes of its two children are tested.
    fn inner_node(&mut self) {}
    /// A triangle was tested.
    fn triangle(&mut self) {}
    /// A ray was mapped into an instance.
    fn instance(&mut self) {}
    /// The ray was turned into the coordinates of a subtree: see [`TurnedView`](super::TurnedView).
    fn turn(&mut self) {}

    /// The root's box was tested.
    fn root(&mut self, _met: bool) {}
    /// The boxes of nodes `first` and `first + 1` were tested: where the ray enters them, and a bit for each that it meets.
    fn pair(&mut self, _first: u32, _near: [f32; 2], _met: u32) {}
    /// A node that was put off is taken up again, or dropped because it lies behind the best hit.
    fn resume(&mut self, _node: u32, _near: f32, _dropped: bool) {}
    /// The ray crosses the triangle of this slot at `t`; `accepted` if that lies in range and not behind the best hit.
    fn crossing(&mut self, _slot: usize, _t: f64, _accepted: bool) {}
    /// The walk goes into the tree of instance record `record`.
    fn enter(&mut self, _record: usize) {}
    /// The walk comes back from the tree that it [entered](Observer::enter).
    fn leave(&mut self) {}
}

/// A mistake that traversal makes on purpose where `Observer::FAULT` names it, which only the feature `testing` has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// Which plane of a slab is entered first is read off the sign bit, so that a direction of −0 enters by the wrong one.
    SignOfZero,
    /// Of two children the farther is entered first, and the nearer put off with the farther's distance.
    Order,
}

/// Whether traversal under this observer makes the mistake; never without the feature `testing`.
#[inline(always)]
pub(super) fn makes<O: Observer>(_: &O, mistake: Fault) -> bool {
    #[cfg(feature = "testing")]
    return O::FAULT == Some(mistake);
    #[cfg(not(feature = "testing"))]
    {
        _ = mistake;
        false
    }
}

/// Watches nothing, at no cost.
pub struct NoObserver;

impl Observer for NoObserver {}

/// Sums over any number of rays: the noise-free measure of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Inner nodes entered, each of which tests two boxes.
    pub inner_nodes: u64,
    /// Triangle tests.
    pub triangles: u64,
    /// Rays mapped into an instance.
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
