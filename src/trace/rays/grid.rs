//! Grid mode: random scenes of whole numbers, in which no arithmetic rounds, so that all devices must agree on every bit.
//!
//! Corners are whole numbers of at most 8, origins of at most 12, directions of at most 40. In a one-level scene all that a
//! triangle test adds and multiplies then stays below 2²⁴, exact in `f32` as in `f64`; only the last division rounds, and IEEE 754 says how.
//! (Rounding a quotient of such numbers to `f64` and then to `f32` gives the nearest `f32`, since 53 ≥ 2·24 + 2.) In a scene of several
//! instances the maps turn by quarters, mirror, halve, double and move by whole numbers: both matrices of a file are exact, and so is all
//! that `f64` does with them.

use crate::geom::{Affine, Point, Ray};
use crate::random::Random;
use crate::scene::{Instance, Mesh, Part, Scene};

/// Largest corner coordinate.
const CORNER: u32 = 8;
/// Largest coordinate of an origin.
const ORIGIN: u32 = 12;
/// Most triangles of a mesh.
const TRIANGLES: u64 = 96;

/// A scene of whole numbers and rays through it.
#[derive(Clone, Debug)]
pub struct GridScene {
    /// Small whole coordinates; instances are moved by whole numbers.
    pub scene: Scene,
    /// From whole origins in whole directions.
    pub rays: Vec<Ray>,
}

impl GridScene {
    /// The scene of that seed, with `count` rays. One in four has several instances.
    ///
    /// Triangles share corners and edges, lie in coordinate planes, cover each other, stand twice and have no area: whatever
    /// makes ties and rays through edges. Rays are aimed at corners, at middles of edges and anywhere; some run along
    /// axes with zeros of both signs, some start on corners, some have ends.
    pub fn new(seed: u64, count: usize) -> GridScene {
        let mut random = Random::new(seed ^ 0x6772_6964);
        let scene = if seed % 4 == 3 { several(&mut random) } else { one(&mut random) };
        let rays = (0..count).map(|_| ray(&scene, &mut random)).collect();
        GridScene { scene, rays }
    }
}

fn one(random: &mut Random) -> Scene {
    let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
    Scene { meshes: vec![mesh(0, random)], instances: vec![instance], ..Scene::default() }
}

fn several(random: &mut Random) -> Scene {
    let meshes: Vec<Mesh> = (0..=random.below(3) as u32).map(|number| mesh(number, random)).collect();
    let places = 2 + random.below(5);
    let instances = (0..places).map(|node| Instance {
        mesh: random.below(meshes.len() as u64) as u32,
        transform: transform(random),
        node: node as u32,
        name: String::new(),
    });
    let mut instances: Vec<Instance> = instances.collect();

    // Every mesh is shown, as after reading a model.
    for (number, instance) in instances.iter_mut().enumerate().take(meshes.len()) {
        instance.mesh = number as u32;
    }
    for number in instances.len()..meshes.len() {
        let mesh = number as u32;
        instances.push(Instance { mesh, transform: transform(random), node: mesh, name: String::new() });
    }
    Scene { meshes, instances, ..Scene::default() }
}

/// Triangles over a small pool of corners, in a part or two.
fn mesh(number: u32, random: &mut Random) -> Mesh {
    let corners = 4 + random.below(24);
    let flat = random.below(4) == 0;
    let corner = |random: &mut Random| {
        let mut p: Point = [0; 3].map(|_| random.whole(CORNER));
        if flat {
            p[2] = random.below(2) as f32;
        }
        p
    };
    let positions: Vec<Point> = (0..corners).map(|_| corner(random)).collect();
    let count = 1 + random.below(TRIANGLES);
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for i in 0..count as usize {
        let triangle = match random.below(12) {
            0 if i > 0 => triangles[random.below(i as u64) as usize],
            _ => [0; 3].map(|_| random.below(corners) as u32),
        };
        triangles.push(triangle);
    }
    let count = count as u32;
    let first = random.below(u64::from(count)) as u32;
    let part = |source_part: u32, first_triangle: u32, triangle_count: u32| Part {
        source_mesh: number,
        source_part,
        first_triangle,
        triangle_count,
        first_prim: first_triangle,
        prim_count: triangle_count,
        ..Part::default()
    };
    let parts =
        if first == 0 { vec![part(0, 0, count)] } else { vec![part(0, 0, first), part(1, first, count - first)] };
    Mesh { positions, triangles, parts, ..Mesh::default() }
}

/// A permutation of the axes with signs, times ½, 1 or 2, and a move by whole numbers.
fn transform(random: &mut Random) -> Affine {
    let order = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]][random.below(6) as usize];
    let scale = [0.5, 1.0, 2.0][random.below(3) as usize];
    let mut rows = [[0.0; 4]; 3];
    for (row, axis) in rows.iter_mut().zip(order) {
        row[axis] = if random.coin() { scale } else { -scale };
        row[3] = f64::from(random.whole(CORNER));
    }
    Affine { rows }
}

fn ray(scene: &Scene, random: &mut Random) -> Ray {
    // A random triangle, moved into the world: whole numbers again, halves at most.
    let instance = &scene.instances[random.below(scene.instances.len() as u64) as usize];
    let mesh = &scene.meshes[instance.mesh as usize];
    let corners = mesh.corners(random.below(mesh.triangles.len() as u64) as usize).map(|p| instance.transform.bake(p));
    let origin = if random.below(8) == 0 { corners[2] } else { [0; 3].map(|_| random.whole(ORIGIN)) };
    let single = scene.instances.len() == 1;
    let direction = match random.below(6) {
        0 | 1 => [0, 1, 2].map(|a| corners[0][a] - origin[a]),
        2 | 3 => [0, 1, 2].map(|a| corners[0][a] + corners[1][a] - 2.0 * origin[a]),
        4 => {
            let mut direction = random.zeros();
            direction[random.below(3) as usize] = if random.coin() { 1.0 } else { -1.0 };
            direction
        }
        _ => [0; 3].map(|_| random.whole(CORNER)),
    };
    let direction = if direction.iter().all(|d| *d == 0.0) { [0.0, -0.0, 1.0] } else { direction };
    debug_assert!(!single || direction.iter().all(|d| d.abs() <= 40.0));
    let (t_min, t_max) = match random.below(8) {
        0 => (0.25 * random.below(8) as f32, f32::INFINITY),
        1 => (0.0, 0.25 * (1 + random.below(16)) as f32),
        2 => (-2.0, 2.0),
        _ => (0.0, f32::INFINITY),
    };
    Ray { origin, direction, t_min, t_max }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_numbers_are_small_and_whole_or_half() {
        let small = |v: f32, most: f32, unit: f32| v.abs() <= most && (v * unit).fract() == 0.0;
        let mut rays_with_both_zeros = 0;
        for seed in 0..200 {
            let GridScene { scene, rays } = GridScene::new(seed, 50);
            let single = scene.instances.len() == 1;
            assert_eq!(single, seed % 4 != 3);
            for mesh in &scene.meshes {
                assert!(mesh.positions.iter().flatten().all(|v| small(*v, 8.0, 1.0)));
                assert_eq!(mesh.parts.iter().map(|p| p.triangle_count).sum::<u32>(), mesh.triangles.len() as u32);
            }
            for instance in &scene.instances {
                let stored = instance.transform.to_f32();
                assert_eq!(Affine::from_f32(&stored), instance.transform);
                let back = instance.transform.inverse().expect("an inverse");
                assert_eq!(Affine::from_f32(&back.to_f32()), back);
                assert_eq!(instance.transform.then_inner(&back), Affine::IDENTITY);
            }
            for ray in &rays {
                let (most, unit) = if single { (40.0, 1.0) } else { (200.0, 2.0) };
                assert!(ray.origin.iter().chain(&ray.direction).all(|v| small(*v, most, unit)), "{ray:?}");
                assert!(ray.direction != [0.0; 3] && ray.t_min <= ray.t_max);
                let zeros: Vec<bool> =
                    ray.direction.iter().filter(|d| **d == 0.0).map(|d| d.is_sign_negative()).collect();
                rays_with_both_zeros += usize::from(zeros.contains(&true) && zeros.contains(&false));
            }
        }
        assert!(rays_with_both_zeros > 100, "{rays_with_both_zeros}");
    }

    #[test]
    fn a_seed_always_gives_the_same_bits() {
        let GridScene { scene, rays } = GridScene::new(7, 100);
        let mut hasher = blake3::Hasher::new();
        for v in scene.meshes.iter().flat_map(|m| m.positions.iter().flatten()) {
            hasher.update(&v.to_le_bytes());
        }
        for v in scene.instances.iter().flat_map(|i| i.transform.to_f32()) {
            hasher.update(&v.to_le_bytes());
        }
        for ray in &rays {
            let numbers = ray.origin.iter().chain(&ray.direction).chain([&ray.t_min, &ray.t_max]);
            numbers.for_each(|v| _ = hasher.update(&v.to_le_bytes()));
        }
        assert_eq!(&hasher.finalize().to_hex()[..16], "f146d28edccf68d5");
    }
}
