//! Images to write.

use bvhc::cache::{Image, Meta};
use bvhc::exec::Executor;
use bvhc::geom::{Aabb, Affine};
use bvhc::scene::{Instance, Mesh, Part};
use bvhc::tree::{Accel, Node, Tree};
use proptest::prelude::*;

/// One right triangle in the xy plane.
pub fn triangle_mesh() -> Mesh {
    Mesh {
        name: "mesh".into(),
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        parts: vec![Part { name: "triangle".into(), triangle_count: 1, prim_count: 1, ..Part::default() }],
        ..Mesh::default()
    }
}

fn leaf_tree(bounds: Aabb, refs: Vec<u32>) -> Tree {
    let zero = Node::leaf(Aabb { min: [0.0; 3], max: [0.0; 3] }, 0, 0);
    Tree { nodes: vec![Node::leaf(bounds, 0, refs.len() as u32), zero], refs }
}

pub fn one_triangle() -> Image {
    let mesh = triangle_mesh();
    let tree = leaf_tree(mesh.triangle_box(0), vec![0]);
    Image::new(&Accel { meshes: vec![mesh], blases: vec![tree], ..Accel::default() }, &Executor::current()).unwrap()
}

/// The triangle twice, side by side and mirrored.
pub fn two_instances() -> Image {
    let mesh = triangle_mesh();
    let tree = leaf_tree(mesh.triangle_box(0), vec![0]);
    let mirrored = Affine { rows: [[-1.0, 0.0, 0.0, 4.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
    let instances: Vec<Instance> = [Affine::IDENTITY, mirrored]
        .into_iter()
        .map(|transform| Instance { mesh: 0, transform, node: 0, name: String::new() })
        .collect();
    let world = instances.iter().fold(Aabb::EMPTY, |b, i| b.union(i.transform.transform_box(&mesh.triangle_box(0))));
    let tlas = Some(leaf_tree(world, vec![0, 1]));
    Image::new(
        &Accel { meshes: vec![mesh], blases: vec![tree], tlas, instances, ..Accel::default() },
        &Executor::current(),
    )
    .unwrap()
}

pub fn empty() -> Image {
    Image::new(&Accel::default(), &Executor::current()).unwrap()
}

pub fn meta() -> Meta {
    Meta {
        tool: "bvhc".into(),
        tool_version: "0.0.0".into(),
        method: "sbvh".into(),
        builder_revision: 1,
        options: vec![("bins".into(), "32".into()), ("degenerate".into(), "drop".into())],
        ..Meta::default()
    }
}

/// Any records at all, so long as the counts agree: the container does not look into them.
pub fn any_image() -> impl Strategy<Value = Image> {
    (0..3000usize, any::<u8>(), any::<bool>(), any::<bool>(), proptest::collection::vec(".{0,8}", 0..5)).prop_map(
        |(n, seed, two_level, named, names)| {
            let mut image = if two_level { two_instances() } else { one_triangle() };
            let node = image.nodes[0];
            let tris = image.triangles[0];
            image.nodes.resize_with(2 + 2 * n, || Node { first: n as u32 ^ u32::from(seed), ..node });
            for (i, node) in image.nodes.iter_mut().enumerate().skip(2) {
                node.min[0] = (i * usize::from(seed)) as f32;
            }
            image.triangles.resize(1 + n, tris);
            image.triangles.iter_mut().enumerate().for_each(|(i, t)| t.prim = i as u32 * u32::from(seed));
            (image.blases[0].node_count, image.blases[0].ref_count) =
                (image.nodes.len() as u32, image.triangles.len() as u32);
            let geom = image.geoms[0];
            image.geoms.resize(names.len(), geom);
            image.materials = if seed % 3 == 0 { names.iter().map(|n| n.repeat(2)).collect() } else { Vec::new() };
            image.sides = if seed % 5 < 2 { (0..names.len()).map(|i| (i % 2) as u32).collect() } else { Vec::new() };
            let numbers = |i: u32| [i, i ^ 1, i.wrapping_mul(77)];
            image.vertices = if seed % 2 == 0 { (0..=n as u32).map(numbers).collect() } else { Vec::new() };
            image.names = if named { names } else { Vec::new() };
            image
        },
    )
}
