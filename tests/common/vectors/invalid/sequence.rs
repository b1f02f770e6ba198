//! Sequences: rules `E07xx`, and those of still files that hold for each of their poses.

use super::*;

pub(super) fn sequence() -> Vec<Invalid> {
    let edited = |rule, edit: fn(&mut Sequence)| {
        let mut sequence = sequences::refitted();
        edit(&mut sequence);
        broken(rule, sequence.file())
    };
    let head = |rule, edit: fn(&mut Header)| broken(rule, with_header(sequences::refitted().file(), edit));
    let case = |case, invalid| Invalid { case, ..invalid };
    let mut numbered = sequences::refitted().file();
    let last = bytes::entries(&numbered).iter().rposition(|e| e.kind == SectionKind::VPOS).unwrap();
    bytes::set_entry(
        &mut numbered,
        last,
        &SectionEntry { ordinal: 2, ..bytes::entries(&sequences::refitted().file())[last] },
    );
    let tris = bytes::with_section(&sequences::refitted().file(), *b"TRIS", 5, &[]);
    vec![
        head(&rules::E0130, |h| h.min_minor = 1),
        edited(&rules::E0701, |s| s.topologies[0].ref_offset = 1),
        edited(&rules::E0702, |s| s.poses[1].node_offset = 2),
        edited(&rules::E0703, |s| s.frames[1].number = s.frames[0].number),
        edited(&rules::E0704, |s| s.triangles[0].corners[0] = s.topologies[0].vertex_count),
        broken(&rules::E0705, other_leaves()),
        edited(&rules::E0706, |s| s.topologies[0].reserved[7] = 1),
        edited(&rules::E0707, |s| {
            let mesh = sequences::grid(1);
            s.add_topology(&mesh, &tree(&mesh, 1));
        }),
        broken(&rules::E0708, {
            let mut sequence = Sequence::default();
            let mesh = pile(256);
            let topology = sequence.add_topology(&mesh, &tree(&mesh, 256));
            let pose = sequence.add_pose(topology, &mesh.positions, true);
            let placement = sequence.add_placement(&[(pose, Affine::IDENTITY)]);
            sequence.add_frame(0, None, placement);
            sequence.file()
        }),
        edited(&rules::E0709, |s| {
            s.topologies[0].vertex_count += 1;
            s.blocks.iter_mut().for_each(|(_, vertices)| vertices.push([f32::NAN; 3]));
        }),
        edited(&rules::W0701, |s| _ = s.add_placement(&[(0, Affine::translation([0.0, 1.0, 0.25]))])),
        edited(&rules::W0702, |s| (s.frames[1].flags, s.frames[1].time) = (FrameRecord::TIMED, 1.0)),
        // Rules of still files, where a sequence has other records.
        case("sequence-numbers", broken(&rules::E0125, refix(numbered))),
        case("sequence-tris", broken(&rules::E0125, with_entry(tris, SectionKind::TRIS, |e| e.elem_size = 48))),
        case("sequence-bit", head(&rules::E0126, |h| h.features_required = 0)),
        case("sequence", head(&rules::E0301, |h| h.node_count += 1)),
        case("sequence", head(&rules::E0302, |h| h.ref_count += 1)),
        case("sequence", head(&rules::E0304, |h| h.blas_count += 1)),
        case("sequence", head(&rules::E0305, |h| h.instance_count -= 1)),
        case("sequence", head(&rules::E0307, |h| h.scene_max[2] = h.scene_max[2].next_down())),
        case("sequence", head(&rules::E0308, |h| h.frame_count += 1)),
        case("sequence", edited(&rules::E0416, |s| s.triangles[3].geom = 1)),
        case("sequence", edited(&rules::E0419, |s| s.blocks[1].1[0][2] += 8.0)),
        case("sequence", edited(&rules::E0427, |s| s.poses[1].sah = s.poses[1].sah.next_up())),
        case("sequence", {
            let mut sequence = sequences::rebuilt();
            // One of two instances of the pile.
            let other = sequence.placements[1].1.iter_mut().find(|instance| instance.blas == 1).unwrap();
            other.blas = 3;
            broken(&rules::E0503, sequence.file())
        }),
        case(
            "sequence",
            edited(&rules::W0502, |s| {
                let positions = sequences::wave(2, 0.25);
                s.add_pose(0, &positions, false);
            }),
        ),
        case("sequence-short", {
            let mut sequence = sequences::origins();
            sequence.vertices.pop();
            broken(&rules::E0321, sequence.file())
        }),
        case("version-of-codec", {
            let file = sequences::walk().differences();
            broken(&rules::E0130, with_header(file, |h| h.min_minor = 2))
        }),
        case("differences-in-still-file", {
            let file = with_entry(valid::plane_file(), SectionKind::NODE, |e| e.codec = SectionEntry::DELTA);
            broken(&rules::E0115, with_header(file, |h| (h.minor, h.min_minor) = (3, 3)))
        }),
        case("differences-of-others", {
            let file =
                with_entry(sequences::walk().differences(), SectionKind::POSE, |e| e.codec = SectionEntry::DELTA);
            broken(&rules::E0115, file)
        }),
        case("differences-short", broken(&rules::E0205, repacked(SectionKind::VPOS, |planes| _ = planes.pop()))),
        case("differences-scale", broken(&rules::E0205, repacked(SectionKind::VPOS, |planes| planes[7] = 0x80))),
        case("differences-leaf", {
            // The lowest byte of `first`, of a node in the middle of the first tree.
            broken(&rules::E0205, repacked(SectionKind::NODE, |planes| planes[120] = planes[120].wrapping_add(101)))
        }),
        case("differences-other", broken(&rules::E0202, repacked(SectionKind::VPOS, |planes| planes[8] ^= 2))),
        case("differences-corner", broken(&rules::E0202, repacked(SectionKind::TRIX, |planes| planes[0] ^= 2))),
        // A vertex of the source that stands in two places in the second frame alone.
        case("second-frame", broken(&rules::E0323, parted())),
        case("held-first", edited(&rules::E0703, |s| s.frames[0].flags = FrameRecord::HELD)),
        case("held-other", edited(&rules::E0703, |s| s.frames[1].flags = FrameRecord::HELD)),
        case("time-unsaid", edited(&rules::E0703, |s| s.frames[1].time = 1.0)),
        case(
            "empty",
            edited(&rules::E0708, |s| {
                s.topologies.push(TopologyRecord { ref_offset: 8, ..Zeroable::zeroed() });
                s.topologies[1].flags = tree_flags::REFITTABLE;
                s.poses.push(PoseRecord {
                    topology: 1,
                    block: 1,
                    node_offset: 16,
                    vertex_offset: 9,
                    ..Zeroable::zeroed()
                });
            }),
        ),
        case("parts", {
            // One leaf, whose topology has one part more than triangles would find room.
            let mut sequence = sequences::empty_frame();
            let part = sequence.geoms[0];
            sequence.geoms.extend([GeomRecord { prim_count: 0, kept_count: 0, name_hash: [0; 32], ..part }; 255]);
            sequence.names.extend(vec![String::new(); 255]);
            broken(&rules::E0708, sequence.file())
        }),
    ]
}

/// A file of differences, of which the packed bytes of the first section of a kind were edited.
pub(super) fn repacked(kind: SectionKind, edit: fn(&mut Vec<u8>)) -> Vec<u8> {
    let done = std::cell::Cell::new(false);
    sequences::walk().differences_edited(|of, planes| {
        if of == kind && !done.replace(true) {
            edit(planes);
        }
    })
}

/// Two poses whose trees are sound and whose leaves have other sizes.
pub(super) fn other_leaves() -> Vec<u8> {
    let mesh = sequences::grid(2);
    let bounds = |triangles: std::ops::Range<usize>| {
        triangles.fold(bvhc::geom::Aabb::EMPTY, |b, i| b.union(mesh.triangle_box(i)))
    };
    let leaves = |first: usize| {
        let at =
            |range: std::ops::Range<usize>| Node::leaf(bounds(range.clone()), range.start as u32, range.len() as u32);
        let nodes = vec![Node::inner(bounds(0..8), 2), zero_node(), at(0..first), at(first..8)];
        Tree { nodes, refs: (0..8).collect() }
    };
    let mut sequence = Sequence::default();
    let topology = sequence.add_topology(&mesh, &leaves(3));
    for number in 0..2 {
        let pose = sequence.add_pose(topology, &mesh.positions, true);
        let placement = sequence.add_placement(&[(pose, Affine::IDENTITY)]);
        sequence.add_frame(number, None, placement);
    }
    sequence.blocks[0].0[4..].copy_from_slice(&leaves(4).nodes);
    sequence.restate_sah();
    sequence.file()
}

/// Two triangles that share a vertex of the source, as `VERT` says, and part in the second frame.
pub(super) fn parted() -> Vec<u8> {
    let mesh = scenes::soup(
        "two",
        &[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]],
    );
    let mut sequence = Sequence::default();
    let topology = sequence.add_topology(&mesh, &tree(&mesh, 1));
    for (number, x) in [(0, 0.0), (1, -0.25)] {
        let mut positions = mesh.positions.clone();
        positions[3][0] = x;
        let pose = sequence.add_pose(topology, &positions, number == 0);
        let placement = sequence.add_placement(&[(pose, Affine::IDENTITY)]);
        sequence.add_frame(number, None, placement);
    }
    sequence.vertices = sequence.triangles.iter().map(|t| [[7, 8, 9], [7, 4, 5]][t.prim as usize]).collect();
    sequence.file()
}
