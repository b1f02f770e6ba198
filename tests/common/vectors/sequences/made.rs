//! Sequences that show what the format has.

use super::*;

/// `2·n·n` triangles that share `(n + 1)²` vertices.
pub fn grid(n: u32) -> Mesh {
    let at = |x: u32, y: u32| y * (n + 1) + x;
    let cell = |c: u32| {
        let (x, y) = (c % n, c / n);
        [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]]
    };
    let count = 2 * n * n;
    Mesh {
        name: "grid".into(),
        positions: wave(n, 0.0),
        triangles: (0..n * n).flat_map(cell).collect(),
        parts: vec![Part { name: "grid".into(), triangle_count: count, prim_count: count, ..Part::default() }],
        ..Mesh::default()
    }
}

/// The vertices of a grid that waves by `height`: multiples of it, so that every machine has the same.
pub fn wave(n: u32, height: f32) -> Vec<Point> {
    let at = |i: u32| [(i % (n + 1)) as f32, (i / (n + 1)) as f32, height * ((i * 7) % 5) as f32];
    (0..(n + 1) * (n + 1)).map(at).collect()
}

/// The first row of leaves goes to the far side: what were neighbours are far apart.
fn torn(n: u32) -> Vec<Point> {
    let mut positions = wave(n, 0.0);
    positions.iter_mut().filter(|p| (p[0] + p[1]) % 2.0 == 0.0).for_each(|p| p[2] += 64.0);
    positions
}

fn moved(x: f64, y: f64) -> Affine {
    Affine::translation([x, y, 0.0])
}

/// Two frames: a grid that lies flat, and the same tree fitted to its waves.
pub fn refitted() -> Sequence {
    let mut sequence = Sequence::default();
    let mesh = grid(2);
    let topology = sequence.add_topology(&mesh, &tree(&mesh, 1));
    for (number, height) in [(1, 0.0), (2, 0.5)] {
        if number > 1 {
            sequence.next_block();
        }
        let pose = sequence.add_pose(topology, &wave(2, height), number == 1);
        let placement = sequence.add_placement(&[(pose, Affine::IDENTITY)]);
        sequence.add_frame(number, None, placement);
    }
    sequence
}

/// Three frames with times: a grid and a pile; both moved as a whole; and the grid torn, with a tree of its own, and mirrored.
pub fn rebuilt() -> Sequence {
    let mut sequence = Sequence::default();
    let (mesh, other) = (grid(2), pile(3));
    let first = sequence.add_topology(&mesh, &tree(&mesh, 2));
    let second = sequence.add_topology(&other, &tree(&other, 2));
    let poses = [sequence.add_pose(first, &mesh.positions, true), sequence.add_pose(second, &other.positions, true)];
    let mut torn_mesh = mesh;
    torn_mesh.positions = torn(2);
    let third = sequence.add_topology(&torn_mesh, &tree(&torn_mesh, 1));
    sequence.next_block();
    let last = sequence.add_pose(third, &torn_mesh.positions, true);
    let mirror = Affine { rows: [[-1.0, 0.0, 0.0, 9.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
    let shown = [
        vec![(poses[0], Affine::IDENTITY), (poses[1], moved(5.0, 0.0))],
        vec![(poses[0], moved(0.0, 8.0)), (poses[1], moved(5.0, 4.0)), (poses[1], moved(7.0, 4.0))],
        vec![(last, mirror), (poses[1], moved(5.0, 4.0))],
    ];
    for (i, shown) in (0..).zip(&shown) {
        let placement = sequence.add_placement(shown);
        sequence.add_frame(i - 1, Some(i as f32 * 0.5), placement);
    }
    sequence
}

/// A frame that shows nothing, one that shows a grid, and one that holds it; the numbers have a hole.
pub fn empty_frame() -> Sequence {
    let mut sequence = Sequence::default();
    let nothing = sequence.add_placement(&[]);
    sequence.add_frame(5, None, nothing);
    let mesh = grid(1);
    let topology = sequence.add_topology(&mesh, &tree(&mesh, 2));
    let pose = sequence.add_pose(topology, &mesh.positions, true);
    let placement = sequence.add_placement(&[(pose, Affine::IDENTITY)]);
    sequence.add_frame(7, None, placement);
    sequence.add_frame(8, None, placement);
    sequence.frames[2].flags = FrameRecord::HELD;
    sequence
}

/// A triangle in two leaves that are fitted to the whole of it, beside one that is cut; with vertices, a mirrored part and materials.
pub fn origins() -> Sequence {
    let still = super::super::valid::duplicates();
    let mesh = {
        let mut mesh = scenes::soup(
            "wide",
            &[0, 1, 2, 3].map(|prim| still.triangles.iter().find(|t| t.prim == prim).unwrap().corners()),
        );
        mesh.parts[0].baked_node = Some(3);
        mesh
    };
    let mut refs: Vec<u32> = still.triangles.iter().map(|t| t.prim).collect();
    let tree = Tree { nodes: still.nodes.clone(), refs: std::mem::take(&mut refs) };
    let mut sequence = Sequence::default();
    let topology = sequence.add_topology(&mesh, &tree);
    for (number, lift) in [(0, 0.0), (1, 2.0)] {
        if number > 0 {
            sequence.next_block();
        }
        let positions: Vec<Point> = mesh.positions.iter().map(|p| [p[0], p[1], p[2] + lift * p[0]]).collect();
        let pose = sequence.add_pose(topology, &positions, number == 0);
        let placement = sequence.add_placement(&[(pose, Affine::IDENTITY)]);
        sequence.add_frame(number, None, placement);
    }
    sequence.vertices = sequence.triangles.iter().map(|t| [0, 1, 2].map(|corner| 10 * t.prim + corner)).collect();
    sequence.sides = vec![bvhc::cache::side_flags::MIRRORED];
    sequence.materials = vec!["brick %FF".into()];
    sequence
}

/// Frames of 288 triangles, which gain by compression.
pub fn large() -> Sequence {
    let mut sequence = Sequence::default();
    let mesh = grid(12);
    let topology = sequence.add_topology(&mesh, &tree(&mesh, 4));
    for number in 0..3 {
        if number > 0 {
            sequence.next_block();
        }
        let pose = sequence.add_pose(topology, &wave(12, number as f32 * 0.25), number == 0);
        let placement = sequence.add_placement(&[(pose, Affine::IDENTITY)]);
        sequence.add_frame(number, Some(number as f32 / 24.0), placement);
    }
    sequence
}

/// Six frames of two grids in blocks of two poses: of the one the vertices are thirds, of the other tenths, and all vertices move.
pub fn walk() -> Sequence {
    let mut sequence = Sequence::default();
    let mesh = grid(8);
    let trees = [tree(&mesh, 1), tree(&mesh, 3)];
    let topologies = trees.each_ref().map(|tree| sequence.add_topology(&mesh, tree));
    for number in 0..6u8 {
        if number > 0 {
            sequence.next_block();
        }
        let turn = |divisor: f32| -> Vec<Point> {
            let slant = f32::from(number) + 1.0;
            wave(8, 0.5)
                .into_iter()
                .map(|[x, y, z]| [x * slant / divisor, (y - x) / divisor, (z + slant) / divisor])
                .collect()
        };
        let poses = [(topologies[0], 3.0), (topologies[1], 10.0)]
            .map(|(topology, divisor)| sequence.add_pose(topology, &turn(divisor), false));
        let placement = sequence.add_placement(&[(poses[0], Affine::IDENTITY), (poses[1], moved(9.0, 0.0))]);
        sequence.add_frame(number.into(), Some(f32::from(number) * 0.5), placement);
    }
    sequence
}

/// A frame of many poses, each of which takes 164 bytes in the file and shows 255 triangles.
pub fn crowd(poses: usize) -> Sequence {
    let mut sequence = Sequence::default();
    let mesh = pile(255);
    let mut shared = mesh.clone();
    shared.triangles = vec![[0, 1, 2]; 255];
    shared.positions.truncate(3);
    let topology = sequence.add_topology(&shared, &tree(&shared, 255));
    let pose: Vec<u32> = (0..poses).map(|_| sequence.add_pose(topology, &shared.positions, true)).collect();
    let shown: Vec<(u32, Affine)> = pose.iter().map(|pose| (*pose, Affine::IDENTITY)).collect();
    let placement = sequence.add_placement(&shown);
    sequence.add_frame(0, None, placement);
    sequence
}
