//! [`RayWork`]: what each probe ray does, one by one.

use super::{CHUNK, ProbeRays};
use crate::cache::View;
use crate::exec::Executor;
use crate::trace::{Observer, try_any_hit, try_closest_hit};

/// What one ray did in a tree, on both levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayWork {
    /// Inner nodes entered, each of which tests two boxes.
    pub inner_nodes: u32,
    /// Triangle tests.
    pub triangles: u32,
    /// Leaves with triangles that it went into.
    pub leaves: u32,
    /// Whether the last thing tested was a triangle: those of one leaf come one after another, and something else comes before the next leaf.
    is_in_leaf: bool,
}

impl Observer for RayWork {
    fn inner_node(&mut self) {
        self.inner_nodes += 1;
        self.is_in_leaf = false;
    }

    fn triangle(&mut self) {
        self.triangles += 1;
        self.leaves += u32::from(!self.is_in_leaf);
        self.is_in_leaf = true;
    }

    fn root(&mut self, _met: bool) {
        self.is_in_leaf = false;
    }

    fn resume(&mut self, _node: u32, _near: f32, _dropped: bool) {
        self.is_in_leaf = false;
    }
}

impl ProbeRays {
    /// What each ray of a set does in a tree, in the order of the rays. A ray whose walk finds the tree malformed counts as far as it came.
    pub fn works(&self, set: usize, view: &View<'_>, exec: &Executor) -> Vec<RayWork> {
        self.works_while(set, view, exec, &|| true)
    }

    /// [`ProbeRays::works`] for as long as that goes on; some rays are left out then.
    pub(crate) fn works_while(
        &self,
        set: usize,
        view: &View<'_>,
        exec: &Executor,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Vec<RayWork> {
        let parts = exec.map_chunks(&self.sets[set], CHUNK, |_, chunk| {
            let one = |ray| {
                let mut work = RayWork::default();
                match set {
                    2 => drop(try_any_hit(view, ray, &mut work)),
                    _ => drop(try_closest_hit(view, ray, &mut work)),
                }
                work
            };
            if goes_on() { chunk.iter().map(one).collect::<Vec<RayWork>>() } else { Vec::new() }
        });
        parts.concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Preset};
    use crate::trace::probe::Camera;
    use crate::trace::probe::tests::cube;

    #[test]
    fn single_rays_add_up_to_the_cost_of_the_set() {
        let image = cube(&BuildOptions { max_leaf: 3, ..BuildOptions::preset(Preset::Draft) });
        let view = image.view();
        let rays = ProbeRays::new(&view, &Camera::automatic(&view), 400);
        let cost = rays.cost(&view, &Executor::sequential());
        for set in 0..3 {
            let works = rays.works(set, &view, &Executor::new(2).unwrap());
            let sum = |of: fn(&RayWork) -> u32| works.iter().map(of).map(f64::from).sum::<f64>() / works.len() as f64;
            assert_eq!([sum(|w| w.inner_nodes), sum(|w| w.triangles)], cost.sets[set]);
            // A leaf has one to three triangles, and any hit may leave one in the middle.
            assert!(works.iter().all(|w| w.leaves <= w.triangles && w.triangles <= 3 * w.leaves), "{works:?}");
        }
    }

    #[test]
    fn one_leaf_is_one_leaf() {
        let image =
            cube(&BuildOptions { max_leaf: 255, traversal_cost: 1000.0, ..BuildOptions::preset(Preset::Draft) });
        let rays = ProbeRays::new(&image.view(), &Camera::automatic(&image.view()), 100);
        let works = rays.works(0, &image.view(), &Executor::sequential());
        assert!(works.iter().all(|w| (w.leaves, w.triangles, w.inner_nodes) == (1, 12, 0)), "{works:?}");
    }
}
