//! Probe rays: what a renderer asks of a tree, in three sets, to judge trees by the work that they cause.
//!
//! Camera rays, one cosine-weighted bounce off what the camera sees, and ambient occlusion from there (any hit, up to a tenth of the
//! diagonal), as many of each. All trees of a scene are given the same rays; counts carry no noise of any clock.
//!
//! `camera` chooses views where nobody did, `bounce` follows light from there. `families` are the rays that searches judge by and form trees
//! from: what cameras see is one purpose among several.

mod bounce;
mod camera;
mod families;
mod work;
mod world;

pub use camera::Camera;
#[cfg(feature = "cli")]
pub(crate) use camera::subject;
pub use families::{FAMILIES, Family, FamilyCost, FamilyRays};
pub use work::RayWork;

use self::bounce::{Struck, bounces, camera_rays, strike, toward_occluders};
pub(crate) use self::world::World;
use super::{Counters, any_hit, closest_hit, try_any_hit, try_closest_hit};
use crate::cache::View;
use crate::exec::Executor;
use crate::geom::Ray;
use crate::random::Random;
use crate::tree::quality::{REPORT_INTERSECTION_COST, REPORT_TRAVERSAL_COST};

/// Rays that a task traces. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 8;

/// The names of the sets, in their order.
pub const SETS: [&str; 3] = ["primary", "diffuse", "occlusion"];

/// The three sets of rays of one scene.
#[derive(Clone, Debug)]
pub struct ProbeRays {
    sets: [Vec<Ray>; 3],
}

/// What a ray of each set costs on average in some tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayCost {
    /// Inner nodes entered, triangles tested, by set.
    pub sets: [[f64; 2]; 3],
}

impl RayCost {
    /// C_T · nodes + C_I · triangles of one set, with the report's costs.
    pub fn work(&self, set: usize) -> f64 {
        REPORT_TRAVERSAL_COST * self.sets[set][0] + REPORT_INTERSECTION_COST * self.sets[set][1]
    }

    /// The mean of the sets' works: the one number to judge a tree by.
    pub fn mean(&self) -> f64 {
        (0..3).map(|set| self.work(set)).sum::<f64>() / 3.0
    }
}

impl ProbeRays {
    /// About `count` rays a set (the next lower square, and at least one ray unless there are to be none). The tree of `view` decides nothing but how long it takes to find what the camera sees. Where it sees
    /// nothing the other sets are empty.
    pub fn new(view: &View<'_>, from: &Camera, count: usize) -> ProbeRays {
        ProbeRays::around(view, std::slice::from_ref(from), count)
    }

    /// [`ProbeRays::new`] from several cameras, which share the rays.
    pub fn around(view: &View<'_>, cameras: &[Camera], count: usize) -> ProbeRays {
        ProbeRays::around_while(view, cameras, count, &|| true)
    }

    /// [`ProbeRays::around`] for as long as that goes on: what the cameras see in the rest of their rays is left out then.
    pub(crate) fn around_while(
        view: &View<'_>,
        cameras: &[Camera],
        count: usize,
        goes_on: &dyn Fn() -> bool,
    ) -> ProbeRays {
        let primary = camera_rays(cameras, count);
        let world = World::new(view);
        let diagonal = world.diagonal();
        let looked = primary.iter().take_while(|_| goes_on());
        let seen: Vec<Struck> = looked.filter_map(|ray| strike(&world, ray)).collect();
        let mut random = Random::new(7);
        let diffuse = bounces(&seen, primary.len(), diagonal, &mut random);
        let occlusion = bounces(&seen, primary.len(), diagonal, &mut random);
        let occlusion = occlusion.into_iter().map(|ray| toward_occluders(ray, diagonal)).collect();
        ProbeRays { sets: [primary, diffuse, occlusion] }
    }

    /// Rays in a set.
    pub fn len(&self, set: usize) -> usize {
        self.sets[set].len()
    }

    /// The rays of a set.
    pub fn rays(&self, set: usize) -> &[Ray] {
        &self.sets[set]
    }

    /// Whether the camera saw nothing.
    pub fn is_empty(&self) -> bool {
        self.sets[1].is_empty()
    }

    /// Count what all rays do in a tree. A ray whose walk finds the tree malformed counts as far as it came.
    pub fn cost(&self, view: &View<'_>, exec: &Executor) -> RayCost {
        let mut out = RayCost::default();
        for (set, rays) in self.sets.iter().enumerate() {
            let parts = exec.map_chunks(rays, CHUNK, |_, chunk| {
                let mut counters = Counters::default();
                for ray in chunk {
                    match set {
                        2 => drop(try_any_hit(view, ray, &mut counters)),
                        _ => drop(try_closest_hit(view, ray, &mut counters)),
                    }
                }
                counters
            });
            let sum = parts.into_iter().fold(Counters::default(), |a, b| a + b);
            let per_ray = |n: u64| if rays.is_empty() { 0.0 } else { n as f64 / rays.len() as f64 };
            out.sets[set] = [per_ray(sum.inner_nodes), per_ray(sum.triangles)];
        }
        out
    }

    /// Trace a set on this thread and say how many rays hit something: for a clock around it.
    pub fn trace(&self, set: usize, view: &View<'_>) -> usize {
        match set {
            2 => self.sets[2].iter().filter(|ray| any_hit(view, ray) == Ok(true)).count(),
            _ => self.sets[set].iter().filter(|ray| matches!(closest_hit(view, ray), Ok(Some(_)))).count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, NoProgress, Preset, initial_tree};
    use crate::cache::Image;
    use crate::scene::{Mesh, Part};
    use crate::tree::Accel;

    /// A box of 12 triangles from -1 to 1, seen from inside or outside.
    pub(super) fn cube(options: &BuildOptions) -> Image {
        let positions = (0..8u32).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 })).collect();
        let quads: [[u32; 4]; 6] = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let parts = vec![Part { triangle_count: 12, prim_count: 12, ..Part::default() }];
        let mesh = Mesh { positions, triangles, parts, ..Mesh::default() };
        let tree = initial_tree(&mesh, options, &Executor::sequential(), &NoProgress).unwrap();
        Image::new(&Accel { meshes: vec![mesh], blases: vec![tree], ..Accel::default() }, &Executor::sequential())
            .unwrap()
    }

    #[test]
    fn inside_a_room_every_ray_hits_and_costs_depend_on_no_thread() {
        let image = cube(&BuildOptions::preset(Preset::Draft));
        let view = image.view();
        let camera = Camera::automatic(&view);
        assert!(camera.eye.iter().all(|c| c.abs() < 1.0), "{camera:?}");
        let rays = ProbeRays::new(&view, &camera, 10_000);
        assert_eq!([0, 1, 2].map(|set| rays.len(set)), [10_000; 3]);
        assert_eq!((rays.trace(0, &view), rays.trace(1, &view)), (10_000, 10_000));
        let near = rays.trace(2, &view);
        assert!(near > 500 && near < 9_500, "short rays reach a wall only near the edges: {near}");
        let cost = rays.cost(&view, &Executor::sequential());
        assert_eq!(cost, rays.cost(&view, &Executor::new(3).unwrap()));
        assert!(cost.sets.iter().flatten().all(|n| *n > 0.0), "{cost:?}");
        let by_hand = cost.sets.iter().map(|[v, t]| 1.2 * v + t).sum::<f64>() / 3.0;
        assert!((cost.mean() - by_hand).abs() < 1e-12);
    }

    #[test]
    fn a_tree_of_one_leaf_costs_its_triangles() {
        let image =
            cube(&BuildOptions { max_leaf: 255, traversal_cost: 1000.0, ..BuildOptions::preset(Preset::Draft) });
        let view = image.view();
        let rays = ProbeRays::new(&view, &Camera::automatic(&view), 100);
        assert_eq!(rays.cost(&view, &Executor::sequential()).sets[..2], [[0.0, 12.0]; 2]);
    }

    #[test]
    fn nothing_to_see() {
        let image = Image::default();
        let rays = ProbeRays::new(&image.view(), &Camera::automatic(&image.view()), 100);
        assert!(rays.is_empty());
        assert_eq!(rays.cost(&image.view(), &Executor::sequential()), RayCost::default());
    }
}
