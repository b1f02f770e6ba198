//! [`RayReport`]: what probe rays do in the trees of a file.

use crate::cache::View;
use crate::exec::Executor;
use crate::trace::probe::{Camera, ProbeRays, RayWork, SETS};
use crate::tree::quality::{REPORT_INTERSECTION_COST, REPORT_TRAVERSAL_COST};
use serde::Serialize;

/// What a ray does on average, in three sets of rays from four cameras around the scene: what the cameras see, one diffuse bounce off it, and
/// ambient occlusion from there. The same rays for every tree of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RayReport {
    /// 1.2 · visits + tests a ray, the mean of the sets that have rays.
    pub cost: f64,
    /// One row a set; none for sets without rays, where the cameras see nothing.
    pub sets: Vec<SetReport>,
}

/// One set of rays.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SetReport {
    /// `primary`, `diffuse` or `occlusion`.
    pub name: &'static str,
    /// How many rays.
    pub rays: u64,
    /// Inner nodes that a ray enters: E\[N_i\], on both levels.
    pub visits: f64,
    /// Triangles that a ray is tested with: E\[N_t\].
    pub tests: f64,
    /// Leaves that a ray goes into: E\[N_l\].
    pub leaves: f64,
    /// Leaf-count variability, √(E\[N_l²\] − E\[N_l\]²), the standard deviation over the rays of leaves gone into: how differently rays side by side
    /// are kept busy (T. Aila, T. Karras and S. Laine, "On Quality Metrics of Bounding Volume Hierarchies", 2013, section 4).
    pub leaf_variability: f64,
    /// 1.2 · visits + tests.
    pub cost: f64,
}

impl RayReport {
    /// Trace about `count` rays a set (the next lower number that four cameras with square films have).
    pub fn of_view(view: &View<'_>, count: usize, exec: &Executor) -> RayReport {
        let rays = ProbeRays::around(view, &Camera::around(view), count);
        let set = |(number, name)| SetReport::of(name, &rays.works(number, view, exec));
        let sets: Vec<SetReport> = SETS.into_iter().enumerate().filter_map(set).collect();
        let cost = sets.iter().map(|set| set.cost).sum::<f64>() / sets.len().max(1) as f64;
        RayReport { cost, sets }
    }

    /// The mean over the sets, each counted alike; 0 without sets.
    pub fn mean(&self, of: impl Fn(&SetReport) -> f64) -> f64 {
        self.sets.iter().map(of).sum::<f64>() / self.sets.len().max(1) as f64
    }
}

impl SetReport {
    fn of(name: &'static str, works: &[RayWork]) -> Option<SetReport> {
        let mean = |of: &dyn Fn(&RayWork) -> f64| works.iter().map(of).sum::<f64>() / works.len() as f64;
        let (visits, tests) = (mean(&|w| f64::from(w.inner_nodes)), mean(&|w| f64::from(w.triangles)));
        let leaves = mean(&|w| f64::from(w.leaves));
        // About the mean, not as the difference of two large numbers.
        let variance = mean(&|w| (f64::from(w.leaves) - leaves).powi(2));
        let cost = REPORT_TRAVERSAL_COST * visits + REPORT_INTERSECTION_COST * tests;
        let rays = works.len() as u64;
        (rays > 0).then(|| SetReport { name, rays, visits, tests, leaves, leaf_variability: variance.sqrt(), cost })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Method, NoProgress, Preset};
    use crate::cache::Image;
    use crate::compile::compile;
    use crate::geom::Ray;
    use crate::scene::{ReadOptions, read};
    use crate::trace::{Observer, try_closest_hit};

    fn pillar(options: &BuildOptions) -> Image {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/pillar.obj");
        let (scene, exec) = (read(&path, &ReadOptions::default()).unwrap(), Executor::sequential());
        Image::new(&compile(scene, options, &exec, &NoProgress).unwrap(), &exec).unwrap()
    }

    /// The slots of all triangles that a ray is tested with, in order.
    #[derive(Default)]
    struct Slots {
        nodes: Vec<u32>,
        tests: usize,
    }

    impl Observer for Slots {
        fn pair(&mut self, first: u32, _near: [f32; 2], met: u32) {
            self.nodes.extend((0..2).filter(|i| met >> i & 1 == 1).map(|i| first + i));
        }

        fn resume(&mut self, node: u32, _near: f32, dropped: bool) {
            if dropped {
                self.nodes.retain(|n| *n != node);
            }
        }

        fn triangle(&mut self) {
            self.tests += 1;
        }
    }

    /// A plain count: a ray goes into each leaf that it meets and does not drop.
    #[test]
    fn leaves_are_those_that_are_met_and_not_dropped() {
        let image = pillar(&BuildOptions { method: Method::Binned, ..BuildOptions::preset(Preset::Draft) });
        let view = image.view();
        let camera = Camera::automatic(&view);
        let lens = crate::report::picture::Lens::new(&camera, 60, 60);
        let mut seen = (0u32, 0usize);
        for i in 0..3600 {
            let ray: Ray = lens.ray((i % 60) as f64, (i / 60) as f64);
            let (mut work, mut plain) = (RayWork::default(), Slots::default());
            try_closest_hit(&view, &ray, &mut work).unwrap();
            try_closest_hit(&view, &ray, &mut plain).unwrap();
            let leaves: Vec<_> = plain.nodes.iter().filter(|n| view.nodes[**n as usize].is_leaf()).collect();
            assert_eq!((work.leaves as usize, work.triangles as usize), (leaves.len(), plain.tests), "{ray:?}");
            seen = (seen.0 + work.leaves, seen.1 + plain.tests);
        }
        assert!(seen.0 > 100 && seen.1 > seen.0 as usize, "{seen:?}");
    }

    #[test]
    fn variability_has_a_closed_form() {
        let work = |leaves: u32| {
            let mut work = RayWork::default();
            for _ in 0..leaves {
                work.inner_node();
                work.triangle();
                work.triangle();
            }
            work
        };
        let set = SetReport::of("primary", &[work(1), work(1), work(4), work(6)]).unwrap();
        // Leaves 1, 1, 4, 6: mean 3, variance (4 + 4 + 1 + 9) / 4.
        assert_eq!((set.leaves, set.visits, set.tests, set.rays), (3.0, 3.0, 6.0, 4));
        assert!((set.leaf_variability - 4.5f64.sqrt()).abs() < 1e-12 && (set.cost - 9.6).abs() < 1e-12);
        assert!(SetReport::of("primary", &[]).is_none());
    }

    #[test]
    fn the_cost_is_that_of_the_probe_rays_and_nothing_costs_nothing() {
        let image = pillar(&BuildOptions::preset(Preset::Draft));
        let (view, exec) = (image.view(), Executor::sequential());
        let report = RayReport::of_view(&view, 256, &exec);
        let cost = ProbeRays::around(&view, &Camera::around(&view), 256).cost(&view, &exec);
        assert!((report.cost - cost.mean()).abs() < 1e-9 && report.sets.len() == 3, "{report:?}");
        assert_eq!(report, RayReport::of_view(&view, 256, &Executor::new(3).unwrap()));
        let nothing = RayReport::of_view(&Image::default().view(), 64, &exec);
        assert_eq!(nothing.mean(|set| set.visits), 0.0);
    }
}
