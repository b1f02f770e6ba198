//! Every set is what it says, the same on every machine.

use super::*;
use crate::geom::Affine;
use crate::scene::{Instance, Mesh};
use crate::trace::exact::meet;
use std::cmp::Ordering;

/// Triangles all over a cube, some of them flat, in two places.
fn scene() -> Scene {
    let mut random = Random::new(11);
    let mut mesh = Mesh::default();
    for i in 0..60 {
        let at = [0; 3].map(|_| random.unit());
        for _ in 0..3 {
            let d = random.direction();
            let mut p = [0, 1, 2].map(|a| (at[a] + 0.2 * d[a]) as f32);
            if i % 3 == 0 {
                p[i % 2] = at[i % 2] as f32;
            }
            mesh.positions.push(p);
        }
        mesh.triangles.push([3 * i as u32, 3 * i as u32 + 1, 3 * i as u32 + 2]);
    }
    let moved = Affine { rows: [[0.0, -1.5, 0.0, 2.0], [1.5, 0.0, 0.0, 0.3], [0.0, 0.0, 1.5, -0.25]] };
    let place = |transform| Instance { mesh: 0, transform, node: 0, name: String::new() };
    Scene { meshes: vec![mesh], instances: vec![place(Affine::IDENTITY), place(moved)], ..Scene::default() }
}

fn bits(rays: &[Ray]) -> String {
    let mut hasher = blake3::Hasher::new();
    for ray in rays {
        let numbers = ray.origin.iter().chain(&ray.direction).chain([&ray.t_min, &ray.t_max]);
        numbers.for_each(|v| _ = hasher.update(&v.to_le_bytes()));
    }
    hasher.finalize().to_hex()[..16].to_string()
}

#[test]
fn a_seed_always_gives_the_same_bits() {
    let scene = scene();
    let sampler = Sampler::new(&scene);
    let found: Vec<(&str, String)> = RaySet::ALL.map(|set| (set.name(), bits(&sampler.rays(set, 500, 42)))).into();
    let expected = [
        ("camera", "0f71f694eb3a23b4"),
        ("uniform", "e2effe6fe533c86d"),
        ("surface", "512c71b10753f6d1"),
        ("bounce", "921cc3eccdd2de71"),
        ("shadow", "3494e0036b1abd01"),
        ("triangles", "c5e724832dc9d411"),
        ("vertices", "725d991e4064893e"),
        ("edges", "9a4a5781a7f437ab"),
        ("axis", "de8a7301e84b4182"),
        ("planes", "d38942f9ce2cc9cc"),
        ("nested", "985886cba441d3f4"),
        ("far", "6a2b8be1944c9f04"),
        ("grid", "aba9424f784b8c02"),
    ];
    assert_eq!(found, expected.map(|(name, hash)| (name, hash.to_string())));
}

#[test]
fn every_ray_can_be_traced_whatever_the_scene() {
    let (scene, empty) = (scene(), Scene::default());
    let point = Scene {
        meshes: vec![Mesh { positions: vec![[1.0; 3]], triangles: vec![[0; 3]], ..Mesh::default() }],
        instances: vec![Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() }],
        ..Scene::default()
    };
    for scene in [&scene, &empty, &point] {
        for set in RaySet::ALL {
            for ray in Sampler::new(scene).rays(set, 300, 5) {
                assert!(ray.origin.iter().chain(&ray.direction).all(|v| v.is_finite()), "{set:?} {ray:?}");
                assert!(ray.direction.iter().any(|d| *d != 0.0) && ray.t_min <= ray.t_max, "{set:?} {ray:?}");
            }
        }
    }
}

/// How many of a hundred rays of a set pass a corner or an edge of the first instance exactly.
fn exact_aims(set: RaySet) -> usize {
    let mut scene = scene();
    scene.instances.truncate(1);
    let mesh = &scene.meshes[0];
    let rays = Sampler::new(&scene).rays(set, 400, 3);
    let touches = |ray: &&Ray| {
        (0..mesh.triangles.len())
            .filter_map(|i| meet(ray, mesh.corners(i)))
            .any(|m| [&m.u, &m.v, &m.w].into_iter().any(|weight| weight.compare(0.0) == Some(Ordering::Equal)))
    };
    rays.iter().filter(touches).count() / 4
}

#[test]
fn targets_are_what_rays_are_aimed_at() {
    let mut scene = scene();
    scene.instances.truncate(1);
    let sampler = Sampler::new(&scene);
    let (rays, targets) = (sampler.rays(RaySet::Triangles, 400, 3), sampler.targets(RaySet::Triangles, 400, 3));
    assert_eq!(rays.len(), targets.len());
    let is_met = |ray: &Ray, target: &Source| meet(ray, scene.meshes[0].corners(target.triangle as usize)).is_some();
    let met = rays.iter().zip(&targets).filter(|(ray, target)| target.instance == 0 && is_met(ray, target)).count();
    assert!(met > 380, "{met}");
    assert!(sampler.targets(RaySet::Camera, 4, 3).is_empty());
    assert!(Sampler::new(&Scene::default()).targets(RaySet::Triangles, 4, 3).is_empty());
}

#[test]
fn many_aims_are_exact() {
    assert!(exact_aims(RaySet::Vertices) > 30, "{}", exact_aims(RaySet::Vertices));
    assert!(exact_aims(RaySet::Edges) > 5, "{}", exact_aims(RaySet::Edges));
}

#[test]
fn sets_are_what_they_say() {
    let scene = scene();
    let sampler = Sampler::new(&scene);
    let rays = |set| sampler.rays(set, 400, 8);
    assert!(rays(RaySet::Axis).iter().all(|r| r.direction.iter().filter(|d| **d == 0.0).count() == 2));
    assert!(rays(RaySet::Planes).iter().all(|r| r.direction.contains(&0.0)));
    assert!(rays(RaySet::Grid).iter().all(|r| r.direction.iter().all(|d| d.fract() == 0.0 && d.abs() <= 8.0)));
    assert!(rays(RaySet::Surface).iter().all(|r| r.t_min == 0.0 && r.t_max == f32::INFINITY));
    assert!(rays(RaySet::Shadow).iter().all(|r| r.t_max < f32::INFINITY && r.t_min > 0.0));
    let distance = |r: &Ray| sub(r.origin.map(f64::from), sampler.center).map(|c| c * c).iter().sum::<f64>().sqrt();
    assert!(rays(RaySet::Far).iter().all(|r| distance(r) > 1900.0 * sampler.radius()));
    assert!(rays(RaySet::Far).iter().any(|r| distance(r) > 1.9e7 * sampler.radius()));
    assert!(rays(RaySet::Nested).iter().all(|r| distance(r) <= 1.001 * sampler.radius()));
    assert!(rays(RaySet::Camera).iter().any(|r| distance(r) > 1.9 * sampler.radius()));
    assert!(rays(RaySet::Camera).iter().any(|r| distance(r) < sampler.radius()));
}
