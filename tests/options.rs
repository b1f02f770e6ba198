//! The table of options says which methods read an option. Here each method is held to it: it builds another tree with another value of
//! an option that it reads, and the same tree with any value of an option that it does not.

use bvhc::build::{BuildOptions, Executor, Kind, METHODS, NoProgress, OPTIONS, OptionInfo, Preset};
use bvhc::compile::compile;
use bvhc::geom::Affine;
use bvhc::random::Random;
use bvhc::scene::{Instance, Mesh, Part, Scene};
use bvhc::tree::Tree;

/// A mesh in two places: small triangles with long thin ones across, so that every step of every method has something to do.
fn scene(triangles: u32) -> Scene {
    let mut random = Random::new(11);
    let mut mesh = Mesh::default();
    for i in 0..triangles {
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
    let mut moved = Affine::IDENTITY;
    moved.rows[0][3] = 20.0;
    let place = |transform| Instance { mesh: 0, transform, node: 0, name: String::new() };
    Scene { meshes: vec![mesh], instances: vec![place(Affine::IDENTITY), place(moved)], ..Scene::default() }
}

fn build(scene: &Scene, options: &BuildOptions) -> (Vec<Tree>, Option<Tree>) {
    let accel = compile(scene.clone(), options, &Executor::sequential(), &NoProgress).unwrap();
    (accel.blases, accel.tlas)
}

/// Values all over the range, but no large ones where a count costs time or memory.
fn values(row: &OptionInfo) -> Vec<String> {
    let texts = match row.kind {
        Kind::Count(least, _) => [least, least + 3, 300].map(|n| n.to_string()).to_vec(),
        Kind::Real(least, most) => [least, 0.02, 0.3, most.min(50.0)].map(|v| v.to_string()).to_vec(),
        Kind::Switch => ["true", "false"].map(String::from).to_vec(),
        Kind::Choice(names) => names().into_iter().map(String::from).collect(),
        other => panic!("{}: no values to try for {other:?}", row.name),
    };
    let usual = row.default_in(Preset::Auto);
    texts.into_iter().filter(|text| row.parse(text).is_ok_and(|value| value != usual)).collect()
}

/// Whether some value of an option gives another tree than its value in one of the bases.
fn is_read(scene: &Scene, row: &OptionInfo, bases: &[BuildOptions]) -> bool {
    bases.iter().any(|base| {
        let usual = build(scene, base);
        values(row).into_iter().any(|text| {
            let mut options = base.clone();
            row.set(&mut options, &text).unwrap();
            options != *base && build(scene, &options) != usual
        })
    })
}

#[test]
fn methods_read_what_the_table_says_and_nothing_else() {
    // Mini trees are pruned where there are several, and one of them holds two thousand triangles.
    let (small, large) = (scene(250), scene(4200));
    let mut wrong = Vec::new();
    for info in METHODS {
        let plain = BuildOptions { method: info.method, ..BuildOptions::default() };
        // Joining leaves gains something where both hold pieces of the same triangles.
        let cut = BuildOptions { presplit: 2.0, split_alpha: 0.0, split_budget: 3.0, unsplit: false, ..plain.clone() };
        // What rays are for matters where they form or judge something.
        let adapted = BuildOptions { adapt: 100, ..plain.clone() };
        // Leaves of clusters are chosen by the SAH, so that collapsing finds some only where subtrees were moved and nodes are dear.
        let dear = BuildOptions { max_leaf: 30, reinsert: 8, traversal_cost: 4.0, ..plain.clone() };
        let bases = [plain, adapted, BuildOptions { max_leaf: 30, reinsert: 8, ..cut }, dear];
        for row in OPTIONS {
            let expected = row.is_read_by(info.method);
            let found = is_read(&small, row, &bases) || expected && is_read(&large, row, &bases[..2]);
            if found != expected {
                wrong.push(format!("{} reads {}: {found}", info.name, row.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
