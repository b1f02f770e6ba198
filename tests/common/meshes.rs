//! Scenes made in tests: closed meshes, and meshes placed by instances.

use bvhc::geom::{Affine, Point};
use bvhc::scene::{Instance, Mesh, Part, Scene};

/// Without instances of empty meshes, which a cache leaves out, so that instance numbers are those of the cache.
pub fn visible(mut scene: Scene) -> Scene {
    let Scene { meshes, instances, .. } = &mut scene;
    instances.retain(|i| !meshes[i.mesh as usize].triangles.is_empty());
    scene
}

pub fn scene_of(mesh: Mesh) -> Scene {
    place(mesh, &[Affine::IDENTITY])
}

pub fn place(mesh: Mesh, transforms: &[Affine]) -> Scene {
    let count = mesh.triangles.len() as u32;
    let part = Part { triangle_count: count, prim_count: count, ..Part::default() };
    let mesh = Mesh { parts: vec![part], ..mesh };
    let instance = |transform: &Affine| Instance { mesh: 0, transform: *transform, node: 0, name: String::new() };
    Scene { meshes: vec![mesh], instances: transforms.iter().map(instance).collect(), ..Scene::default() }
}

/// A closed mesh: each face of the cube cut into n × n cells of two triangles, corners shared, put through `map`.
pub fn cube(n: u32, map: impl Fn([f64; 3]) -> Point) -> Mesh {
    let mut mesh = Mesh::default();
    let mut numbers = std::collections::BTreeMap::new();
    let mut vertex = |p: [u32; 3], mesh: &mut Mesh| {
        *numbers.entry(p).or_insert_with(|| {
            mesh.positions.push(map(p.map(|c| 2.0 * f64::from(c) / f64::from(n) - 1.0)));
            mesh.positions.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, n] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let at = |i: u32, j: u32| {
                    let mut p = [side; 3];
                    p[(axis + 1) % 3] = i;
                    p[(axis + 2) % 3] = j;
                    p
                };
                let [a, b, c, d] =
                    [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)].map(|p| vertex(p, &mut mesh));
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

pub fn sphere(n: u32, radius: f64, center: [f64; 3]) -> Mesh {
    cube(n, |p| {
        let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        [0, 1, 2].map(|a| (center[a] + radius * p[a] / length) as f32)
    })
}
