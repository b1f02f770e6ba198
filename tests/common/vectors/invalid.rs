//! For each rule a file that breaks it, every hash made right again, so that nothing else can be found.

use bvhc::cache::check::{Level, Limits, Report, Source, check_bytes};
use bvhc::cache::rules::{self, Rule};
use bvhc::cache::{
    Codec, FrameRecord, GeomRecord, Header, Image, InstanceRecord, Meta, NO_NODE, PoseRecord, SectionEntry,
    SectionKind, TopologyRecord, TriangleRecord, WriteOptions, section_flags, to_bytes, tree_flags,
};
use bvhc::exec::Executor;
use bvhc::geom::Affine;
use bvhc::scene::{Instance, Mesh};
use bvhc::tree::{Accel, Node, Tree};
use bytemuck::Zeroable;

use super::branches;
use super::bytes::{self, file, put_together, refix, sign, take_apart, with_entry, with_header};
use super::scenes::{self, comb, cut_in_two, one_level, pile, restate_sah, sheet, tree, two_level};
use super::sequences::{self, Sequence};
use super::{compact, valid};

/// A file that breaks one rule.
pub struct Invalid {
    pub rule: &'static Rule,
    /// What is special about it; empty for the one plain file of the rule.
    pub case: &'static str,
    pub bytes: Vec<u8>,
    /// Its bytes depend on the compressor's version.
    pub packed: bool,
    /// What is compared at source level; empty for the other rules.
    pub source: Option<Model>,
    pub limits: Limits,
}

impl Invalid {
    /// The check that must find this rule and no other.
    pub fn check(&self) -> Report {
        match &self.source {
            None => check_bytes(&self.bytes, Level::Tree, None, &self.limits, &Executor::current()),
            Some(model) => {
                let (inputs, instances) = (scenes::inputs(), model.instances.as_deref());
                let source = Source { meshes: &model.meshes, instances, inputs: &inputs };
                check_bytes(&self.bytes, Level::Source, Some(&source), &self.limits, &Executor::current())
            }
        }
    }
}

/// What a source model holds.
pub struct Model {
    pub meshes: Vec<Mesh>,
    pub instances: Option<Vec<Instance>>,
}

/// One file for each rule of the catalogue and some further ones, in no order.
pub fn all() -> Vec<Invalid> {
    let groups = [
        container(),
        hashes(),
        counts(),
        topology(),
        triangles(),
        compact::all(),
        instances(),
        source(),
        sequence(),
        cases(),
        branches::all(),
    ];
    groups.into_iter().flatten().collect()
}

pub(super) fn broken(rule: &'static Rule, bytes: Vec<u8>) -> Invalid {
    Invalid { rule, case: "", bytes, packed: false, source: None, limits: Limits::default() }
}

fn plane() -> Vec<u8> {
    file(&valid::plane())
}

fn container() -> Vec<Invalid> {
    let head = |rule, edit: fn(&mut Header)| broken(rule, with_header(plane(), edit));
    let node = |rule, edit: fn(&mut SectionEntry)| broken(rule, with_entry(plane(), SectionKind::NODE, edit));
    let mut text_mode = plane();
    text_mode.splice(4..6, [b'\n']);
    let mut padding = plane();
    *padding.last_mut().unwrap() = 1;
    let mut longer = plane();
    longer.extend([0; 64]);
    let longer = with_header(longer, |h| h.file_len += 64);
    let (header, mut without_geom) = take_apart(&plane());
    without_geom.remove(2);
    let twice = bytes::stored(&mut plane(), SectionKind::META).to_vec();
    vec![
        broken(&rules::E0101, plane()[..200].to_vec()),
        broken(&rules::E0102, text_mode),
        head(&rules::E0103, |h| h.major = 2),
        head(&rules::E0104, |h| (h.minor, h.min_minor) = (bvhc::cache::MINOR + 1, bvhc::cache::MINOR + 1)),
        head(&rules::E0105, |h| h.header_len = 192),
        head(&rules::E0106, |h| h.file_len += 64),
        head(&rules::E0107, |h| h.features_required = 1 << 9),
        head(&rules::E0108, |h| h.section_count = 65_537),
        head(&rules::E0109, |h| h.section_entry_len = 64),
        head(&rules::E0110, |h| h.section_table_off = 320),
        head(&rules::E0111, |h| h.reserved[3] = 1),
        node(&rules::E0112, |e| e.reserved[11] = 1),
        broken(
            &rules::E0113,
            bytes::with_section(&plane(), *b"WARP", section_flags::CRITICAL, b"no reader knows this"),
        ),
        node(&rules::E0114, |e| e.schema = 2),
        node(&rules::E0115, |e| e.codec = 7),
        node(&rules::E0116, |e| e.align_log2 = 5),
        broken(
            &rules::E0117,
            with_entry(plane(), SectionKind::META, |e| {
                e.stored_len += 4096;
                e.raw_len += 4096;
            }),
        ),
        node(&rules::E0118, |e| {
            e.stored_len += 64;
            e.raw_len += 64;
            e.elem_count += 2;
        }),
        broken(&rules::E0119, padding),
        broken(&rules::E0120, longer),
        broken(&rules::E0121, bytes::with_section(&plane(), *b"META", section_flags::COPY_SAFE, &twice)),
        node(&rules::E0122, |e| {
            e.elem_size = 64;
            e.elem_count /= 2;
        }),
        node(&rules::E0123, |e| e.elem_count += 1),
        node(&rules::E0124, |e| e.flags |= section_flags::COPY_SAFE),
        broken(&rules::E0125, put_together(header, without_geom)),
        head(&rules::E0126, |h| h.tree_flags |= 1 << 10),
        Invalid {
            packed: true,
            limits: Limits { max_memory: 1000, ..Limits::default() },
            ..broken(&rules::E0127, valid::packed())
        },
        head(&rules::E0128, |h| h.min_minor = 1),
        broken(
            &rules::E0129,
            with_entry(plane(), SectionKind::META, |e| {
                e.codec = SectionEntry::ZSTD;
                e.raw_len = (1 << 20) + 1;
            }),
        ),
        broken(&rules::W0101, valid::unknown_ancillary()),
    ]
}

fn hashes() -> Vec<Invalid> {
    let packed = |rule, bytes| Invalid { packed: true, ..broken(rule, bytes) };
    let mut flipped = plane();
    bytes::stored(&mut flipped, SectionKind::NODE)[5] ^= 0x10;
    let mut header_flipped = plane();
    header_flipped[60] ^= 0x40;
    let mut content = bytes::header(&plane());
    content.content_id[0] ^= 1;
    let mut other_content = plane();
    bytes::set_header(&mut other_content, &content);
    let mut garbled = valid::packed();
    bytes::stored(&mut garbled, SectionKind::TRIS)[8] ^= 1; // the length of the first frame
    let longer = |kind| {
        let (header, mut sections) = take_apart(&plane());
        sections.iter_mut().filter(|(e, _)| e.kind == kind).for_each(|(_, data)| data.push(0));
        put_together(header, sections)
    };
    let mut absolute = plane();
    replace(bytes::stored(&mut absolute, SectionKind::META), b"vector.obj", b"/ector.obj");
    let mut names = file(&valid::parts());
    bytes::stored(&mut names, SectionKind::NAMS)[8] = 200; // where the first name ends
    let mut materials = file(&valid::origins());
    bytes::stored(&mut materials, SectionKind::MATS)[8] = 200;
    vec![
        broken(&rules::E0201, flipped),
        packed(&rules::E0202, with_entry(valid::packed(), SectionKind::TRIS, |e| e.raw_hash[0] ^= 1)),
        broken(&rules::E0203, header_flipped),
        broken(&rules::E0204, sign(other_content)),
        packed(&rules::E0205, refix(garbled)),
        broken(&rules::E0206, longer(SectionKind::META)),
        broken(&rules::E0207, with_header(plane(), |h| h.build_key[0] ^= 1)),
        broken(&rules::E0208, refix(names)),
        broken(&rules::E0209, refix(absolute)),
        broken(&rules::E0210, refix(materials)),
    ]
}

/// Overwrite the first place where `old` stands.
pub(super) fn replace(bytes: &mut [u8], old: &[u8], new: &[u8]) {
    let at = bytes.windows(old.len()).position(|w| w == old).unwrap();
    bytes[at..at + new.len()].copy_from_slice(new);
}

/// A file made from an edited image; the SAH follows the edit.
pub(super) fn image(rule: &'static Rule, mut image: Image, edit: impl FnOnce(&mut Image)) -> Invalid {
    edit(&mut image);
    restate_sah(&mut image);
    broken(rule, file(&image))
}

fn counts() -> Vec<Invalid> {
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

fn origins(rule: &'static Rule, edit: fn(&mut Image)) -> Invalid {
    image(rule, valid::origins(), edit)
}

fn zero_node() -> Node {
    Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 }
}

/// The two-level file without its top level, everything else made to agree.
fn without_top() -> Vec<u8> {
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

fn topology() -> Vec<Invalid> {
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

fn triangles() -> Vec<Invalid> {
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

fn instances() -> Vec<Invalid> {
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

/// The model of the source rules: eight triangles, of which the last was dropped.
fn seven() -> Mesh {
    let mut mesh = sheet(2, 0.0);
    mesh.triangles.truncate(7);
    mesh.source_prims = (0..7).collect();
    mesh.parts[0].triangle_count = 7;
    mesh
}

fn source() -> Vec<Invalid> {
    let against = |rule, bytes, mesh| Invalid {
        source: Some(Model { meshes: vec![mesh], instances: None }),
        ..broken(rule, bytes)
    };
    let made_from = |mesh: Mesh| {
        let tree = tree(&mesh, 1);
        file(&one_level(mesh, tree))
    };
    let mut six = seven();
    six.triangles.truncate(6);
    six.source_prims.truncate(6);
    six.parts[0].triangle_count = 6;
    let mut moved = seven();
    moved.positions[4][2] += 0.5;
    let mut other_part = seven();
    other_part.parts[0].source_part = 3;
    let accel: Accel = scenes::two_level_accel();
    let mut other_node = accel.clone();
    other_node.instances[3].node = 77;
    let mut meta = scenes::meta();
    meta.dependencies[0].len += 1;
    let tree_of_seven = tree(&seven(), 1);
    let other_input =
        to_bytes(&one_level(seven(), tree_of_seven), &meta, &WriteOptions::default(), &Executor::current()).unwrap();
    let mut numbered = seven();
    numbered.vertices.clone_from(&numbered.triangles);
    let mut misnumbered = numbered.clone();
    misnumbered.vertices[2] = [90, 91, 92];
    vec![
        against(&rules::E0607, made_from(misnumbered), numbered),
        against(&rules::E0601, made_from(six), seven()),
        against(&rules::E0602, made_from(sheet(2, 0.0)), seven()),
        against(&rules::E0603, made_from(moved), seven()),
        against(&rules::E0604, made_from(other_part), seven()),
        Invalid {
            source: Some(Model { meshes: accel.meshes, instances: Some(accel.instances) }),
            ..broken(&rules::E0605, file(&Image::new(&other_node, &Executor::current()).unwrap()))
        },
        against(&rules::E0606, other_input, seven()),
    ]
}

fn sequence() -> Vec<Invalid> {
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
fn repacked(kind: SectionKind, edit: fn(&mut Vec<u8>)) -> Vec<u8> {
    let done = std::cell::Cell::new(false);
    sequences::walk().differences_edited(|of, planes| {
        if of == kind && !done.replace(true) {
            edit(planes);
        }
    })
}

/// Two poses whose trees are sound and whose leaves have other sizes.
fn other_leaves() -> Vec<u8> {
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
fn parted() -> Vec<u8> {
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

/// Files that break a rule in a way that is easily overlooked.
fn cases() -> Vec<Invalid> {
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
fn skewed_instance() -> Instance {
    let rows = [[1e4, 1e4, 0.0, 0.0], [1e4, f64::from(1e4f32.next_up()), 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    Instance { mesh: 0, transform: Affine { rows }, node: 0, name: String::new() }
}

/// A matrix of which `f64` cannot tell the inverse: its rows differ in their last bits, and the determinant is 2⁻⁴⁸.
fn needle() -> Instance {
    let u = f64::from(1f32.next_down());
    let rows = [[1.0, 1.0, 1.0, 0.0], [1.0, u, 1.0, 0.0], [1.0, 1.0, u, 0.0]];
    Instance { mesh: 0, transform: Affine { rows }, node: 0, name: String::new() }
}

/// Fit inner nodes to their children.
fn refit(nodes: &mut [Node]) {
    for n in (0..nodes.len()).rev().filter(|n| *n != 1) {
        let first = nodes[n].first as usize;
        if !nodes[n].is_leaf() {
            let bounds = nodes[first].bounds().union(nodes[first + 1].bounds());
            (nodes[n].min, nodes[n].max) = (bounds.min, bounds.max);
        }
    }
}

/// Let a leaf reach further to where its sibling ends.
pub(super) fn loosen(nodes: &mut [Node]) {
    let wanted = (2..nodes.len()).flat_map(|n| (0..3).map(move |axis| (n, axis)));
    let small = |(n, axis): &(usize, usize)| nodes[*n].is_leaf() && nodes[*n].max[*axis] < nodes[*n ^ 1].max[*axis];
    let (leaf, axis) = wanted.into_iter().find(small).unwrap();
    nodes[leaf].max[axis] = nodes[leaf].max[axis].next_up();
}

/// Triangles of [`bomb`].
const BOMB: u32 = 1 << 19;

/// Eight nodes and half a million triangles, all zero: a few kilobytes that decode to 24 MB. `stated` is what the row of BLAS says.
fn bomb(stated: u32) -> Vec<u8> {
    let mut image = valid::plane();
    image.triangles = vec![Zeroable::zeroed(); BOMB as usize];
    image.blases[0].ref_count = stated;
    let options = WriteOptions { codec: Codec::Zstd { level: 3 }, check: false };
    to_bytes(&image, &scenes::meta(), &options, &Executor::current()).unwrap()
}

/// NAMS with empty names alone, which is left out where no part has a name.
fn names_of_nobody() -> Vec<u8> {
    let mesh = scenes::soup("", &[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    let tree = tree(&mesh, 1);
    let names: [u8; 12] = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let added = bytes::with_section(&file(&one_level(mesh, tree)), *b"NAMS", section_flags::COPY_SAFE, &names);
    with_entry(added, SectionKind::NAMS, |e| e.elem_count = 1)
}

/// MATS with empty names alone, which is left out where no part has a material.
fn materials_of_nobody() -> Vec<u8> {
    let names: [u8; 12] = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let flags = section_flags::COPY_SAFE | section_flags::CONTENT;
    let added = bytes::with_section(&plane(), *b"MATS", flags, &names);
    with_entry(added, SectionKind::MATS, |e| e.elem_count = 1)
}

/// A file of a model whose part is another one in what no row of GEOM says.
fn other_origin(edit: fn(&mut bvhc::scene::Part)) -> Invalid {
    let mut mesh = seven();
    mesh.parts[0].baked_node = Some(2);
    let tree = tree(&mesh, 1);
    let file = file(&one_level(mesh.clone(), tree));
    edit(&mut mesh.parts[0]);
    Invalid { source: Some(Model { meshes: vec![mesh], instances: None }), ..broken(&rules::E0604, file) }
}

/// Four leaves that hold the corners, the edges and the middle of a triangle, and not a square inside.
fn square_inside() -> Image {
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

/// Pairs that share their children: see `E0404`.
pub fn ladder() -> Vec<u8> {
    let (mesh, _) = comb(2);
    let bounds = mesh.triangle_box(0);
    let mut nodes = vec![Node::inner(bounds, 2), zero_node()];
    for step in 1..65 {
        nodes.extend([Node::inner(bounds, 2 * step + 2); 2]);
    }
    nodes.extend([Node::leaf(bounds, 0, 1), Node::leaf(bounds, 1, 1)]);
    let mut image = one_level(mesh.clone(), tree(&mesh, 1));
    image.blases[0].node_count = nodes.len() as u32;
    image.blases[0].max_depth = 64;
    image.nodes = nodes;
    restate_sah(&mut image);
    file(&image)
}
