//! For each rule a file that breaks it, every hash made right again, so that nothing else can be found.

mod cases;
mod container;
mod records;
mod sequence;
mod source;

pub(super) use self::cases::loosen;
use self::cases::*;
use self::container::*;
use self::records::*;
use self::sequence::*;
use self::source::*;
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
use super::{compact, turns, valid};

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
                let source = Source { meshes: &model.meshes, instances, inputs: &inputs, report: None };
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
        turns::all(),
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

fn zero_node() -> Node {
    Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 }
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
