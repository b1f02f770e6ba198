//! Rules that are asked in several places, or of several fields: a file for each place that the plain file of the rule does not reach.

use bvhc::cache::rules::{self, Rule};
use bvhc::cache::{FrameRecord, Header, Image, SectionKind, tree_flags};
use bvhc::tree::Node;
use bytemuck::Zeroable;

use super::bytes::{file, refix, stored, with_entry, with_header};
use super::invalid::{Invalid, broken, image, loosen, replace};
use super::scenes::{one_level, sheet, tree, two_level};
use super::sequences::{self, Sequence};
use super::valid;

/// The files, in no order.
pub fn all() -> Vec<Invalid> {
    let mut all = of_sequences();
    all.extend(of_still_files());
    all.extend(of_top_levels());
    all
}

fn named(case: &'static str, invalid: Invalid) -> Invalid {
    Invalid { case, ..invalid }
}

fn of_sequences() -> Vec<Invalid> {
    let head =
        |case, rule, edit: fn(&mut Header)| named(case, broken(rule, with_header(sequences::refitted().file(), edit)));
    let made = |case, rule: &'static Rule, mut sequence: Sequence, edit: fn(&mut Sequence)| {
        edit(&mut sequence);
        named(case, broken(rule, sequence.file()))
    };
    let edited = |case, rule, edit: fn(&mut Sequence)| made(case, rule, sequences::refitted(), edit);
    vec![
        head("sequence", &rules::E0303, |h| h.prim_count += 1),
        head("sequence", &rules::E0306, |h| h.max_depth += 1),
        head("sequence", &rules::E0309, |h| h.tree_flags ^= tree_flags::DUP_REFS | tree_flags::REFITTABLE),
        edited("sequence", &rules::E0315, |s| s.geoms[0].reserved = 1),
        edited("sequence", &rules::E0319, |s| s.topologies[0].prim_count += 1),
        edited("end", &rules::E0701, |s| s.triangles.push(s.triangles[0])),
        edited("topology", &rules::E0702, |s| s.poses[1].topology = 9),
        edited("block", &rules::E0702, |s| s.poses[1].block += 1),
        made("not-a-number", &rules::E0703, sequences::rebuilt(), |s| s.frames[1].time = f32::NAN),
        edited("pose-flags", &rules::E0706, |s| s.poses[1].flags |= 4),
        edited("pose", &rules::E0706, |s| s.poses[1].reserved[1] = 1),
        edited("frame-flags", &rules::E0706, |s| s.frames[1].flags |= 8),
        edited("frame", &rules::E0706, |s| s.frames[1].reserved[3] = 1),
        made("falls", &rules::W0702, sequences::rebuilt(), |s| s.frames[2].time = 0.25),
        edited("held", &rules::W0702, |s| {
            let frame = FrameRecord { number: s.frames[1].number + 1, time: 1.0, ..s.frames[1] };
            s.frames.push(FrameRecord { flags: FrameRecord::TIMED | FrameRecord::HELD, ..frame });
        }),
    ]
}

fn of_still_files() -> Vec<Invalid> {
    let edited = |case, rule, edit: fn(&mut Image)| named(case, image(rule, valid::plane(), edit));
    let order = with_header(file(&valid::plane()), |h| h.tree_flags &= !tree_flags::CANONICAL_DFS);
    let mesh = sheet(2, 0.0);
    let leaves = tree(&mesh, 2);
    let cells = one_level(mesh, leaves);
    let parts = || file(&valid::parts());
    let mut garbled = parts();
    replace(stored(&mut garbled, SectionKind::NAMS), "ä".as_bytes(), &[0xc3, 0x28]);
    vec![
        named("order", broken(&rules::E0126, order)),
        named("text", broken(&rules::E0208, refix(garbled))),
        named("entry", broken(&rules::E0208, with_entry(parts(), SectionKind::NAMS, |e| e.elem_count += 1))),
        named("range", image(&rules::E0328, valid::parts(), |i| i.geoms[1].source_part = 0)),
        edited("twice", &rules::E0328, |i| {
            i.geoms.push(bvhc::cache::GeomRecord { kept_count: 0, ..i.geoms[0] });
            i.names.push(i.names[0].clone());
        }),
        named(
            "backwards",
            image(&rules::E0328, valid::parts(), |i| {
                (i.geoms[0].source_part, i.geoms[1].source_part) = (1, 0);
            }),
        ),
        edited("below", &rules::E0415, |i| i.geoms[0].first_prim = 1),
        named("single", image(&rules::E0422, valid::duplicates(), |i| i.triangles[4].flags = 1)),
        named("leaf", image(&rules::E0428, cells, |i| loosen(&mut i.nodes))),
        named("leaf", image(&rules::E0434, valid::duplicates(), |i| i.nodes[3].max[1] += 0.25)),
    ]
}

fn of_top_levels() -> Vec<Invalid> {
    let edited = |case, rule, edit: fn(&mut Image)| {
        let mut image = two_level();
        edit(&mut image);
        named(case, broken(rule, file(&image)))
    };
    vec![
        named("two-level", broken(&rules::E0306, with_header(file(&two_level()), |h| h.max_depth -= 1))),
        edited("top", &rules::E0312, |i| i.tlas_nodes.push(Node::zeroed())),
        edited("top", &rules::E0411, |i| i.tlas_nodes[0].max[2] = i.tlas_nodes[0].max[2].next_down()),
        edited("top", &rules::E0412, |i| {
            let leaf = (2..i.tlas_nodes.len()).find(|&n| i.tlas_nodes[n].is_leaf()).unwrap();
            i.tlas_nodes[leaf].max[0] = f32::INFINITY;
        }),
        edited("top", &rules::E0413, |i| i.tlas_nodes[1].count = 1),
        edited("to-world", &rules::E0501, |i| i.instances[1].object_to_world[5] = f32::INFINITY),
        edited("beyond", &rules::E0504, |i| i.instances[1].id = 5),
        edited("unknown", &rules::E0505, |i| i.instances[1].flags |= 2),
        edited("leaf", &rules::E0508, |i| loosen(&mut i.tlas_nodes)),
    ]
}
