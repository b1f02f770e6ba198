//! The table of options says which methods read an option. Here each method is held to it: it builds another tree with another value of
//! an option that it reads, and the same tree with any value of an option that it does not.

use bvhc::build::{BuildOptions, Executor, Kind, METHODS, NoProgress, OPTIONS, OptionInfo, Preset};
use bvhc::compile::compile;
use bvhc::geom::Affine;
use bvhc::scene::{Instance, Mesh, Part, Scene};
use bvhc::trace::rays::Random;
use bvhc::tree::Tree;

/// A mesh in two places: small triangles with long thin ones across, so that every step of every method has something to do.
fn scene() -> Scene {
    let mut random = Random::new(11);
    let mut mesh = Mesh::default();
    for i in 0..700u32 {
        let at = [0; 3].map(|_| random.unit() * 10.0);
        let size = if i % 7 == 0 { 6.0 } else { 0.4 };
        let thin = if i % 14 == 0 { 0.02 } else { 1.0 };
        for corner in [0.0, 1.0, thin] {
            mesh.positions.push(at.map(|v| (v + corner * (random.unit() - 0.5) * size) as f32));
        }
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    let count = mesh.triangles.len() as u32;
    mesh.parts = vec![Part { triangle_count: count, prim_count: count, ..Part::default() }];
    let moved = Affine { translation: [20.0, 0.0, 0.0], ..Affine::IDENTITY };
    let place = |transform| Instance { mesh: 0, transform, node: 0, name: String::new() };
    Scene { meshes: vec![mesh], instances: vec![place(Affine::IDENTITY), place(moved)], ..Scene::default() }
}

fn build(options: &BuildOptions) -> (Vec<Tree>, Option<Tree>) {
    let accel = compile(scene(), options, &Executor::new(2).unwrap(), &NoProgress).unwrap();
    (accel.blases, accel.tlas)
}

/// Values all over the range, but no large ones where a count costs time or memory.
fn values(row: &OptionInfo) -> Vec<String> {
    let texts = match row.kind {
        Kind::Count(least, _) => [least, least + 1, least + 3, 20, 300].map(|n| n.to_string()).to_vec(),
        Kind::Real(least, most) => [least, 0.02, 0.3, 1.0, 5.0, most.min(100.0)].map(|v| v.to_string()).to_vec(),
        Kind::Switch => ["true", "false"].map(String::from).to_vec(),
        Kind::Choice(names) => names().into_iter().map(String::from).collect(),
    };
    let usual = row.default_in(Preset::Auto);
    texts.into_iter().filter(|text| row.parse(text).is_ok_and(|value| value != usual)).collect()
}

#[test]
fn methods_read_what_the_table_says_and_nothing_else() {
    for info in METHODS {
        let base = BuildOptions { method: info.method, ..BuildOptions::default() };
        let usual = build(&base);
        for row in OPTIONS {
            let mut others = values(row).into_iter().map(|text| {
                let mut options = base.clone();
                row.set(&mut options, &text).unwrap();
                build(&options) != usual
            });
            if row.is_read_by(info.method) {
                assert!(others.any(|other| other), "{} does not read {}", info.name, row.name);
            } else {
                assert!(!others.any(|other| other), "{} reads {}", info.name, row.name);
            }
        }
    }
}
