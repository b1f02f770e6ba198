//! What builds hold at once beside the scene, their result included, stays within what docs/methods.md promises per triangle.

use bvhc::build::{BuildOptions, Executor, Levels, Method, NoProgress, Preset};
use bvhc::compile;
use bvhc::scene::{self, Mesh, ReadOptions};
use bvhc::stability::heap::{self, Counting};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Short slivers in all directions, strewn over a cube of this edge: the smaller it is, the more their boxes overlap.
fn straw(count: u32, edge: f32) -> Mesh {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut mesh = Mesh::default();
    for i in 0..count {
        let start = [next(), next(), next()].map(|v| v * edge);
        let end = start.map(|v| v + next() - 0.5);
        mesh.positions.extend([start, end, [start[0] + 0.02, start[1], start[2] + 0.01]]);
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

/// A hall whose long triangles are worth cutting.
fn colonnade() -> Mesh {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/colonnade.obj");
    let scene = scene::read(file.as_ref(), &ReadOptions::default()).unwrap();
    let options = BuildOptions { levels: Levels::One, ..BuildOptions::default() };
    compile::lay_out(scene, &options, &Executor::sequential()).unwrap().meshes.remove(0)
}

/// One test for all: the counter sees every thread of the process.
#[test]
fn builds_hold_no_more_than_promised() {
    let preset = BuildOptions::preset;
    let bonsai = BuildOptions { method: Method::Bonsai, ..preset(Preset::Draft) };
    let oriented = BuildOptions { method: Method::Oabb, ..preset(Preset::Draft) };
    // Every reference that straddles a plane is cut, until the budget is used up.
    let cut =
        BuildOptions { method: Method::Sbvh, split_alpha: 0.0, unsplit: false, reinsert: 8, ..preset(Preset::Auto) };
    let mut most_cut = 1.0f64;
    for mesh in [straw(40_000, 20.0), straw(40_000, 3.0), colonnade()] {
        for (name, options, most) in [
            ("draft", &preset(Preset::Draft), 200),
            ("bonsai", &bonsai, 200),
            ("oabb", &oriented, 900),
            ("balanced", &preset(Preset::Balanced), 400),
            ("auto", &preset(Preset::Auto), 400),
            ("best", &preset(Preset::Best), 400),
            ("sbvh that cuts everything", &cut, 400),
        ] {
            for jobs in [1, 2] {
                let exec = Executor::new(jobs).unwrap();
                let (tree, peak) = heap::peak_of(|| compile::build_tree(&mesh, options, &exec, &NoProgress).unwrap());
                let each = peak / mesh.triangles.len();
                println!("{name}, {jobs} threads: {each} bytes per triangle, {} references", tree.refs.len());
                assert!(each <= most, "{name}, {jobs} threads: {each} bytes per triangle, more than {most}");
                let result = size_of_val(&tree.nodes[..]) + size_of_val(&tree.refs[..]);
                assert!(peak >= result, "{name}: {peak} bytes are fewer than the {result} of the tree");
                most_cut = most_cut.max(tree.refs.len() as f64 / mesh.triangles.len() as f64);
            }
        }
    }
    assert!(most_cut > 1.35, "the budget is 1.5, and {most_cut} is far from it");
}
