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
    /// Standard error of `cost`, as that of a mean of independent rays. Two trees of one scene have the same rays, whose costs go together, so their difference is
    /// known better than that.
    pub standard_error: f64,
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
    /// Standard error of `cost`: s / √n with the variance s² = Σ (cost of a ray − mean)² / (n − 1), and 0 of a single ray.
    pub standard_error: f64,
}

impl RayReport {
    /// Trace about `count` rays a set (the next lower number that four cameras with square films have, and at least four).
    pub fn of_view(view: &View<'_>, count: usize, exec: &Executor) -> RayReport {
        RayReport::of_view_while(view, count, exec, &|| true)
    }

    /// [`RayReport::of_view`] for as long as that goes on: after that it says nothing of value.
    pub(crate) fn of_view_while(
        view: &View<'_>,
        count: usize,
        exec: &Executor,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> RayReport {
        let rays = ProbeRays::around_while(view, &Camera::around(view), count, goes_on);
        let set = |(number, name)| SetReport::of(name, &rays.works_while(number, view, exec, goes_on));
        let sets: Vec<SetReport> = SETS.into_iter().enumerate().filter_map(set).collect();
        let cost = mean_of(&sets, |set| set.cost);
        let squares = sets.iter().fold(0.0, |sum, set| sum + set.standard_error * set.standard_error);
        RayReport { cost, standard_error: squares.sqrt() / sets.len().max(1) as f64, sets }
    }

    /// The mean over the sets, each counted alike; 0 without sets.
    pub fn mean(&self, of: impl Fn(&SetReport) -> f64) -> f64 {
        mean_of(&self.sets, of)
    }
}

/// 0 of none: an empty sum is −0.
fn mean_of(sets: &[SetReport], of: impl Fn(&SetReport) -> f64) -> f64 {
    sets.iter().map(of).fold(0.0, |sum, value| sum + value) / sets.len().max(1) as f64
}

impl SetReport {
    fn of(name: &'static str, works: &[RayWork]) -> Option<SetReport> {
        let mean = |of: &dyn Fn(&RayWork) -> f64| works.iter().map(of).sum::<f64>() / works.len() as f64;
        let (visits, tests) = (mean(&|w| f64::from(w.inner_nodes)), mean(&|w| f64::from(w.triangles)));
        let leaves = mean(&|w| f64::from(w.leaves));
        // About the mean, not as the difference of two large numbers.
        let variance = mean(&|w| (f64::from(w.leaves) - leaves).powi(2));
        let of_ray = |visits: f64, tests: f64| REPORT_TRAVERSAL_COST * visits + REPORT_INTERSECTION_COST * tests;
        let cost = of_ray(visits, tests);
        let spread = mean(&|w| (of_ray(f64::from(w.inner_nodes), f64::from(w.triangles)) - cost).powi(2));
        let rays = works.len() as u64;
        // The mean of squares is over n, and the variance over n − 1.
        let standard_error = (spread / rays.saturating_sub(1).max(1) as f64).sqrt();
        let leaf_variability = variance.sqrt();
        (rays > 0).then_some(SetReport { name, rays, visits, tests, leaves, leaf_variability, cost, standard_error })
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
        // Costs 3.2, 3.2, 12.8, 19.2 about 9.6: squares 40.96 + 40.96 + 10.24 + 92.16 over three, and that over four rays.
        assert!((set.standard_error - (184.32f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12, "{set:?}");
        assert_eq!(SetReport::of("primary", &[work(1)]).unwrap().standard_error, 0.0);
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
        let none = RayReport::of_view(&view, 0, &exec);
        assert!(none.sets.is_empty() && none.cost.is_sign_positive() && none.mean(|set| set.tests).is_sign_positive());
        let fewest = RayReport::of_view(&view, 1, &exec);
        // Four cameras see something or nothing; what follows from what they see has no more rays.
        assert_eq!(fewest.sets[0].rays, 4);
        assert!(fewest.sets.iter().all(|set| (1..=4).contains(&set.rays)) && fewest.cost > 0.0, "{fewest:?}");
        let few = RayReport::of_view(&view, 64, &exec);
        assert!(0.0 < report.standard_error && report.standard_error < few.standard_error, "{report:?} {few:?}");
    }
}
