//! Prints a cache file byte by byte, each line with the fields that stand in it: the worked example of `format-spec/SPEC.md`.
//!
//! ```text
//! cargo run --example hexdump                # a file with one triangle
//! cargo run --example hexdump -- FILE.bvhc   # any other
//! ```

use std::error::Error;
use std::fmt::Write;

use bvhc::cache::{
    Cache, CacheError, Header, Image, Meta, OpenOptions, SectionEntry, SectionKind, Sequence, Validation, WriteOptions,
    to_bytes,
};
use bvhc::exec::Executor;
use bvhc::geom::Aabb;
use bvhc::scene::{Mesh, Part};
use bvhc::tree::{Accel, Node, Tree};

fn main() -> Result<(), Box<dyn Error>> {
    let bytes = match std::env::args_os().nth(1) {
        Some(path) => std::fs::read(path)?,
        None => one_triangle()?,
    };
    print!("{}", annotate(&bytes)?);
    Ok(())
}

/// The smallest file with something to hit.
pub fn one_triangle() -> Result<Vec<u8>, Box<dyn Error>> {
    let mesh = Mesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        parts: vec![Part { name: "tri".into(), triangle_count: 1, prim_count: 1, ..Part::default() }],
        ..Mesh::default()
    };
    let point = Aabb { min: [0.0; 3], max: [0.0; 3] };
    let tree = Tree { nodes: vec![Node::leaf(mesh.triangle_box(0), 0, 1), Node::leaf(point, 0, 0)], refs: vec![0] };
    let image =
        Image::new(&Accel { meshes: vec![mesh], blases: vec![tree], ..Accel::default() }, &Executor::current())?;
    let meta = Meta {
        tool: "bvhc".into(),
        tool_version: "0.1.0".into(),
        method: "sbvh".into(),
        builder_revision: 1,
        ..Meta::default()
    };
    Ok(to_bytes(&image, &meta, &WriteOptions::default(), &Executor::current())?)
}

pub fn annotate(bytes: &[u8]) -> Result<String, Box<dyn Error>> {
    let options = OpenOptions { validation: Validation::Hash, ..OpenOptions::default() };
    let sections = match Cache::from_bytes(bytes, &options) {
        Err(CacheError::Sequence { .. }) => Sequence::from_slice(bytes, &options)?.sections().to_vec(),
        opened => opened?.sections().to_vec(),
    };
    let mut out = String::new();
    lines(&mut out, bytes, 0, &HEADER);
    for i in 0..sections.len() {
        writeln!(out, "-- entry {i}")?;
        lines(&mut out, bytes, Header::LEN + i * SectionEntry::LEN, &ENTRY);
    }
    for entry in &sections {
        match entry.ordinal {
            0 => writeln!(out, "-- {}", entry.kind)?,
            number => writeln!(out, "-- {} {number}", entry.kind)?,
        }
        let fields: &[Field] = match entry.kind {
            SectionKind::NODE | SectionKind::TNOD => &NODE,
            SectionKind::TRIS => &TRIS,
            SectionKind::GEOM => &GEOM,
            SectionKind::BLAS => &BLAS,
            SectionKind::INST => &INST,
            SectionKind::CROW => &CROW,
            SectionKind::CNOD => &CNOD,
            SectionKind::CREF => &CREF,
            SectionKind::OROW => &OROW,
            SectionKind::ONOD => &NODE,
            SectionKind::VERT => &VERT,
            SectionKind::SIDE => &SIDE,
            SectionKind::TOPO => &TOPO,
            SectionKind::TRIX => &TRIX,
            SectionKind::POSE => &POSE,
            SectionKind::VPOS => &VPOS,
            SectionKind::FRAM => &FRAM,
            _ => &[],
        };
        let (start, end) = (entry.offset as usize, (entry.offset + entry.stored_len) as usize);
        let step = if fields.is_empty() || entry.codec != SectionEntry::RAW { 16 } else { entry.elem_size as usize };
        for at in (start..end).step_by(step) {
            if step == 16 {
                lines(&mut out, bytes, at, &[(16.min(end - at), "")]);
            } else {
                lines(&mut out, bytes, at, fields);
            }
        }
    }
    Ok(out)
}

/// Length and name.
type Field = (usize, &'static str);

/// Sixteen bytes a line at most; fields share a line until it is full.
fn lines(out: &mut String, bytes: &[u8], start: usize, fields: &[Field]) {
    let (mut at, mut line, mut names) = (start, start, Vec::new());
    let mut flush = |line: &mut usize, at: usize, names: &mut Vec<&str>| {
        let hex: String = bytes[*line..at].iter().map(|b| format!("{b:02x} ")).collect();
        let names_text = if names.is_empty() { text(&bytes[*line..at]) } else { names.join(" · ") };
        _ = writeln!(out, "{}", format!("{:04x}  {hex:<49} {names_text}", *line).trim_end());
        (*line, *names) = (at, Vec::new());
    };
    for &(len, name) in fields {
        if at > line && at + len > line + 16 {
            flush(&mut line, at, &mut names);
        }
        names.extend(Some(name).filter(|n| !n.is_empty()));
        let end = at + len;
        while end - line > 16 {
            at = line + 16;
            flush(&mut line, at, &mut names);
            names.push("…");
        }
        at = end;
    }
    flush(&mut line, at, &mut names);
}

fn text(bytes: &[u8]) -> String {
    bytes.iter().map(|&b| if b.is_ascii_graphic() { b as char } else { '.' }).collect()
}

const HEADER: [Field; 27] = [
    (8, "magic"),
    (2, "major"),
    (2, "minor"),
    (2, "min_minor"),
    (2, "header_len"),
    (8, "file_len"),
    (8, "features_required"),
    (8, "features_optional"),
    (4, "section_count"),
    (4, "section_entry_len"),
    (8, "section_table_off"),
    (4, "tree_flags"),
    (4, "builder_id"),
    (32, "file_id"),
    (32, "content_id"),
    (32, "build_key"),
    (8, "prim_count"),
    (8, "ref_count"),
    (8, "node_count"),
    (4, "blas_count"),
    (4, "instance_count"),
    (4, "frame_count"),
    (4, "max_depth"),
    (12, "scene_min"),
    (12, "scene_max"),
    (16, "reserved"),
    (16, "reserved"),
];
const CROW: [Field; 3] = [(8, "node_offset"), (4, "node_count"), (4, "waiting")];
const CNOD: [Field; 12] = [
    (12, "origin"),
    (3, "exponents"),
    (1, "children"),
    (4, "first_node"),
    (4, "first_ref"),
    (8, "counts"),
    (8, "low x"),
    (8, "low y"),
    (8, "low z"),
    (8, "high x"),
    (8, "high y"),
    (8, "high z"),
];
const CREF: [Field; 1] = [(4, "triangle")];
const OROW: [Field; 7] =
    [(12, "axis x"), (12, "axis y"), (12, "axis z"), (4, "first"), (4, "end"), (4, "node_offset"), (16, "reserved")];
const VERT: [Field; 3] = [(4, "v0"), (4, "v1"), (4, "v2")];
const SIDE: [Field; 1] = [(4, "flags")];
const TOPO: [Field; 8] = [
    (8, "ref_offset"),
    (4, "ref_count"),
    (4, "node_count"),
    (4, "vertex_count"),
    (4, "prim_count"),
    (4, "max_depth"),
    (4, "flags"),
    (32, "reserved"),
];
const TRIX: [Field; 4] = [(12, "corners"), (4, "prim"), (4, "geom"), (4, "flags")];
const POSE: [Field; 9] = [
    (12, "min"),
    (4, "topology"),
    (12, "max"),
    (4, "block"),
    (8, "node_offset"),
    (8, "vertex_offset"),
    (4, "sah"),
    (4, "flags"),
    (8, "reserved"),
];
const VPOS: [Field; 1] = [(12, "position")];
const FRAM: [Field; 5] = [(4, "number"), (4, "placement"), (4, "time"), (4, "flags"), (16, "reserved")];
const ENTRY: [Field; 14] = [
    (4, "type"),
    (4, "ordinal"),
    (4, "flags"),
    (2, "schema"),
    (1, "codec"),
    (1, "align_log2"),
    (8, "offset"),
    (8, "stored_len"),
    (8, "raw_len"),
    (8, "elem_count"),
    (4, "elem_size"),
    (12, "reserved"),
    (32, "raw_hash"),
    (32, "stored_hash"),
];
const NODE: [Field; 4] = [(12, "min"), (4, "first"), (12, "max"), (4, "count")];
const TRIS: [Field; 6] = [(12, "v0"), (4, "prim"), (12, "v1"), (4, "geom"), (12, "v2"), (4, "flags")];
const GEOM: [Field; 9] = [
    (4, "source_mesh"),
    (4, "source_part"),
    (4, "baked_node"),
    (4, "blas"),
    (4, "first_prim"),
    (4, "prim_count"),
    (4, "kept_count"),
    (4, "reserved"),
    (32, "name_hash"),
];
const BLAS: [Field; 10] = [
    (12, "min"),
    (4, "node_count"),
    (12, "max"),
    (4, "ref_count"),
    (8, "node_offset"),
    (8, "ref_offset"),
    (4, "prim_count"),
    (4, "max_depth"),
    (4, "sah"),
    (4, "flags"),
];
const INST: [Field; 8] = [
    (48, "object_to_world"),
    (48, "world_to_object"),
    (4, "blas"),
    (4, "id"),
    (4, "mask"),
    (4, "flags"),
    (4, "node"),
    (12, "reserved"),
];
