//! Small scenes and the plainest tree builder there is: median splits down to leaves of a given size.

use bvhc::cache::{Dependency, Image, Meta, tree_flags};
use bvhc::exec::Executor;
use bvhc::geom::{Aabb, Affine, Point};
use bvhc::scene::{InputFile, Instance, Mesh, Part};
use bvhc::tree::{Accel, Node, Tree, quality};

/// A mesh of separate triangles in one part.
pub fn soup(name: &str, triangles: &[[Point; 3]]) -> Mesh {
    let count = triangles.len() as u32;
    let part = Part { name: name.into(), triangle_count: count, prim_count: count, ..Part::default() };
    Mesh {
        name: name.into(),
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        parts: vec![part],
        ..Mesh::default()
    }
}

/// `2·n·n` triangles over the unit squares of a sheet that waves by `height`; flat for 0.
pub fn sheet(n: u32, height: f32) -> Mesh {
    let at = |x: u32, y: u32| [x as f32, y as f32, height * ((x * 7 + y * 3) % 5) as f32];
    let mut triangles = Vec::new();
    for y in 0..n {
        for x in 0..n {
            let (a, b, c, d) = (at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    soup("sheet", &triangles)
}

/// `n` different triangles in the same place: every box of their tree is the same.
pub fn pile(n: usize) -> Mesh {
    soup("pile", &vec![[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; n])
}

pub fn tree(mesh: &Mesh, max_leaf: usize) -> Tree {
    let boxes: Vec<Aabb> = (0..mesh.triangles.len()).map(|i| mesh.triangle_box(i)).collect();
    tree_over(&boxes, max_leaf)
}

pub fn tree_over(boxes: &[Aabb], max_leaf: usize) -> Tree {
    let mut out = Tree { nodes: Vec::new(), refs: (0..boxes.len() as u32).collect() };
    if !boxes.is_empty() {
        out.nodes = vec![Node::leaf(Aabb::EMPTY, 0, 0); 2];
        out.nodes[1] = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
        split(&mut out, boxes, 0, 0..boxes.len(), max_leaf);
    }
    out
}

fn split(out: &mut Tree, boxes: &[Aabb], node: usize, range: std::ops::Range<usize>, max_leaf: usize) {
    let refs = &mut out.refs[range.clone()];
    let bounds = refs.iter().fold(Aabb::EMPTY, |b, r| b.union(boxes[*r as usize]));
    if refs.len() <= max_leaf {
        out.nodes[node] = Node::leaf(bounds, range.start as u32, range.len() as u32);
        return;
    }
    let extent = bounds.extent();
    let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b]).then(b.cmp(a))).unwrap();
    refs.sort_by(|a, b| {
        boxes[*a as usize].center2()[axis].total_cmp(&boxes[*b as usize].center2()[axis]).then(a.cmp(b))
    });
    let first = out.nodes.len();
    out.nodes.extend([Node::leaf(bounds, 0, 1); 2]);
    out.nodes[node] = Node::inner(bounds, first as u32);
    let middle = range.start + range.len() / 2;
    split(out, boxes, first, range.start..middle, max_leaf);
    split(out, boxes, first + 1, middle..range.end, max_leaf);
}

/// A tree whose every inner node has a leaf of one triangle and the rest: `n` triangles at depth up to `n - 1`.
pub fn comb(n: usize) -> (Mesh, Tree) {
    let mesh = pile(n);
    let bounds = mesh.triangle_box(0);
    let unused = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
    let mut nodes = vec![Node::inner(bounds, 2), unused];
    for i in 0..n - 1 {
        let rest =
            if i + 2 == n { Node::leaf(bounds, i as u32 + 1, 1) } else { Node::inner(bounds, nodes.len() as u32 + 2) };
        nodes.extend([Node::leaf(bounds, i as u32, 1), rest]);
    }
    (mesh, Tree { nodes, refs: (0..n as u32).collect() })
}

pub fn one_level(mesh: Mesh, tree: Tree) -> Image {
    Image::new(&Accel { meshes: vec![mesh], blases: vec![tree], ..Accel::default() }, &Executor::current()).unwrap()
}

/// A wide triangle cut in two by the plane x = 4, small triangles on both sides, and a third leaf far to the right.
///
/// `lists`: for each of the leaves left, right and far which triangles stand in it; 0 is the wide one.
pub fn cut_in_two(lists: [&[u32]; 3]) -> Image {
    let small = |x: f32| [[x, 0.0, 0.0], [x + 0.5, 0.0, 0.0], [x, 0.5, 0.0]];
    let wide = [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]];
    let mesh = soup("wide", &[wide, small(1.0), small(5.0), small(20.0)]);
    // Of the wide triangle the part beyond x = 4 reaches up to y = 4.
    let left = Aabb { min: [0.0; 3], max: [4.0, 8.0, 0.0] };
    let right = Aabb { min: [4.0, 0.0, 0.0], max: [8.0, 4.0, 0.0] };
    let far = Aabb { min: [20.0, 0.0, 0.0], max: [20.5, 0.5, 0.0] };
    let counts = lists.map(|l| l.len() as u32);
    let unused = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
    let nodes = vec![
        Node::inner(left.union(right).union(far), 2),
        unused,
        Node::inner(left.union(right), 4),
        Node::leaf(far, counts[0] + counts[1], counts[2]),
        Node::leaf(left, 0, counts[0]),
        Node::leaf(right, counts[0], counts[1]),
    ];
    one_level(mesh, Tree { nodes, refs: lists.concat() })
}

/// Two meshes at five places, one of them mirrored and one far away.
pub fn two_level_accel() -> Accel {
    let meshes = vec![sheet(2, 0.25), pile(3)];
    let blases: Vec<Tree> = meshes.iter().map(|m| tree(m, 2)).collect();
    let at = |mesh: u32, node: u32, rows: [[f64; 4]; 3]| Instance {
        mesh,
        transform: Affine { rows },
        node,
        name: String::new(),
    };
    let instances = vec![
        at(0, 1, [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
        at(0, 2, [[-1.5, 0.0, 0.0, -5.0], [0.0, 1.5, 0.0, 0.0], [0.0, 0.0, 1.5, 3.0]]),
        at(1, 3, [[0.6, -0.8, 0.0, 10.0], [0.8, 0.6, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
        at(1, 4, [[2.0, 0.3, 0.0, 0.0], [0.0, 2.0, 0.0, 12.0], [0.1, 0.0, 2.0, 0.0]]),
        at(0, 5, [[1.0, 0.0, 0.0, 1e6], [0.0, 1.0, 0.0, -3e5], [0.0, 0.0, 1.0, 7.0]]),
    ];
    with_top(meshes, blases, instances)
}

pub fn with_top(meshes: Vec<Mesh>, blases: Vec<Tree>, instances: Vec<Instance>) -> Accel {
    let boxes: Vec<Aabb> = instances
        .iter()
        .map(|i| {
            let bounds = blases[i.mesh as usize].bounds();
            let bounds = if bounds.is_empty() { Aabb { min: [0.0; 3], max: [0.0; 3] } } else { bounds };
            Affine::from_f32(&i.transform.to_f32()).transform_box(&bounds)
        })
        .collect();
    let tlas = tree_over(&boxes, 1);
    Accel { meshes, blases, tlas: Some(tlas), instances, ..Accel::default() }
}

pub fn two_level() -> Image {
    Image::new(&two_level_accel(), &Executor::current()).unwrap()
}

/// Three named parts, one of them without a name, and source numbers with holes: two triangles were dropped.
pub fn parts_mesh() -> Mesh {
    let mut mesh = sheet(2, 0.0);
    mesh.source_prims = vec![0, 1, 2, 4, 5, 6, 8, 9];
    let part = |name: &str, source_part, first_triangle, triangle_count, first_prim, prim_count| Part {
        name: name.into(),
        source_part,
        first_triangle,
        triangle_count,
        first_prim,
        prim_count,
        ..Part::default()
    };
    mesh.parts = vec![part("roof", 0, 0, 3, 0, 4), part("", 1, 3, 3, 4, 3), part("wänd", 2, 6, 2, 7, 3)];
    mesh
}

/// Every vector says that it was built from this file.
pub fn inputs() -> Vec<InputFile> {
    let text = b"# the model of a test vector\n";
    vec![InputFile {
        path: "vector.obj".into(),
        name: "vector.obj".into(),
        len: text.len() as u64,
        blake3: *blake3::hash(text).as_bytes(),
    }]
}

/// Fixed, so that a new version of the tool leaves the vectors as they are.
pub fn meta() -> Meta {
    let dependency = |input: &InputFile| Dependency {
        role: Dependency::MODEL,
        name: input.name.clone(),
        len: input.len,
        blake3: input.blake3,
    };
    Meta {
        tool: "vectors".into(),
        tool_version: "1".into(),
        method: "binned".into(),
        builder_revision: 1,
        options: vec![("max_leaf".into(), "1".into())],
        dependencies: inputs().iter().map(dependency).collect(),
        read_counts: vec![("degenerate_triangles".into(), 0)],
        notes: vec!["made by hand".into()],
    }
}

/// State each tree's SAH anew after its nodes were edited.
pub fn restate_sah(image: &mut Image) {
    for blas in &mut image.blases {
        let start = blas.node_offset as usize;
        if let Some(nodes) = image.nodes.get(start..start + blas.node_count as usize) {
            blas.sah = quality::sah(nodes);
        }
    }
}

pub const TWO_LEVEL: u32 = tree_flags::TWO_LEVEL;
