//! Files that nobody looked into: headers, tables and hashes are right, records are not. A ray through them ends without a panic.

use bvhc::build::{BuildOptions, Executor, Levels, NoProgress, Preset};
use bvhc::cache::{Cache, Image, Meta, OpenOptions, SectionEntry, SectionKind, Validation, WriteOptions, to_bytes};
use bvhc::compile;
use bvhc::geom::{Affine, Ray};
use bvhc::scene::{Instance, Mesh, Part, Scene};

use crate::refuse::sign;

/// Small numbers without a pattern, the same on every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (((self.0 >> 32) * u64::from(n)) >> 32) as u32
    }

    fn unit(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }
}

/// Straws in all directions, which makes deep trees with duplicates; three instances.
fn file(levels: Levels) -> Vec<u8> {
    let mut random = Random(7);
    let mut mesh = Mesh { name: "straws".into(), ..Mesh::default() };
    for i in 0..400 {
        let at = [0; 3].map(|_| random.unit());
        let end = [0; 3].map(|_| random.unit());
        mesh.positions.extend([at, end, at.map(|x| x + 0.02)]);
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh.parts = vec![Part { triangle_count: 400, prim_count: 400, ..Part::default() }];
    let moved = |x: f64| Affine { rows: [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
    let place = |x: f64| Instance { mesh: 0, transform: moved(x), node: 0, name: String::new() };
    let scene = Scene { meshes: vec![mesh], instances: [0.0, 0.3, 0.6].map(place).into(), ..Scene::default() };
    let options = BuildOptions { levels, ..BuildOptions::preset(Preset::Best) };
    let accel = compile::compile(scene, &options, &Executor::sequential(), &NoProgress).unwrap();
    to_bytes(
        &Image::new(&accel, &Executor::current()).unwrap(),
        &Meta::default(),
        &WriteOptions::default(),
        &Executor::current(),
    )
    .unwrap()
}

#[test]
fn a_ray_through_damaged_records_ends() {
    let mut random = Random(1);
    let (mut answers, mut malformed) = (0, 0);
    for levels in [Levels::One, Levels::Two] {
        let whole = file(levels);
        let entries: Vec<SectionEntry> =
            whole[256..][..128 * 6].chunks(128).map(bytemuck::pod_read_unaligned).collect();
        let kinds = [SectionKind::NODE, SectionKind::BLAS, SectionKind::TNOD, SectionKind::INST, SectionKind::TRIS];
        let places: Vec<&SectionEntry> = entries.iter().filter(|e| kinds.contains(&e.kind)).collect();
        for _ in 0..1500 {
            // Write numbers that look like indices and counts, and some that look like nothing.
            let mut file = whole.clone();
            for _ in 0..=random.below(12) {
                let entry = places[random.below(places.len() as u32) as usize];
                let at = entry.offset as usize + 4 * random.below(entry.raw_len as u32 / 4) as usize;
                let value = match random.below(5) {
                    0 => 0,
                    1 => 2 * random.below(40),
                    2 => random.below(1200),
                    3 => f32::to_bits([f32::NAN, f32::INFINITY, -0.0, 1e38][random.below(4) as usize]),
                    _ => random.below(u32::MAX),
                };
                file[at..at + 4].copy_from_slice(&value.to_le_bytes());
            }
            sign(&mut file);
            for validation in [Validation::Quick, Validation::Hash] {
                let options = OpenOptions { validation, ..OpenOptions::default() };
                let cache = Cache::from_bytes(&file, &options).expect("the container is whole");
                for _ in 0..4 {
                    let origin = [0; 3].map(|_| random.unit() * 3.0 - 1.0);
                    let ray = Ray::new(origin, [0, 1, 2].map(|axis| 0.5 - origin[axis]));
                    match cache.closest_hit(&ray) {
                        Ok(_) => answers += 1,
                        Err(_) => malformed += 1,
                    }
                    _ = cache.any_hit(&ray);
                }
                (0..3).for_each(|i| _ = cache.names().get(i));
            }
        }
    }
    assert!(answers > 1000 && malformed > 1000, "{answers} answers, {malformed} malformed");
}

/// Leaves may overlap in such a file. If each were followed, 8 KiB of nodes would stand for 255 times its triangles.
#[test]
fn overlapping_leaves_are_malformed_before_they_cost_anything() {
    let mut file = file(Levels::One);
    let entries: Vec<SectionEntry> = file[256..][..128 * 6].chunks(128).map(bytemuck::pod_read_unaligned).collect();
    let nodes = entries.iter().find(|e| e.kind == SectionKind::NODE).unwrap();
    for i in (0..nodes.elem_count as usize).filter(|i| *i != 1) {
        let node = &mut file[nodes.offset as usize + 32 * i..][..32];
        node[0..12].copy_from_slice(bytemuck::bytes_of(&[-9.0f32; 3]));
        node[16..28].copy_from_slice(bytemuck::bytes_of(&[9.0f32; 3]));
        if node[28..32] != [0; 4] {
            node[12..16].copy_from_slice(&0u32.to_le_bytes());
            node[28..32].copy_from_slice(&255u32.to_le_bytes());
        }
    }
    sign(&mut file);
    let quick = OpenOptions { validation: Validation::Quick, ..OpenOptions::default() };
    let cache = Cache::from_bytes(&file, &quick).unwrap();
    assert!(cache.closest_hit(&Ray::new([20.0, 20.0, 20.0], [-1.0, -1.0, -1.0])).is_err());
}
