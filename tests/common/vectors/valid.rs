//! Files that every reader must accept.

use bvhc::cache::{
    Codec, Header, Image, SectionEntry, SectionKind, WriteOptions, section_flags, side_flags, to_bytes, tree_flags,
};
use bvhc::exec::Executor;

use super::bytes::{self, file};
use super::scenes::{self, comb, cut_in_two, one_level, parts_mesh, sheet, soup, tree, two_level};
use super::{compact, sequences, turns};

/// One valid file.
pub struct Valid {
    pub name: &'static str,
    pub bytes: Vec<u8>,
    /// Its bytes depend on the compressor's version; compare `content_id`.
    pub packed: bool,
}

pub fn all() -> Vec<Valid> {
    let raw = |name, bytes| Valid { name, bytes, packed: false };
    let triangle = soup("triangle", &[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    let one = tree(&triangle, 1);
    let (deep_mesh, deep_tree) = comb(65);
    vec![
        raw("empty", file(&empty())),
        raw("one-triangle", file(&one_level(triangle, one))),
        raw("flat-plane", file(&plane())),
        raw("several-parts", file(&parts())),
        raw("duplicate-refs", file(&duplicates())),
        raw("two-level", file(&two_level())),
        raw("depth-64", file(&one_level(deep_mesh, deep_tree))),
        raw("unknown-ancillary-section", unknown_ancillary()),
        raw("longer-header", longer_header()),
        raw("origins", file(&origins())),
        raw("compact", file(&compact::flat())),
        raw("compact-two-level", file(&compact::added(two_level()))),
        raw("turned", file(&turns::flat())),
        raw("turned-cut", file(&turns::cut())),
        Valid { name: "zstd", bytes: packed(), packed: true },
        raw("sequence-refitted", sequences::refitted().file()),
        raw("sequence-rebuilt", sequences::rebuilt().file()),
        raw("sequence-empty-frame", sequences::empty_frame().file()),
        raw("sequence-origins", sequences::origins().file()),
        Valid { name: "sequence-zstd", bytes: sequences::large().packed(), packed: true },
        Valid { name: "sequence-differences", bytes: sequences::walk().differences(), packed: true },
    ]
}

pub fn empty() -> Image {
    Image { flags: tree_flags::CANONICAL_DFS | tree_flags::REFITTABLE, ..Image::default() }
}

/// Eight triangles in a plane, one a leaf.
pub fn plane() -> Image {
    let mesh = sheet(2, 0.0);
    let tree = tree(&mesh, 1);
    one_level(mesh, tree)
}

pub fn parts() -> Image {
    let mesh = parts_mesh();
    let tree = tree(&mesh, 2);
    one_level(mesh, tree)
}

pub fn duplicates() -> Image {
    cut_in_two([&[0, 1], &[0, 2], &[3]])
}

/// Everything that leads back to the model: vertices, of a triangle that stands in two leaves among others, a mirrored part, and materials.
pub fn origins() -> Image {
    let mut image = duplicates();
    image.vertices = image.triangles.iter().map(|t| [0, 1, 2].map(|corner| 10 * t.prim + corner)).collect();
    image.geoms[0].baked_node = 3;
    image.sides = vec![side_flags::MIRRORED];
    image.materials = vec!["brick %FF".into()];
    image
}

pub fn unknown_ancillary() -> Vec<u8> {
    bytes::with_section(&file(&plane()), *b"XTRA", section_flags::COPY_SAFE, b"something from a later version")
}

/// As a later minor version may write it: 64 more header bytes, which a reader of this version skips.
fn longer_header() -> Vec<u8> {
    let (header, sections) = bytes::take_apart(&file(&plane()));
    let short = bytes::put_together(header, sections);
    let mut long = short.clone();
    long.splice(Header::LEN..Header::LEN, [7u8; 64]);
    let mut header = header_of(&long);
    (header.minor, header.header_len, header.section_table_off) = (bvhc::cache::MINOR + 1, 320, 320);
    header.file_len += 64;
    let table_end = 320 + header.section_count as usize * SectionEntry::LEN;
    for at in (320..table_end).step_by(SectionEntry::LEN) {
        let mut entry: SectionEntry = bytemuck::pod_read_unaligned(&long[at..at + SectionEntry::LEN]);
        entry.offset += 64;
        long[at..at + SectionEntry::LEN].copy_from_slice(bytemuck::bytes_of(&entry));
    }
    header.file_id = bvhc::cache::keys::file_id(&header, &long[Header::LEN..320], &long[320..table_end]);
    bytes::set_header(&mut long, &header);
    long
}

fn header_of(file: &[u8]) -> Header {
    bytes::header(file)
}

/// 800 triangles, which gain by compression.
pub fn packed() -> Vec<u8> {
    let mesh = sheet(20, 0.0);
    let tree = tree(&mesh, 4);
    let options = WriteOptions { codec: Codec::Zstd { level: 3 }, check: true };
    let file = to_bytes(&one_level(mesh, tree), &scenes::meta(), &options, &Executor::current()).unwrap();
    assert_eq!(bytes::entries(&file)[bytes::position(&file, SectionKind::TRIS)].codec, SectionEntry::ZSTD);
    file
}

pub fn plane_file() -> Vec<u8> {
    file(&plane())
}

pub fn two_level_file() -> Vec<u8> {
    file(&two_level())
}
