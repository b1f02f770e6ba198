//! Probe rays: what a renderer asks of a tree, in three sets, to judge trees by the work that they cause.
//!
//! Camera rays, one cosine-weighted bounce off what the camera sees, and ambient occlusion from there (any hit, up to a tenth of the
//! diagonal), as many of each. All trees of a scene are given the same rays; counts carry no noise of any clock.

use super::rays::{Random, camera, cosine_ray};
use super::{Counters, any_hit, closest_hit, try_any_hit, try_closest_hit};
use crate::build::Executor;
use crate::cache::{TriangleRecord, View};
use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Aabb, Ray};
use crate::tree::Node;
use crate::tree::quality::{REPORT_INTERSECTION_COST, REPORT_TRAVERSAL_COST};

/// Where the camera rays come from: a pinhole that sees `tan_half` to each side of its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    pub eye: [f64; 3],
    pub look_at: [f64; 3],
    pub up: [f64; 3],
    pub tan_half: f64,
}

impl Camera {
    /// A camera for a one-level scene that nobody chose one for, with y up: where the middle is walled in it stands inside and looks along the longer
    /// horizontal side, elsewhere it looks at the middle from outside. Where nearly all triangles crowd in a small part of the scene, as a
    /// teapot in a stadium, it frames that part.
    pub fn automatic(view: &View<'_>) -> Camera {
        Camera::from_side(view, &subject(view), 0)
    }

    /// Four cameras, so that no single view decides: along the four horizontal directions where the middle is walled in, elsewhere from outside,
    /// from four corners of a cube that are as far from each other as they can be.
    pub fn around(view: &View<'_>) -> [Camera; 4] {
        let subject = subject(view);
        [0, 1, 2, 3].map(|side| Camera::from_side(view, &subject, side))
    }

    fn from_side(view: &View<'_>, subject: &Aabb, side: usize) -> Camera {
        let (min, max) = (subject.min.map(f64::from), subject.max.map(f64::from));
        let extent = sub(max, min);
        let middle = [0, 1, 2].map(|k| (0.5 * (min[k] + max[k])) as f32);
        let walls = (0..6).filter(|i| {
            let mut direction = [0.0; 3];
            direction[i / 2] = if i % 2 == 0 { 1.0 } else { -1.0 };
            any_hit(view, &Ray::new(middle, direction))
        });
        if walls.count() < 5 {
            let diagonal = dot(extent, extent).sqrt();
            let center = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]));
            // An even number of signs turned around leads to a corner that is no neighbour.
            let turned = |k: usize| side > 0 && side - 1 != k;
            let offset = [0.5, 0.45, 0.7];
            let eye = [0, 1, 2].map(|k| center[k] + diagonal * if turned(k) { -offset[k] } else { offset[k] });
            Camera { eye, look_at: center, up: [0.0, 1.0, 0.0], tan_half: 0.6 }
        } else {
            // The longer side first and there and back; the first two sides are along one axis.
            let along_x = (extent[0] >= extent[2]) == (side < 2);
            let [start, end, aside, beyond] =
                if side.is_multiple_of(2) { [0.2, 0.9, 0.45, 0.55] } else { [0.8, 0.1, 0.55, 0.45] };
            match along_x {
                true => Camera::within(min, max, [start, 0.4, aside], [end, 0.4, beyond]),
                false => Camera::within(min, max, [aside, 0.4, start], [beyond, 0.4, end]),
            }
        }
    }

    /// With eye and aim as shares of a box's sides.
    pub fn within(min: [f64; 3], max: [f64; 3], eye: [f64; 3], aim: [f64; 3]) -> Camera {
        let at = |share: [f64; 3]| [0, 1, 2].map(|k| min[k] + share[k] * (max[k] - min[k]));
        Camera { eye: at(eye), look_at: at(aim), up: [0.0, 1.0, 0.0], tan_half: 0.6 }
    }
}

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
    /// About `count` rays a set (the next lower square). The tree of `view` decides nothing but how long it takes to find what the camera sees. Where it sees
    /// nothing the other sets are empty.
    pub fn new(view: &View<'_>, from: &Camera, count: usize) -> ProbeRays {
        ProbeRays::around(view, std::slice::from_ref(from), count)
    }

    /// [`ProbeRays::new`] from several cameras, which share the rays.
    pub fn around(view: &View<'_>, cameras: &[Camera], count: usize) -> ProbeRays {
        let side = ((count / cameras.len().max(1)) as f64).sqrt() as usize;
        let primary: Vec<Ray> =
            cameras.iter().flat_map(|c| camera(c.eye, c.look_at, c.up, c.tan_half, side, side)).collect();
        let diagonal = view.nodes.first().map_or(1.0, |root| {
            let extent = sub(root.max.map(f64::from), root.min.map(f64::from));
            dot(extent, extent).sqrt()
        });

        // Bounce off what the cameras see, over and over with other directions until there are enough.
        let hits: Vec<([f64; 3], [f64; 3])> = primary.iter().filter_map(|ray| surface(view, ray)).collect();
        let mut random = Random::new(7);
        let mut bounce = || -> Vec<Ray> {
            let lift = 1e-4 * diagonal;
            let one =
                |(p, n): &([f64; 3], [f64; 3])| cosine_ray([0, 1, 2].map(|k| p[k] + lift * n[k]), *n, &mut random);
            hits.iter().cycle().take(if hits.is_empty() { 0 } else { primary.len() }).map(one).collect()
        };
        let diffuse = bounce();
        let short = |ray: Ray| {
            let d = ray.direction.map(f64::from);
            let length = dot(d, d).sqrt();
            Ray { direction: d.map(|c| (c / length) as f32), ..ray }.until((0.1 * diagonal) as f32)
        };
        let occlusion = bounce().into_iter().map(short).collect();
        ProbeRays { sets: [primary, diffuse, occlusion] }
    }

    /// Rays in a set.
    pub fn len(&self, set: usize) -> usize {
        self.sets[set].len()
    }

    /// Whether the camera saw nothing.
    pub fn is_empty(&self) -> bool {
        self.sets[1].is_empty()
    }

    /// Count what all rays do in a tree. A ray whose walk finds the tree malformed counts as far as it came.
    pub fn cost(&self, view: &View<'_>, exec: &Executor) -> RayCost {
        let mut out = RayCost::default();
        for (set, rays) in self.sets.iter().enumerate() {
            let parts = exec.map_chunks(rays, 1 << 12, |_, chunk| {
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
            2 => self.sets[2].iter().filter(|ray| any_hit(view, ray)).count(),
            _ => self.sets[set].iter().filter(|ray| closest_hit(view, ray).is_some()).count(),
        }
    }
}

/// Triangles that are asked where they are.
const ASKED: usize = 4096;
/// Nearly all triangles: without this share of them at either end of each axis.
const TRIMMED: f64 = 0.02;
/// They crowd if they fill less than this share of the scene's diagonal.
const CROWDED: f64 = 0.125;

/// The box of the scene, or of what nearly all of its triangles are in, with a quarter of it around, if that is much smaller.
fn subject(view: &View<'_>) -> Aabb {
    let Some(whole) = view.nodes.first().map(Node::bounds) else { return Aabb { min: [0.0; 3], max: [1.0; 3] } };
    let step = view.triangles.len().div_ceil(ASKED).max(1);
    let mut core = whole;
    for axis in 0..3 {
        let centre = |t: &TriangleRecord| t.corners().map(|p| p[axis] / 3.0).iter().sum::<f32>();
        let mut centres: Vec<f32> = view.triangles.iter().step_by(step).map(centre).collect();
        centres.sort_unstable_by(f32::total_cmp);
        let trimmed = (centres.len() as f64 * TRIMMED) as usize;
        if let (Some(low), Some(high)) = (centres.get(trimmed), centres.iter().rev().nth(trimmed)) {
            let around = 0.25 * (high - low);
            (core.min[axis], core.max[axis]) = (low - around, high + around);
        }
    }
    let diagonal = |b: &Aabb| {
        let extent = b.extent().map(f64::from);
        dot(extent, extent).sqrt()
    };
    if diagonal(&core) < CROWDED * diagonal(&whole) { core } else { whole }
}

/// Where a ray ends, and the unit normal there on the ray's side.
fn surface(view: &View<'_>, ray: &Ray) -> Option<([f64; 3], [f64; 3])> {
    let hit = closest_hit(view, ray)?;
    let [a, b, c] = view.triangles[hit.triangle].corners().map(|p| p.map(f64::from));
    let n = cross(sub(b, a), sub(c, a));
    let d = ray.direction.map(f64::from);
    let length = dot(n, n).sqrt();
    let facing = if dot(n, d) > 0.0 { -length } else { length };
    let point = [0, 1, 2].map(|k| f64::from(ray.origin[k]) + f64::from(hit.t) * d[k]);
    (length > 0.0).then(|| (point, n.map(|v| v / facing)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, NoProgress, Preset, build_tree};
    use crate::cache::Image;
    use crate::scene::{Mesh, Part};
    use crate::tree::Accel;

    /// A box of 12 triangles from -1 to 1, seen from inside or outside.
    fn cube(options: &BuildOptions) -> Image {
        let positions = (0..8u32).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 })).collect();
        let quads: [[u32; 4]; 6] = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let parts = vec![Part { triangle_count: 12, prim_count: 12, ..Part::default() }];
        let mesh = Mesh { positions, triangles, parts, ..Mesh::default() };
        let tree = build_tree(&mesh, options, &Executor::sequential(), &NoProgress).unwrap();
        Image::new(&Accel { meshes: vec![mesh], blases: vec![tree], ..Accel::default() })
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
    fn cameras_frame_what_nearly_all_triangles_are_in() {
        // A thousand specks around (70, 0, 0), each a hundredth large, on a floor from -100 to 100.
        let specks = (0..1000).flat_map(|i| {
            let at = [70.0 + 0.1 * (i % 10) as f32, 0.1 * (i / 10 % 10) as f32, 0.1 * (i / 100) as f32];
            [at, [at[0] + 0.01, at[1], at[2]], [at[0], at[1] + 0.01, at[2]]]
        });
        let floor = [[-100.0, -1.0, -100.0], [100.0, -1.0, -100.0], [0.0, -1.0, 100.0]];
        let build = |positions: Vec<[f32; 3]>| {
            let triangles: Vec<[u32; 3]> =
                (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let count = triangles.len() as u32;
            let parts = vec![Part { triangle_count: count, prim_count: count, ..Part::default() }];
            let mesh = Mesh { positions, triangles, parts, ..Mesh::default() };
            let options = BuildOptions::preset(Preset::Draft);
            let tree = build_tree(&mesh, &options, &Executor::sequential(), &NoProgress).unwrap();
            Image::of_tree(&mesh, &tree)
        };
        let crowded = build(specks.clone().chain(floor).collect());
        let framed = subject(&crowded.view());
        assert!(framed.min[0] > 69.0 && framed.max[0] < 72.0 && framed.extent()[2] < 2.0, "{framed:?}");
        for camera in Camera::around(&crowded.view()) {
            assert!((camera.eye[0] - 70.5).abs() < 5.0 && camera.eye[2].abs() < 5.0, "{camera:?}");
        }

        // Without the floor, or with more of it, the whole scene.
        let alone = build(specks.clone().collect());
        assert_eq!(subject(&alone.view()), alone.nodes[0].bounds());
        let tiled =
            build(specks.chain((0..50).flat_map(|i| floor.map(|p| [p[0], p[1] - 0.01 * i as f32, p[2]]))).collect());
        assert_eq!(subject(&tiled.view()), tiled.nodes[0].bounds());
    }

    #[test]
    fn nothing_to_see() {
        let image = Image::default();
        let rays = ProbeRays::new(&image.view(), &Camera::automatic(&image.view()), 100);
        assert!(rays.is_empty());
        assert_eq!(rays.cost(&image.view(), &Executor::sequential()), RayCost::default());
    }
}
