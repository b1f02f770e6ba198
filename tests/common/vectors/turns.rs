//! Files with turned subtrees: sound ones, and one for each way in which one is not what lies below a node of the tree.

use bvhc::cache::rules::{self, Rule};
use bvhc::cache::{Image, SectionKind, TurnRecord, section_flags};
use bvhc::exec::Executor;
use bvhc::trace::Turns;

use super::bytes::{self, file, put_together, take_apart};
use super::invalid::{Invalid, broken, image};
use super::scenes::{one_level, sheet, tree, two_level};
use super::{sequences, valid};

/// A turn about z by the angle of the triangle with sides 3, 4 and 5, and one about x.
const AXES: [[[f32; 3]; 3]; 2] =
    [[[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, -0.8, 0.6]]];

/// 128 triangles; all is turned below the root's first child, and once more in there, and below the second child.
pub fn flat() -> Image {
    let mesh = sheet(8, 0.0);
    let tree = tree(&mesh, 1);
    let image = one_level(mesh, tree);
    let first = image.nodes[0].first as usize;
    let within = image.nodes[first].first as usize;
    turned(image, &[first, within, first + 1])
}

/// Boxes along other axes of parts of triangles.
pub fn cut() -> Image {
    turned(valid::duplicates(), &[0])
}

fn turned(mut image: Image, nodes: &[usize]) -> Image {
    let mut rows: Vec<TurnRecord> = (nodes.iter().enumerate())
        .map(|(i, node)| TurnRecord {
            axes: AXES[i % 2],
            first: image.nodes[*node].first,
            end: end(&image, *node),
            node_offset: 0,
            reserved: [0; 4],
        })
        .collect();
    rows.sort_by_key(|row| row.first);
    let tree = image.view().blas(0).expect("a tree");
    let turns = Turns::new(&tree, rows, &Executor::current()).expect("nodes of the tree");
    image.turns = Some(turns);
    image
}

/// Behind the last record below a node.
fn end(image: &Image, node: usize) -> u32 {
    let record = image.nodes[node];
    assert!(!record.is_leaf(), "node {node} has children");
    let first = record.first as usize;
    let below = [first, first + 1].into_iter().filter(|child| !image.nodes[*child].is_leaf());
    below.map(|child| end(image, child)).fold(record.first + 2, u32::max)
}

/// Turned subtrees that are not those of the tree.
pub fn all() -> Vec<Invalid> {
    let edited = |rule: &'static Rule, edit: fn(&mut Turns)| {
        image(rule, flat(), |i| edit(i.turns.as_mut().expect("turned subtrees")))
    };
    let case = |case, invalid: Invalid| Invalid { case, ..invalid };
    let (header, mut without_rows) = take_apart(&file(&flat()));
    without_rows.retain(|(e, _)| e.kind != SectionKind::OROW);
    let of_sequence = bytes::with_section(&sequences::refitted().file(), *b"ONOD", section_flags::COPY_SAFE, &[]);
    let of_sequence = bytes::with_entry(of_sequence, SectionKind::ONOD, |e| e.elem_size = 32);
    let two_levels = Image { turns: flat().turns, ..two_level() };
    vec![
        edited(&rules::E0329, |t| t.nodes.truncate(t.nodes.len() - 1)),
        case("no-turns", broken(&rules::E0329, put_together(header, without_rows))),
        case("turns-of-two-levels", broken(&rules::E0329, file(&two_levels))),
        edited(&rules::E0330, |t| t.rows[0].first += 1),
        case("turn-end", edited(&rules::E0330, |t| t.rows[1].end += 2)),
        case("turn-offset", edited(&rules::E0330, |t| t.rows[1].node_offset += 2)),
        case("turn-order", edited(&rules::E0330, |t| t.rows.swap(1, 2))),
        case("turn-reserved", edited(&rules::E0330, |t| t.rows[0].reserved[3] = 1)),
        case("turn-nest", {
            let mut deep = flat();
            let mut nodes = vec![0];
            for _ in 0..3 {
                nodes.push(deep.nodes[*nodes.last().expect("a node")].first as usize);
            }
            deep.turns = None;
            broken(&rules::E0330, file(&turned(deep, &nodes)))
        }),
        edited(&rules::E0436, |t| t.rows[0].axes[0] = [0.6, 0.7, 0.0]),
        case("turn-skew", edited(&rules::E0436, |t| t.rows[0].axes[0] = t.rows[0].axes[1])),
        case("turn-not-finite", edited(&rules::E0436, |t| t.rows[0].axes[2][1] = f32::NAN)),
        edited(&rules::E0437, |t| t.nodes[0].first += 2),
        case("turn-count", edited(&rules::E0437, |t| t.nodes.last_mut().expect("a leaf").count += 1)),
        edited(&rules::E0438, |t| t.nodes[0].max[1] = t.nodes[0].max[1].next_down()),
        case(
            "turn-leaf",
            edited(&rules::E0438, |t| {
                let leaf = t.nodes.iter_mut().rfind(|node| node.is_leaf()).expect("a leaf");
                leaf.min[0] += 0.25 * (leaf.max[0] - leaf.min[0]);
            }),
        ),
        case("turn-box-not-finite", edited(&rules::E0438, |t| t.nodes[1].min[0] = f32::NAN)),
        edited(&rules::E0439, |t| t.nodes[0].max[1] = t.nodes[0].max[1].next_up()),
        case("turn-infinite", edited(&rules::E0439, |t| t.nodes[1].max[2] = f32::INFINITY)),
        case("turned-in-sequence", broken(&rules::E0125, of_sequence)),
    ]
}
