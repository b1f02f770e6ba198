//! A scene of one level or of two, in world space.

use crate::cache::{TriangleRecord, View};
use crate::geom::vector::{dot, sub};
use crate::geom::{Aabb, Affine};
use crate::trace::Hit;
use crate::tree::Node;

/// A view, and where its instances stand.
pub(crate) struct World<'v> {
    pub view: &'v View<'v>,
    /// By the instance's number; empty in a scene of one level.
    places: Vec<Affine>,
}

impl<'v> World<'v> {
    pub fn new(view: &'v View<'v>) -> World<'v> {
        let mut places = vec![Affine::IDENTITY; view.instances.len()];
        for instance in view.instances {
            if let Some(place) = places.get_mut(instance.id as usize) {
                *place = Affine::from_f32(&instance.object_to_world);
            }
        }
        World { view, places }
    }

    /// The box around everything, if there is anything.
    pub fn bounds(&self) -> Option<Aabb> {
        self.view.tlas_nodes.first().or(self.view.nodes.first()).map(Node::bounds)
    }

    /// The diagonal of that box.
    pub fn diagonal(&self) -> f64 {
        self.bounds().map_or(1.0, |bounds| {
            let extent = sub(bounds.max.map(f64::from), bounds.min.map(f64::from));
            dot(extent, extent).sqrt()
        })
    }

    /// The corners of what a ray has hit.
    pub fn corners(&self, hit: &Hit) -> [[f64; 3]; 3] {
        let corners = self.view.triangles[hit.triangle].corners().map(|p| p.map(f64::from));
        match hit.instance.and_then(|id| self.places.get(id as usize)) {
            Some(place) => corners.map(|p| place.transform_point(p)),
            None => corners,
        }
    }

    /// The centres of about so many triangles of the source, each once: the same ones whatever the trees.
    pub fn centres(&self, count: usize) -> Vec<[f32; 3]> {
        let centre = |corners: [[f32; 3]; 3]| [0, 1, 2].map(|k| corners.map(|p| p[k] / 3.0).iter().sum::<f32>());
        self.triangles(count).into_iter().map(centre).collect()
    }

    /// The corners of these.
    pub fn triangles(&self, count: usize) -> Vec<[[f32; 3]; 3]> {
        let View { blases, instances, triangles, .. } = *self.view;
        let prims = |blas: u32| blases.get(blas as usize).map_or(0, |blas| blas.prim_count as usize);
        let all: usize = match instances {
            [] => blases.iter().map(|blas| blas.prim_count as usize).sum(),
            some => some.iter().map(|instance| prims(instance.blas)).sum(),
        };
        let step = all.div_ceil(count).max(1);
        let some = |triangles: &'v [TriangleRecord]| {
            let mut asked: Vec<&TriangleRecord> =
                triangles.iter().filter(|t| (t.prim as usize).is_multiple_of(step)).collect();
            asked.sort_unstable_by_key(|t| (t.geom, t.prim));
            asked.dedup_by_key(|t| (t.geom, t.prim));
            asked
        };
        if instances.is_empty() {
            return some(triangles).into_iter().map(TriangleRecord::corners).collect();
        }
        let mut corners = Vec::new();
        for instance in instances {
            let place = Affine::from_f32(&instance.object_to_world);
            let Some(tree) = self.view.blas(instance.blas as usize) else { continue };
            corners.extend(some(tree.triangles).into_iter().map(|t| t.corners().map(|p| place.bake(p))));
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Executor, NoProgress, Preset, initial_tree, tlas};
    use crate::cache::Image;
    use crate::scene::{Instance, Mesh, Part};
    use crate::trace::probe::{Camera, ProbeRays};
    use crate::tree::Accel;

    /// Steps, which look different from every side.
    fn steps() -> Mesh {
        let quad = |i: u32| {
            let x = i as f32;
            [[x, x * x * 0.1, 0.0], [x + 1.0, x * x * 0.1, 0.0], [x + 1.0, x * x * 0.1, 4.0], [x, x * x * 0.1, 4.0]]
        };
        let triangles: Vec<[u32; 3]> =
            (0..8).flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]).collect();
        let parts = vec![Part { triangle_count: 16, prim_count: 16, ..Part::default() }];
        Mesh { positions: (0..8).flat_map(quad).collect(), triangles, parts, ..Mesh::default() }
    }

    #[test]
    fn rays_of_two_levels_are_those_of_the_same_scene_in_one() {
        // A quarter of a turn and a move by whole numbers.
        let turned = Affine { rows: [[0.0, -1.0, 0.0, 3.0], [1.0, 0.0, 0.0, -2.0], [0.0, 0.0, 1.0, 8.0]] };
        let (exec, mesh) = (Executor::sequential(), steps());
        let tree = |mesh: &Mesh| initial_tree(mesh, &BuildOptions::preset(Preset::Draft), &exec, &NoProgress).unwrap();
        let mut baked = mesh.clone();
        baked.positions.iter_mut().for_each(|p| *p = turned.bake(*p));
        let one = Image::of_tree(&baked, &tree(&baked), &exec).unwrap();

        let blas = tree(&mesh);
        let top = tlas::build(&[turned.transform_box(&blas.bounds())], &exec);
        let instance = Instance { mesh: 0, transform: turned, node: 0, name: String::new() };
        let accel = Accel {
            meshes: vec![mesh],
            blases: vec![blas],
            tlas: Some(top),
            instances: vec![instance],
            ..Accel::default()
        };
        let two = Image::new(&accel, &exec).unwrap();

        let (one, two) = (one.view(), two.view());
        let bounds = [&one, &two].map(|view| World::new(view).bounds().unwrap());
        // The box of an instance is a little larger, so that nothing is lost by rounding.
        let nearly = |a: f32, b: f32| (a - b).abs() < 1e-4;
        assert!(
            (0..3).all(|k| nearly(bounds[0].min[k], bounds[1].min[k]) && nearly(bounds[0].max[k], bounds[1].max[k]))
        );
        let sorted = |world: World<'_>| {
            let mut centres = world.centres(4);
            centres.sort_by(|a, b| a.partial_cmp(b).unwrap());
            centres
        };
        assert_eq!(sorted(World::new(&one)), sorted(World::new(&two)));
        let cameras = Camera::around(&one);
        for (a, b) in cameras.iter().zip(Camera::around(&two)) {
            assert!((0..3).all(|k| (a.eye[k] - b.eye[k]).abs() < 1e-4), "{a:?} {b:?}");
        }
        let rays = [&one, &two].map(|view| ProbeRays::around(view, &cameras, 400));
        for set in 0..3 {
            assert!(rays[0].len(set) > 300);
            assert_eq!(rays[0].len(set), rays[1].len(set));
            // Each pair of rays hits the same things, whichever scene they are traced in.
            let hits: Vec<usize> =
                rays.iter().flat_map(|rays| [&one, &two].map(|view| rays.trace(set, view))).collect();
            // Rays start from surfaces by a share of the box's diagonal.
            assert!(
                (set == 2 || hits[0] > 0) && hits.iter().all(|count| count.abs_diff(hits[0]) <= 2),
                "set {set}: {hits:?}"
            );
        }
    }
}
