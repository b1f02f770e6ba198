//! Files with compact trees: sound ones, and one for each way in which one is not the binary tree beside it.

use bvhc::cache::rules::{self, Rule};
use bvhc::cache::{CompactNode, Image, SectionKind, section_flags};
use bvhc::trace::wide::CompactTrees;

use super::bytes::{self, file, put_together, take_apart};
use super::invalid::{Invalid, broken, image};
use super::scenes::{one_level, sheet, tree};
use super::sequences;

/// 128 triangles with compact trees beside the binary ones: several nodes, some of whose lanes are empty.
pub fn flat() -> Image {
    let mesh = sheet(8, 0.0);
    let tree = tree(&mesh, 1);
    added(one_level(mesh, tree))
}

pub fn added(mut image: Image) -> Image {
    image.add_compact().expect("trees");
    image
}

/// The planes of one row in all lanes that are used.
fn used(trees: &mut CompactTrees, row: usize) -> impl Iterator<Item = &mut u8> {
    trees.nodes.iter_mut().flat_map(move |node| node.planes[row].iter_mut().take(usize::from(node.children)))
}

/// Compact trees that are not the binary ones beside them.
pub fn all() -> Vec<Invalid> {
    let edited = |rule: &'static Rule, edit: fn(&mut CompactTrees)| {
        image(rule, flat(), |i| edit(i.compact.as_mut().expect("compact trees")))
    };
    let case = |case, invalid: Invalid| Invalid { case, ..invalid };
    let (header, mut without_rows) = take_apart(&file(&flat()));
    without_rows.retain(|(e, _)| e.kind != SectionKind::CROW);
    let of_sequence = bytes::with_section(&sequences::refitted().file(), *b"CREF", section_flags::COPY_SAFE, &[]);
    let of_sequence = bytes::with_entry(of_sequence, SectionKind::CREF, |e| e.elem_size = 4);
    vec![
        edited(&rules::E0326, |c| c.order.truncate(c.order.len() - 1)),
        case("no-rows", broken(&rules::E0326, put_together(header, without_rows))),
        edited(&rules::E0327, |c| c.rows[0].node_offset = 1),
        case("waiting", edited(&rules::E0327, |c| c.rows[0].waiting += 1)),
        case("left-over", edited(&rules::E0327, |c| c.nodes.push(c.nodes[0]))),
        edited(&rules::E0429, |c| c.nodes[0].children = 9),
        case("one-child", edited(&rules::E0429, |c| c.nodes[0].children = 1)),
        case(
            "unused-lane",
            edited(&rules::E0429, |c| {
                let some = c.nodes.iter_mut().find(|node| node.children < 8).expect("a node with an empty lane");
                some.planes[4][7] = 1;
            }),
        ),
        edited(&rules::E0430, |c| c.nodes[0].first_node += 1),
        case(
            "cycle",
            edited(&rules::E0430, |c| {
                let inner = |n: &&mut CompactNode| n.counts[..usize::from(n.children)].contains(&0);
                c.nodes.iter_mut().rfind(inner).expect("a node with a child").first_node = 0;
            }),
        ),
        case(
            "beyond",
            edited(&rules::E0430, |c| {
                c.nodes.pop();
                c.rows[0].node_count -= 1;
            }),
        ),
        case("references", edited(&rules::E0430, |c| c.nodes.last_mut().expect("a node").counts[0] += 1)),
        edited(&rules::E0431, |c| {
            for node in &mut c.nodes {
                if let Some(lane) = (0..7).find(|lane| node.counts[*lane] > 0 && node.counts[lane + 1] > 1) {
                    (node.counts[lane], node.counts[lane + 1]) = (node.counts[lane] + 1, node.counts[lane + 1] - 1);
                    return;
                }
            }
            panic!("no two leaves stand side by side");
        }),
        edited(&rules::E0432, |c| {
            let far = &mut c.nodes[0].planes[3];
            let lane = far.iter().position(|plane| *plane > 0).expect("a plane that can be moved inward");
            far[lane] -= 1;
        }),
        case("not-finite", edited(&rules::E0432, |c| c.nodes[0].origin[1] = f32::NAN.to_bits())),
        case("huge-step", edited(&rules::E0432, |c| c.nodes[0].exponents[0] = 255)),
        edited(&rules::E0433, |c| c.order.swap(0, 1)),
        case("out-of-range", edited(&rules::E0433, |c| c.order[5] = u32::MAX)),
        edited(&rules::E0435, |c| {
            *used(c, 3).find(|far| **far < u8::MAX).expect("a plane that can be moved outward") += 1
        }),
        case(
            "near",
            edited(&rules::E0435, |c| *used(c, 0).find(|near| **near > 0).expect("a plane above the first") -= 1),
        ),
        case(
            "coarse",
            edited(&rules::E0435, |c| {
                let node = &mut c.nodes[0];
                node.exponents[0] += 1;
                node.planes[0].iter_mut().for_each(|near| *near /= 2);
                node.planes[3].iter_mut().for_each(|far| *far = far.div_ceil(2));
            }),
        ),
        case(
            "origin",
            edited(&rules::E0435, |c| {
                let node = c.nodes.iter_mut().find(|node| node.planes[3].iter().all(|far| *far < u8::MAX));
                let node = node.expect("a node that leaves the last plane free");
                node.origin[0] = (node.corner(0) - node.scale(0)).to_bits();
                for row in [0, 3] {
                    node.planes[row][..usize::from(node.children)].iter_mut().for_each(|plane| *plane += 1);
                }
            }),
        ),
        case(
            "no-step",
            edited(&rules::E0435, |c| {
                let flat = (0..3).find(|axis| c.nodes[0].exponents[*axis] == 0).expect("the sheet is flat");
                c.nodes[0].planes[flat][0] = 1;
            }),
        ),
        case("compact-in-sequence", broken(&rules::E0125, of_sequence)),
    ]
}
