//! That leaves cover the triangles that were cut: proved for what the builders make, in few steps.

use std::collections::BTreeMap;

use bvhc::build::{BuildOptions, Method, NoProgress};
use bvhc::cache::check::{Limits, check_image};
use bvhc::cache::{Image, TriangleRecord};
use bvhc::compile::build_tree;
use bvhc::exec::Executor;
use bvhc::geom::{Aabb, Point};
use bvhc::scene::Mesh;
use bvhc_core::cache::parts::{Cover, Covered};

fn mesh_of(triangles: impl Iterator<Item = [Point; 3]>) -> Mesh {
    let positions: Vec<Point> = triangles.flatten().collect();
    let corners = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh::new("", positions, corners).unwrap()
}

/// Numbers without a pattern between 0 and 1.
fn at(i: u32, k: u32) -> f32 {
    let mut z = (u64::from(i) << 32 | u64::from(k)).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
}

fn point(i: u32, k: u32) -> Point {
    [at(i, k), at(i, k + 1), at(i, k + 2)]
}

/// Scenes of which spatial splits cut up nearly everything.
fn scenes(count: u32) -> [(&'static str, Mesh); 4] {
    let sliver = |i| {
        let (a, b) = (point(i, 0), point(i, 3));
        [a, b, [a[0] + 1e-3, a[1], a[2] + 1e-4]]
    };
    let spanning =
        |i: u32| [[0.0, at(i, 0), at(i, 1)], [1.0, at(i, 2), at(i, 3)], [at(i, 4), at(i, 5), (i % 2) as f32]];
    let axis = |i: u32| {
        // Walls and floors: many planes of boxes are planes of triangles.
        let mut t = [point(i, 0), point(i, 3), point(i, 6)];
        let k = (i % 3) as usize;
        t.iter_mut().for_each(|p| p[k] = ((i / 3) % 8) as f32 / 8.0);
        t
    };
    [
        ("slivers", mesh_of((0..count).map(sliver))),
        ("spanning", mesh_of((0..count).map(spanning))),
        ("axis-aligned", mesh_of((0..count).map(axis))),
        ("identical", mesh_of((0..count).map(|_| [[0.0; 3], [1.0, 0.25, 0.0], [0.0, 1.0, 0.5]]))),
    ]
}

/// The leaves of each triangle that has several.
fn leaves_of_cut_triangles(image: &Image) -> Vec<([Point; 3], Vec<Aabb>)> {
    let mut groups: BTreeMap<u32, ([Point; 3], Vec<Aabb>)> = BTreeMap::new();
    for node in image.nodes.iter().enumerate().filter(|(i, n)| *i != 1 && n.is_leaf()).map(|(_, n)| n) {
        for t in &image.triangles[node.first as usize..][..node.count as usize] {
            if t.flags & TriangleRecord::DUPLICATED != 0 {
                groups.entry(t.prim).or_insert((t.corners(), Vec::new())).1.push(node.bounds());
            }
        }
    }
    groups.into_values().collect()
}

#[test]
fn what_is_built_is_covered_and_proved_in_few_steps() {
    let exec = Executor::sequential();
    for (name, mesh) in scenes(3000) {
        let methods = [
            BuildOptions { method: Method::Sbvh, split_budget: 4.0, ..BuildOptions::default() },
            BuildOptions { method: Method::Binned, presplit: 2.0, ..BuildOptions::default() },
        ];
        for options in methods {
            let tree = build_tree(&mesh, &options, &exec, &NoProgress).unwrap();
            let image = Image::of_tree(&mesh, &tree, &exec).unwrap();
            let report = check_image(&image, &Limits::default(), &exec);
            assert!(report.is_clean(), "{name}: {:?}", report.findings.first());
            let groups = leaves_of_cut_triangles(&image);
            let mut cover = Cover::default();
            let mut copies = 0;
            for (corners, boxes) in &groups {
                copies += boxes.len() as u64;
                assert_eq!(cover.look(*corners, boxes), Covered::Whole, "{name}: {corners:?}");
            }
            let most = groups.iter().map(|g| g.1.len()).max().unwrap_or(0);
            let steps = cover.steps() as f64 / copies.max(1) as f64;
            println!("{name} {}: {copies} copies, at most {most} of one, {steps:.1} steps a copy", options.method);
            assert!(cover.steps() <= 40 * copies, "{name}: {} steps for {copies} copies", cover.steps());
        }
    }
}

/// Every leaf is needed: where one box loses a step on a side that the triangle crosses, a hole is found.
#[test]
fn a_box_a_step_too_small_is_found_in_what_is_built() {
    let exec = Executor::sequential();
    let (_, mesh) = &scenes(400)[1];
    let options = BuildOptions { method: Method::Sbvh, split_budget: 4.0, ..BuildOptions::default() };
    let tree = build_tree(mesh, &options, &exec, &NoProgress).unwrap();
    let image = Image::of_tree(mesh, &tree, &exec).unwrap();
    let (mut cover, mut tried, mut found) = (Cover::default(), 0, 0);
    for (corners, boxes) in leaves_of_cut_triangles(&image) {
        // Corners of the triangle that only one leaf holds, in its upper side.
        for axis in 0..3 {
            let corner = (0..3).max_by(|a, b| corners[*a][axis].total_cmp(&corners[*b][axis])).unwrap();
            let holds = |b: &Aabb| b.contains(&Aabb { min: corners[corner], max: corners[corner] });
            let only: Vec<usize> = (0..boxes.len()).filter(|i| holds(&boxes[*i])).collect();
            let &[i] = &only[..] else { continue };
            if boxes[i].max[axis] != corners[corner][axis] || boxes[i].min[axis] == boxes[i].max[axis] {
                continue;
            }
            tried += 1;
            let mut smaller = boxes.clone();
            smaller[i].max[axis] = smaller[i].max[axis].next_down();
            found += usize::from(matches!(cover.look(corners, &smaller), Covered::Hole(_)));
        }
    }
    assert!(tried > 100 && found == tried, "{found} of {tried}");
}
