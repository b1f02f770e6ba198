//! Rules that are easily asked too little, and what breaks them all the same.

use super::*;

/// Files that break a rule in a way that is easily overlooked.
pub(super) fn cases() -> Vec<Invalid> {
    let case = |rule, case, bytes| Invalid { case, ..broken(rule, bytes) };
    let (header, mut nameless) = take_apart(&plane());
    nameless.retain(|(e, _)| e.kind != SectionKind::NAMS);
    let (two_meshes, skewed) = (vec![pile(3)], skewed_instance());
    let placed = |instance| {
        let mesh = pile(3);
        let blases = vec![tree(&mesh, 2)];
        Image::new(&scenes::with_top(vec![mesh], blases, vec![instance]), &Executor::current()).unwrap()
    };
    let named = |name: &[u8]| {
        let mut bytes = plane();
        replace(bytes::stored(&mut bytes, SectionKind::META), b"vector.obj", name);
        refix(bytes)
    };
    // The writer refuses what names something twice, so the second name is changed behind it.
    let twice = |edit: fn(&mut Meta, String), other: &[u8], name: &str| {
        let [mut before, mut meta] = [scenes::meta(), scenes::meta()];
        edit(&mut before, String::from_utf8(other.to_vec()).unwrap());
        edit(&mut meta, name.into());
        let image = valid::plane();
        let mut bytes = to_bytes(&image, &before, &WriteOptions::default(), &Executor::current()).unwrap();
        replace(bytes::stored(&mut bytes, SectionKind::META), other, name.as_bytes());
        with_header(refix(bytes), |h| h.build_key = meta.build_key())
    };
    let option = |meta: &mut Meta, name| meta.options.push((name, "2".into()));
    let count = |meta: &mut Meta, name| meta.read_counts.push((name, 3));
    vec![
        case(&rules::E0206, "option-twice", twice(option, b"max_lear", "max_leaf")),
        case(&rules::E0206, "count-twice", twice(count, b"degenerate_trianglez", "degenerate_triangles")),
        case(&rules::E0209, "backslash", named(br"vect\r.obj")),
        case(&rules::E0209, "drive", named(b"C:ctor.obj")),
        case(&rules::E0502, "needle", file(&placed(needle()))),
        case(&rules::E0123, "meta-records", with_entry(plane(), SectionKind::META, |e| e.elem_count = 3)),
        case(&rules::E0208, "names-of-nobody", names_of_nobody()),
        case(&rules::E0320, "no-names", put_together(header, nameless)),
        case(&rules::E0210, "materials-of-nobody", materials_of_nobody()),
        Invalid { case: "nobody", ..origins(&rules::E0324, |i| i.sides[0] = 0) },
        Invalid { case: "short", ..origins(&rules::E0324, |i| i.sides.push(1)) },
        Invalid { case: "material", ..other_origin(|part| part.material = "oak".into()) },
        Invalid { case: "mirrored", ..other_origin(|part| part.mirrored = true) },
        Invalid { packed: true, ..case(&rules::E0311, "bomb", bomb(8)) },
        Invalid { packed: true, ..case(&rules::E0410, "bomb", bomb(BOMB)) },
        case(&rules::E0425, "square-inside", file(&square_inside())),
        case(&rules::E0502, "terms-cancel", {
            let blases = vec![tree(&two_meshes[0], 2)];
            let accel = scenes::with_top(two_meshes, blases, vec![skewed]);
            let mut image = Image::new(&accel, &Executor::current()).unwrap();
            let m = &mut image.instances[0].world_to_object;
            (m[0], m[1], m[4], m[5]) = (1e4, -1e4, -1e4, 1e4);
            file(&image)
        }),
    ]
}

/// A matrix that is nearly singular: terms of 10⁸ cancel in its products.
pub(super) fn skewed_instance() -> Instance {
    let rows = [[1e4, 1e4, 0.0, 0.0], [1e4, f64::from(1e4f32.next_up()), 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    Instance { mesh: 0, transform: Affine { rows }, node: 0, name: String::new() }
}

/// A matrix of which `f64` cannot tell the inverse: its rows differ in their last bits, and the determinant is 2⁻⁴⁸.
pub(super) fn needle() -> Instance {
    let u = f64::from(1f32.next_down());
    let rows = [[1.0, 1.0, 1.0, 0.0], [1.0, u, 1.0, 0.0], [1.0, 1.0, u, 0.0]];
    Instance { mesh: 0, transform: Affine { rows }, node: 0, name: String::new() }
}

/// Fit inner nodes to their children.
pub(super) fn refit(nodes: &mut [Node]) {
    for n in (0..nodes.len()).rev().filter(|n| *n != 1) {
        let first = nodes[n].first as usize;
        if !nodes[n].is_leaf() {
            let bounds = nodes[first].bounds().union(nodes[first + 1].bounds());
            (nodes[n].min, nodes[n].max) = (bounds.min, bounds.max);
        }
    }
}

/// Let a leaf reach further to where its sibling ends.
pub(in super::super) fn loosen(nodes: &mut [Node]) {
    let wanted = (2..nodes.len()).flat_map(|n| (0..3).map(move |axis| (n, axis)));
    let small = |(n, axis): &(usize, usize)| nodes[*n].is_leaf() && nodes[*n].max[*axis] < nodes[*n ^ 1].max[*axis];
    let (leaf, axis) = wanted.into_iter().find(small).unwrap();
    nodes[leaf].max[axis] = nodes[leaf].max[axis].next_up();
}

/// Triangles of [`bomb`].
const BOMB: u32 = 1 << 19;

/// Eight nodes and half a million triangles, all zero: a few kilobytes that decode to 24 MB. `stated` is what the row of BLAS says.
pub(super) fn bomb(stated: u32) -> Vec<u8> {
    let mut image = valid::plane();
    image.triangles = vec![Zeroable::zeroed(); BOMB as usize];
    image.blases[0].ref_count = stated;
    let options = WriteOptions { codec: Codec::Zstd { level: 3 }, check: false };
    to_bytes(&image, &scenes::meta(), &options, &Executor::current()).unwrap()
}

/// NAMS with empty names alone, which is left out where no part has a name.
pub(super) fn names_of_nobody() -> Vec<u8> {
    let mesh = scenes::soup("", &[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    let tree = tree(&mesh, 1);
    let names: [u8; 12] = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let added = bytes::with_section(&file(&one_level(mesh, tree)), *b"NAMS", section_flags::COPY_SAFE, &names);
    with_entry(added, SectionKind::NAMS, |e| e.elem_count = 1)
}

/// MATS with empty names alone, which is left out where no part has a material.
pub(super) fn materials_of_nobody() -> Vec<u8> {
    let names: [u8; 12] = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let flags = section_flags::COPY_SAFE | section_flags::CONTENT;
    let added = bytes::with_section(&plane(), *b"MATS", flags, &names);
    with_entry(added, SectionKind::MATS, |e| e.elem_count = 1)
}

/// Four leaves that hold the corners, the edges and the middle of a triangle, and not a square inside.
pub(super) fn square_inside() -> Image {
    let mesh = scenes::soup("wide", &[[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]]);
    let flat =
        |min: [f32; 2], max: [f32; 2]| bvhc::geom::Aabb { min: [min[0], min[1], 0.0], max: [max[0], max[1], 0.0] };
    let all = flat([0.0, 0.0], [4.0, 4.0]);
    let nodes = vec![
        Node::inner(all, 2),
        zero_node(),
        Node::leaf(flat([0.0, 0.0], [0.5, 4.0]), 0, 1),
        Node::inner(flat([0.5, 0.0], [4.0, 4.0]), 4),
        Node::leaf(flat([0.501, 0.0], [4.0, 3.499]), 1, 1),
        Node::inner(flat([0.5, 0.0], [0.501, 4.0]), 6),
        Node::leaf(flat([0.5, 0.0], [0.501, 0.5]), 2, 1),
        Node::leaf(flat([0.5, 0.501], [0.501, 4.0]), 3, 1),
    ];
    one_level(mesh, Tree { nodes, refs: vec![0; 4] })
}
