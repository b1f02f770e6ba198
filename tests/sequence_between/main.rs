//! Rays between two frames of a sequence find what brute force over the moved triangles finds, and at the frames' own times what the frames hold.

mod brute;
mod clips;
#[path = "../common/mod.rs"]
mod common;
mod refuse;

use brute::{Moved, Tally, compare};
use bvhc::build::{BuildOptions, Executor, NoProgress};
use bvhc::cache::{
    Between, CacheError, Codec, Frames, InstanceRecord, Meta, OpenOptions, Sequence, Validation, tree_flags,
};
use bvhc::geom::{Affine, Mix, Point, Ray};
use bvhc::random::Random;
use bvhc::scene::{Instance, Mesh, Scene};
use bvhc::sequence::{FrameLabel, Refit, RefitPolicy, SequenceBuilder};
use bvhc::trace::{Hit, closest_hit};
use common::vectors::sequences as vectors;
use std::path::Path;

fn build(frames: Vec<Scene>, codec: Codec) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sequence.bvhc");
    write(&path, frames, codec);
    std::fs::read(path).unwrap()
}

/// One topology for each mesh, whatever its motion does to the tree.
fn write(path: &Path, frames: Vec<Scene>, codec: Codec) {
    let policy = RefitPolicy { refit: Refit::Always, ..RefitPolicy::default() };
    let exec = Executor::current();
    let mut builder = SequenceBuilder::new(path, &BuildOptions::default(), policy, codec, &exec, &NoProgress).unwrap();
    for (i, scene) in frames.into_iter().enumerate() {
        let label = FrameLabel { number: 10 + i as i32, time: Some(i as f32 / 24.0), held: false };
        builder.add(scene, label).unwrap();
    }
    builder.finish(&Meta::default()).unwrap();
}

fn open(bytes: &[u8], validation: Validation) -> Frames<'_> {
    Sequence::from_slice(bytes, &OpenOptions { validation, ..OpenOptions::default() }).unwrap()
}

/// About the origin, by an angle and a scale.
fn turned(angle: f64, scale: f64, at: [f64; 3]) -> Affine {
    let (s, c) = (scale * angle.sin(), scale * angle.cos());
    Affine { rows: [[c, 0.3 * s, -s, at[0]], [0.0, scale, 0.1, at[1]], [s, 0.0, c, at[2]]] }
}

/// A ball that bulges and drifts, shown three times: standing, turning as it moves, and mirrored and sheared.
fn party(time: f64) -> Scene {
    let ball = common::meshes::cube(4, |p| {
        let length = p.iter().map(|c| c * c).sum::<f64>().sqrt();
        let bulge = 1.0 + 0.4 * (3.0 * p[0] + 5.0 * time).sin() * (2.0 * p[1] - 3.0 * time).cos();
        [0, 1, 2].map(|k| (p[k] / length * bulge + [0.7 * time, 0.1, -time][k]) as f32)
    });
    let shear = Affine { rows: [[-1.0 - time, 0.2, 0.0, 4.0], [0.1, 1.0, time, 0.0], [0.0, 0.0, 0.5, 1.0]] };
    let places = [Affine::IDENTITY, turned(time, 1.0 + 0.5 * time, [0.0, 3.0 + time, 0.5]), shear];
    let mut scene = common::meshes::place(ball, &places);
    let block = common::meshes::cube(2, |p| [p[0] as f32 * 0.5 - 4.0, p[1] as f32, p[2] as f32]);
    scene.meshes.push(common::meshes::scene_of(block).meshes.remove(0));
    // It moves as a whole, and so is stored once.
    let transform = turned(-2.0 * time, 1.0, [time, -time, 0.0]);
    scene.instances.push(Instance { mesh: 1, transform, node: 1, name: String::new() });
    scene
}

fn party_frames() -> Vec<Scene> {
    [0.0, 0.3, 0.45, 0.9].map(party).to_vec()
}

/// Every pair of neighbours, at so many random times, with so many rays each.
fn play(sequence: &Frames<'_>, times: usize, rays: usize, seed: u64) -> Tally {
    let (mut random, mut tally) = (Random::new(seed), Tally::default());
    for first in 0..sequence.frame_count().saturating_sub(1) {
        let between = sequence.between(first, first + 1).unwrap();
        for _ in 0..times {
            compare(&Moved::new(&between, random.unit() as f32), rays, &mut random, &mut tally);
        }
    }
    tally
}

#[test]
fn rays_at_random_times_find_what_brute_force_finds() {
    let bytes = build(party_frames(), Codec::Raw);
    for validation in [Validation::Quick, Validation::Tree] {
        let tally = play(&open(&bytes, validation), 60, 60, 7);
        assert!(tally.rays == 3 * 60 * 60 && tally.hits * 10 > tally.rays * 8, "{tally:?}");
        assert!(tally.sure * 2 > tally.rays, "{tally:?}");
    }
    // Every time is asked of an interval that skips frames, and of one that goes back.
    let sequence = open(&bytes, Validation::Hash);
    let (mut random, mut tally) = (Random::new(3), Tally::default());
    for (first, second) in [(0, 3), (2, 0), (1, 1)] {
        let between = sequence.between(first, second).unwrap();
        for _ in 0..40 {
            compare(&Moved::new(&between, random.unit() as f32), 40, &mut random, &mut tally);
        }
    }
    assert!(tally.hits * 10 > tally.rays * 8, "{tally:?}");
}

/// Where coordinates are so large or so small that rounding is at its worst, and where the two ends lie far apart.
#[test]
fn extreme_motions_lose_no_ray() {
    let scales: [[f32; 2]; 5] = [[1e-30, 1e-30], [1e18, 1e18], [1.0, 1e7], [1e-20, 1e10], [3.0, 3.000_001]];
    for (i, scales) in scales.into_iter().enumerate() {
        let mut sequence = vectors::Sequence::default();
        let mesh = vectors::grid(6);
        let topology = sequence.add_topology(&mesh, &common::vectors::scenes::tree(&mesh, 2));
        for (number, scale) in (0..).zip(scales) {
            let wave = vectors::wave(6, 0.25 + 0.5 * number as f32);
            let positions: Vec<Point> = wave.iter().map(|p| p.map(|c| (c - 1.7) * scale)).collect();
            let pose = sequence.add_pose(topology, &positions, false);
            let placement = sequence.add_placement(&[(pose, Affine::IDENTITY)]);
            sequence.add_frame(number, None, placement);
        }
        let bytes = sequence.file();
        let opened = open(&bytes, Validation::Tree);
        let between = opened.between(0, 1).unwrap();
        let (mut random, mut hits) = (Random::new(11 + i as u64), 0);
        for _ in 0..120 {
            let moved = Moved::new(&between, random.unit() as f32);
            for _ in 0..40 {
                let ray = moved.some_ray(&mut random);
                let hit = between.closest_hit(&ray, moved.fraction).unwrap();
                assert_eq!(hit, moved.exactly(&ray), "{scales:?} {ray:?} at {}", moved.fraction);
                hits += usize::from(hit.is_some());
            }
        }
        assert!(hits > 3000, "{scales:?}: {hits}");
    }
}

/// A hit of a frame as an interval tells of it: with rows of the file.
fn told(sequence: &Frames<'_>, frame: &bvhc::cache::Frame<'_>, hit: Hit) -> Hit {
    let view = frame.view();
    let instance = view.instances.iter().find(|i| Some(i.id) == hit.instance).unwrap();
    let pose = sequence.poses()[frame.poses()[instance.blas as usize] as usize];
    let slot = hit.triangle - view.blases[instance.blas as usize].ref_offset as usize;
    let triangle = sequence.topologies()[pose.topology as usize].ref_offset as usize + slot;
    Hit { geom: frame.parts()[hit.geom as usize], triangle, ..hit }
}

/// A hit with its floats as bits.
fn bits(hit: Option<Hit>) -> Option<([u32; 3], Hit)> {
    hit.map(|h| ([h.t, h.u, h.v].map(f32::to_bits), Hit { t: 0.0, u: 0.0, v: 0.0, ..h }))
}

#[test]
fn at_its_ends_an_interval_is_the_frames_themselves() {
    let bytes = build(party_frames(), Codec::Raw);
    let sequence = open(&bytes, Validation::Hash);
    let mut random = Random::new(5);
    for ends in [[0, 1], [3, 1], [2, 2]] {
        let between = sequence.between(ends[0], ends[1]).unwrap();
        for (fraction, index) in [(0.0, ends[0]), (1.0, ends[1])] {
            let (frame, moved) = (sequence.frame(index).unwrap(), Moved::new(&between, fraction));
            let mut hits = 0;
            for _ in 0..2000 {
                let ray = moved.some_ray(&mut random);
                let want = closest_hit(&frame.view(), &ray).unwrap().map(|hit| told(&sequence, &frame, hit));
                let got = between.closest_hit(&ray, fraction).unwrap();
                assert_eq!(bits(got), bits(want), "{ray:?} of frame {index}");
                hits += usize::from(got.is_some());
            }
            assert!(hits > 1500, "{hits}");
        }
        let ray = Moved::new(&between, 0.0).some_ray(&mut random);
        for beyond in [-1e-20, 1.0f32.next_up(), f32::NAN, f32::INFINITY] {
            assert_eq!(between.closest_hit(&ray, beyond), Ok(None));
            assert_eq!(between.any_hit(&ray, beyond), Ok(false));
        }
    }
}

#[test]
fn packed_files_and_many_rays_at_once_give_the_same() {
    let (raw, packed) = (build(party_frames(), Codec::Raw), build(party_frames(), Codec::Zstd { level: 3 }));
    assert!(packed.len() < raw.len());
    let sequences = [open(&raw, Validation::Hash), open(&packed, Validation::Tree)];
    let [a, b] = [0, 1].map(|i| sequences[i].between(1, 2).unwrap());
    let (moved, mut random) = (Moved::new(&a, 0.5), Random::new(9));
    let rays: Vec<(Ray, f32)> = (0..3000).map(|_| (moved.some_ray(&mut random), random.unit() as f32)).collect();
    let [mut ours, mut theirs] = [(); 2].map(|()| vec![None; rays.len()]);
    a.closest_hits(&rays, &mut ours, &Executor::new(3).unwrap()).unwrap();
    b.closest_hits(&rays, &mut theirs, &Executor::sequential()).unwrap();
    assert_eq!(ours, theirs);
    for ((ray, fraction), hit) in rays.iter().zip(&ours) {
        assert_eq!(a.closest_hit(ray, *fraction), Ok(*hit));
    }
    assert!(a.closest_hits(&rays[1..], &mut ours, &Executor::sequential()).is_err());

    // Unpacked poses count against the limit.
    let options = OpenOptions { max_memory: 12 << 10, ..OpenOptions::default() };
    let small = Sequence::from_slice(&packed, &options).unwrap();
    assert!(matches!(small.between(1, 2), Err(CacheError::Limit { .. })));
}

#[test]
fn a_normal_is_that_of_the_moved_triangle() {
    let bytes = build(party_frames(), Codec::Raw);
    let sequence = open(&bytes, Validation::Hash);
    let between = sequence.between(0, 1).unwrap();
    let (moved, mut random) = (Moved::new(&between, 0.4), Random::new(21));
    for _ in 0..300 {
        let ray = moved.some_ray(&mut random);
        let Some(hit) = between.closest_hit(&ray, 0.4).unwrap() else { continue };
        let record = between.instance_record(hit.instance.unwrap()).unwrap();
        let instance = &between.instances()[record];
        let tree = between.tree(instance.tree as usize).unwrap();
        let map = instance.object_to_world(&moved.mix);
        let corners = tree.at(&tree.triangles[hit.triangle - tree.first_triangle], &moved.mix).corners();
        let [a, b, c] = corners.map(|p| map.transform_point(p.map(f64::from)));
        let normal = between.normal(&hit, 0.4).unwrap();
        let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
        for along in [[0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k])] {
            let lean = (0..3).map(|k| along[k] * normal[k] / length).sum::<f64>();
            assert!(lean.abs() < 1e-5, "{lean}");
        }
        // The balls are closed and seen from the front by whoever stands outside; `t` decides which side that is.
        assert!(length > 0.0 && between.normal(&hit, 1.5).is_none());
        assert!(between.normal(&Hit { triangle: usize::MAX, ..hit }, 0.4).is_none());
    }
}

/// In a tree with spatial splits leaves hold parts of triangles, and interpolated parts are not parts of what is interpolated.
#[test]
fn split_trees_are_fitted_to_whole_triangles() {
    let sequence = vectors::origins();
    let bytes = sequence.file();
    let opened = open(&bytes, Validation::Tree);
    assert!(opened.topologies()[0].flags & tree_flags::DUP_REFS != 0);
    let (mut random, mut tally) = (Random::new(2), Tally::default());
    for (first, second) in [(0, 1), (1, 0), (0, 0)] {
        let between = opened.between(first, second).unwrap();
        for _ in 0..50 {
            compare(&Moved::new(&between, random.unit() as f32), 40, &mut random, &mut tally);
        }
        let tree = between.tree(0).unwrap();
        for (end, vertices) in tree.vertices.iter().enumerate() {
            for node in tree.nodes[end].iter().filter(|node| node.is_leaf() && first != second) {
                let some = &tree.triangles[node.first as usize..][..node.count as usize];
                let corners = some.iter().flat_map(|t| t.corners).map(|v| vertices[v as usize]).collect::<Vec<_>>();
                assert_eq!(node.bounds(), bvhc::geom::Aabb::from_points(&corners));
            }
        }
    }
    assert!(tally.hits * 10 > tally.rays * 6, "{tally:?}");
}

/// By half a turn, linearly: in the middle the ball is a needle, and has no inside.
#[test]
fn an_instance_that_goes_through_a_plane_is_not_there_at_that_moment() {
    let ball = || common::meshes::sphere(4, 1.0, [0.0; 3]);
    let half = Affine { rows: [[-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
    let mirror = Affine { rows: [[1.0, 0.0, 0.0, 5.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0]] };
    let standing = Affine::translation([5.0, 0.0, 0.0]);
    let frames = vec![
        common::meshes::place(ball(), &[Affine::IDENTITY, standing]),
        common::meshes::place(ball(), &[half, mirror]),
    ];
    let bytes = build(frames, Codec::Raw);
    let sequence = open(&bytes, Validation::Tree);
    let between = sequence.between(0, 1).unwrap();
    let rays = [0.0, 5.0].map(|x| Ray::new([x + 0.01, 0.02, -9.0], [0.0, 0.0, 1.0]));
    for ray in &rays {
        assert!(between.any_hit(ray, 0.0).unwrap() && between.any_hit(ray, 0.25).unwrap());
        assert!(!between.any_hit(ray, 0.5).unwrap());
    }
    let (mut random, mut tally) = (Random::new(8), Tally::default());
    for fraction in [0.1, 0.49, 0.499_9, 0.5, 0.500_1, 0.51, 0.9, 1.0] {
        let moved = Moved::new(&between, fraction);
        for _ in 0..200 {
            let ray = moved.some_ray(&mut random);
            let hit = between.closest_hit(&ray, fraction).unwrap();
            assert_eq!(bits(hit), bits(moved.exactly(&ray)), "{ray:?} at {fraction}");
            tally.hits += usize::from(hit.is_some());
        }
    }
    assert!(tally.hits > 1000, "{tally:?}");
}

/// Mesh and instance turn over at once: on the way the ball is far from where it is at both ends, where alone the frames have boxes for it.
#[test]
fn what_leaves_the_hull_of_its_ends_is_found() {
    let frame = |x: f64| {
        let ball = common::meshes::sphere(4, 1.0, [x, 0.0, 0.0]);
        let map = Affine { rows: [[-0.2 * x, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
        common::meshes::place(ball, &[map])
    };
    let bytes = build(vec![frame(-5.0), frame(5.0)], Codec::Raw);
    let sequence = open(&bytes, Validation::Tree);
    let between = sequence.between(0, 1).unwrap();
    let below = |x: f32| Ray::new([x, 0.01, -9.0], [0.0, 0.0, 1.0]);
    assert!([0.0, 1.0].iter().all(|end| between.any_hit(&below(-5.0), *end).unwrap()));
    assert!(between.any_hit(&below(-0.21), 0.4).unwrap() && !between.any_hit(&below(-5.0), 0.4).unwrap());
    let (mut random, mut tally) = (Random::new(17), Tally::default());
    for _ in 0..50 {
        compare(&Moved::new(&between, random.unit() as f32), 50, &mut random, &mut tally);
    }
    assert!(tally.hits * 10 > tally.rays * 6, "{tally:?}");
}

#[test]
fn a_moment_is_found_by_its_time_and_by_its_number() {
    let bytes = build(party_frames(), Codec::Raw);
    let sequence = open(&bytes, Validation::Hash);
    let moment = sequence.at(1.5 / 24.0).unwrap();
    assert_eq!((moment.first, moment.second), (1, 2));
    assert!((moment.fraction - 0.5).abs() < 1e-6);
    let between: Between<'_> = sequence.between(moment.first, moment.second).unwrap();
    assert_eq!(between.fraction(1.5 / 24.0), Some(moment.fraction));
    assert_eq!(between.frames().map(|frame| frame.number), [11, 12]);
    assert_eq!((between.fraction(3.0 / 24.0), sequence.at(4.0 / 24.0)), (None, None));
    assert_eq!(sequence.at_number(12.25).map(|m| (m.first, m.second, m.fraction)), Some((2, 3, 0.25)));
}

/// Matrices that are exchanged between two records are no concern of a box: instances are found by number, wherever the leaves put them.
#[test]
fn instances_are_matched_by_number_and_not_by_place() {
    let bytes = build(party_frames(), Codec::Raw);
    let sequence = open(&bytes, Validation::Hash);
    for (first, second) in [(0, 3), (3, 0)] {
        let between = sequence.between(first, second).unwrap();
        let frames = [first, second].map(|frame| sequence.frame(frame).unwrap());
        for instance in between.instances() {
            for (end, frame) in instance.ends.iter().zip(&frames) {
                let like = |record: &InstanceRecord| (record.id, record.object_to_world, record.world_to_object);
                assert!(frame.view().instances.iter().any(|other| like(other) == like(end)));
            }
            assert_eq!(instance.ends[0].id, instance.ends[1].id);
        }
        assert_eq!(between.tree_count(), 2, "the ball is one tree, and the block another");
        // The block's pose is one, and its boxes stay what they are.
        let block = between.instances().iter().find(|i| i.ends[0].blas == i.ends[1].blas).unwrap();
        let tree = between.tree(block.tree as usize).unwrap();
        assert_eq!(tree.nodes[0].as_ptr(), tree.nodes[1].as_ptr());
        assert_eq!(Mix::new(0.3).unwrap().point(tree.vertices[0][0], tree.vertices[1][0]), tree.vertices[0][0]);
    }
}

/// What stands still is no reason to move: a mesh of one pose does not tremble with the time.
#[test]
fn what_stands_still_is_hit_the_same_at_every_time() {
    let still = |lift: f64| {
        let mesh = common::meshes::sphere(4, 0.37, [0.1, 0.2, 0.3]);
        let mut scene = common::meshes::place(mesh, &[turned(0.7, 1.3, [0.3, 0.0, 0.0])]);
        let other: Mesh = common::meshes::sphere(2, 0.2, [9.0, lift, 0.0]);
        scene.meshes.push(common::meshes::scene_of(other).meshes.remove(0));
        scene.instances.push(Instance { mesh: 1, transform: Affine::IDENTITY, node: 1, name: String::new() });
        scene
    };
    let bytes = build(vec![still(0.0), still(1.0)], Codec::Raw);
    let sequence = open(&bytes, Validation::Hash);
    let between = sequence.between(0, 1).unwrap();
    let (moved, mut random) = (Moved::new(&between, 0.0), Random::new(31));
    let mut hits = 0;
    for _ in 0..2000 {
        let ray = moved.some_ray(&mut random);
        let Some(hit) = between.closest_hit(&ray, 0.0).unwrap().filter(|hit| hit.instance == Some(0)) else { continue };
        let time = random.unit() as f32;
        let again = between.closest_hit(&ray, time).unwrap();
        assert!(again.is_some_and(|h| h == hit || h.instance == Some(1)), "{ray:?} at {time}");
        hits += 1;
    }
    assert!(hits > 500, "{hits}");
}
