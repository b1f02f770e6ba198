//! Counts, trees, triangles and instances of still files: rules `E03xx` to `E05xx`.

use super::*;

pub(super) fn counts() -> Vec<Invalid> {
    let head = |rule, edit: fn(&mut Header)| broken(rule, with_header(plane(), edit));
    let edited = |rule, edit: fn(&mut Image)| image(rule, valid::plane(), edit);
    let extra_geom = |rule, blas, first_prim, prim_count| {
        image(rule, valid::plane(), |i| {
            let row = i.geoms[0];
            let part = GeomRecord { source_part: 1, kept_count: 0, name_hash: [0; 32], ..row };
            i.geoms.push(GeomRecord { blas, first_prim, prim_count, ..part });
            i.names.push(String::new());
        })
    };
    vec![
        head(&rules::E0301, |h| h.node_count += 1),
        head(&rules::E0302, |h| h.ref_count += 1),
        head(&rules::E0303, |h| h.prim_count += 1),
        head(&rules::E0304, |h| h.blas_count += 1),
        head(&rules::E0305, |h| h.instance_count += 1),
        head(&rules::E0306, |h| h.max_depth += 1),
        head(&rules::E0307, |h| h.scene_max[1] = h.scene_max[1].next_up()),
        head(&rules::E0308, |h| h.frame_count = 2),
        head(&rules::E0309, |h| h.tree_flags ^= tree_flags::DUP_REFS | tree_flags::REFITTABLE),
        edited(&rules::E0310, |i| i.nodes.extend([zero_node(); 2])),
        edited(&rules::E0311, |i| i.triangles.push(i.triangles[0])),
        edited(&rules::E0312, |i| {
            i.nodes.push(zero_node());
            i.blases[0].node_count += 1;
        }),
        edited(&rules::E0313, |i| i.blases[0].flags = tree_flags::DUP_REFS | tree_flags::REFITTABLE),
        extra_geom(&rules::E0314, 99, 0, 0),
        edited(&rules::E0315, |i| i.geoms[0].reserved = 1),
        extra_geom(&rules::E0316, 0, u32::MAX, 2),
        broken(&rules::E0317, without_top()),
        edited(&rules::E0318, |i| i.geoms[0].kept_count -= 1),
        edited(&rules::E0319, |i| i.blases[0].prim_count += 1),
        edited(&rules::E0320, |i| i.geoms[0].name_hash[31] ^= 1),
        origins(&rules::E0321, |i| i.vertices.truncate(i.triangles.len() - 1)),
        origins(&rules::E0322, |i| {
            let copy = (0..i.triangles.len()).rev().find(|&t| i.triangles[t].prim == 0).unwrap();
            i.vertices[copy] = [100, 101, 102];
        }),
        origins(&rules::E0323, |i| {
            let other = i.triangles.iter().position(|t| t.prim == 3).unwrap();
            i.vertices[other][0] = 20;
        }),
        origins(&rules::E0324, |i| i.sides[0] |= 2),
        origins(&rules::E0325, |i| i.geoms[0].baked_node = NO_NODE),
        image(&rules::E0328, valid::parts(), |i| i.geoms[0].prim_count += 1),
    ]
}

pub(super) fn origins(rule: &'static Rule, edit: fn(&mut Image)) -> Invalid {
    image(rule, valid::origins(), edit)
}

/// The two-level file without its top level, everything else made to agree.
pub(super) fn without_top() -> Vec<u8> {
    let image = two_level();
    let (mut header, mut sections) = take_apart(&file(&image));
    sections.retain(|(e, _)| e.kind != SectionKind::TNOD && e.kind != SectionKind::INST);
    header.tree_flags &= !tree_flags::TWO_LEVEL;
    header.instance_count = 0;
    header.node_count -= image.tlas_nodes.len() as u64 - 1;
    header.max_depth = image.blases.iter().map(|b| b.max_depth).max().unwrap();
    (header.scene_min, header.scene_max) = (image.nodes[0].min, image.nodes[0].max);
    put_together(header, sections)
}

pub(super) fn topology() -> Vec<Invalid> {
    // In the tree over the plane node 2 is the root's first child; over eight triangles its pairs are 4 and 10.
    let edited = |rule, edit: fn(&mut Image)| image(rule, valid::plane(), edit);
    let four = || {
        let mesh = pile(4);
        let tree = tree(&mesh, 1);
        one_level(mesh, tree)
    };
    let (deep_mesh, deep_tree) = comb(66);
    let big_leaf = pile(256);
    let big_tree = tree(&big_leaf, 256);
    let deeper = with_header(
        file(&{
            let mut image = valid::plane();
            image.blases[0].max_depth += 1;
            image
        }),
        |h| h.max_depth -= 1,
    );
    vec![
        edited(&rules::E0401, |i| i.nodes[2].first += 1),
        edited(&rules::E0402, |i| {
            let inner = (4..i.nodes.len()).find(|&n| !i.nodes[n].is_leaf()).unwrap();
            i.nodes[inner].first = 2;
        }),
        edited(&rules::E0403, |i| i.nodes[2].first = i.nodes.len() as u32),
        image(&rules::E0404, four(), |i| i.nodes[3].first = i.nodes[2].first),
        edited(&rules::E0405, |i| {
            i.nodes.extend([zero_node(); 2]);
            i.blases[0].node_count += 2;
        }),
        broken(&rules::E0406, file(&one_level(deep_mesh, deep_tree))),
        broken(&rules::E0407, deeper),
        edited(&rules::E0408, |i| {
            let last = i.triangles.len() as u32 - 1;
            let leaf = i.nodes.iter().position(|n| n.is_leaf() && n.first == last).unwrap();
            i.nodes[leaf].count += 1;
        }),
        image(&rules::E0409, four(), |i| (i.nodes[4].first, i.nodes[5].first) = (i.nodes[5].first, i.nodes[4].first)),
        broken(&rules::E0410, file(&one_level(big_leaf, big_tree))),
        edited(&rules::E0411, |i| i.nodes[2].max[1] = i.nodes[2].max[1].next_down()),
        edited(&rules::E0412, |i| {
            let leaf = (4..i.nodes.len()).find(|&n| i.nodes[n].is_leaf()).unwrap();
            i.nodes[leaf].min[0] = i.nodes[leaf].max[0] + 1.0;
        }),
        edited(&rules::E0413, |i| i.nodes[1].count = 1),
        edited(&rules::E0414, |i| i.blases[0].min[0] = i.blases[0].min[0].next_down()),
        edited(&rules::E0428, |i| {
            i.nodes[0].max[1] += 1.0;
            i.blases[0].max[1] += 1.0;
        }),
        image(&rules::E0434, valid::duplicates(), |i| {
            i.nodes[0].max[1] += 1.0;
            i.blases[0].max[1] += 1.0;
        }),
        image(&rules::E0426, four(), |i| {
            (i.nodes[2].first, i.nodes[3].first) = (6, 4);
            for k in 0..2 {
                i.nodes.swap(4 + k, 6 + k);
            }
        }),
        broken(
            &rules::E0427,
            file(&{
                let mut image = valid::plane();
                image.blases[0].sah = image.blases[0].sah.next_up();
                image
            }),
        ),
    ]
}

pub(super) fn triangles() -> Vec<Invalid> {
    let edited = |rule, edit: fn(&mut Image)| image(rule, valid::plane(), edit);
    let cut = |rule, lists| broken(rule, file(&cut_in_two(lists)));
    let cut_edited = |rule, edit: fn(&mut Image)| image(rule, valid::duplicates(), edit);
    vec![
        edited(&rules::E0415, |i| i.triangles[0].prim = 8),
        edited(&rules::E0416, |i| i.triangles[0].geom = 1),
        edited(&rules::E0417, |i| i.triangles[0].v0[0] = f32::NAN),
        edited(&rules::E0418, |i| i.triangles[0].flags = 4),
        edited(&rules::E0419, |i| i.triangles[0].v1[2] = 1e-30),
        cut(&rules::E0420, [&[0, 1], &[0, 2], &[0, 3]]),
        image(
            &rules::E0421,
            {
                let mesh = pile(4);
                let tree = tree(&mesh, 1);
                one_level(mesh, tree)
            },
            |i| {
                i.triangles[1].prim = i.triangles[0].prim;
                i.geoms[0].kept_count -= 1;
                i.blases[0].prim_count -= 1;
            },
        ),
        edited(&rules::E0422, |i| i.triangles[0].flags = TriangleRecord::DUPLICATED),
        cut(&rules::E0423, [&[0, 1, 0], &[0, 2], &[3]]),
        cut_edited(&rules::E0424, |i| {
            let copy = (0..i.triangles.len()).rev().find(|&t| i.triangles[t].prim == 0).unwrap();
            i.triangles[copy].v1[0] = 8.5;
        }),
        // The right leaf's box ends one step below the corner at x = 8.
        cut_edited(&rules::E0425, |i| [2, 5].into_iter().for_each(|n| i.nodes[n].max[0] = 8f32.next_down())),
        edited(&rules::W0401, |i| {
            let zero = i.triangles.iter().position(|t| t.v0[0] == 0.0).unwrap();
            i.triangles[zero].v0[0] = -0.0;
        }),
    ]
}

pub(super) fn instances() -> Vec<Invalid> {
    let edited = |rule, edit: fn(&mut Image)| {
        broken(
            rule,
            file(&{
                let mut image = two_level();
                edit(&mut image);
                image
            }),
        )
    };
    let place = |mesh| Instance { mesh, transform: Affine::IDENTITY, node: 0, name: String::new() };
    let with_meshes = |meshes: Vec<Mesh>, instances: Vec<Instance>| {
        let blases = meshes.iter().map(|m| if m.triangles.is_empty() { Tree::default() } else { tree(m, 2) }).collect();
        file(&Image::new(&scenes::with_top(meshes, blases, instances), &Executor::current()).unwrap())
    };
    vec![
        edited(&rules::E0501, |i| i.instances[1].world_to_object[5] = f32::INFINITY),
        edited(&rules::E0502, |i| i.instances[1].world_to_object[0] *= 1.001),
        edited(&rules::E0503, |i| i.instances[0].blas = 2),
        edited(&rules::E0504, |i| i.instances[1].id = i.instances[0].id),
        edited(&rules::E0505, |i| i.instances[1].flags ^= InstanceRecord::MIRRORED),
        edited(&rules::E0506, |i| i.instances[1].reserved[2] = 7),
        edited(&rules::E0507, |i| {
            let leaf = (2..i.tlas_nodes.len()).find(|&n| i.tlas_nodes[n].is_leaf()).unwrap();
            i.tlas_nodes[leaf].max[1] = i.tlas_nodes[leaf].max[1].next_down();
            refit(&mut i.tlas_nodes);
        }),
        edited(&rules::E0508, |i| i.tlas_nodes[0].max[1] += 100.0),
        edited(&rules::E0509, |i| i.geoms[0].baked_node = 1),
        edited(&rules::W0503, |i| i.instances[1].mask = 0),
        broken(&rules::W0501, with_meshes(vec![pile(3), Mesh::default()], vec![place(0), place(1)])),
        broken(&rules::W0502, with_meshes(vec![pile(3), pile(2)], vec![place(0), place(0)])),
    ]
}
