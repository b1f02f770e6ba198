//! The bytes of a one-triangle file, field by field: if this fails, the format changed.

use bvhc::cache::{Cache, OpenOptions, WriteOptions, to_bytes};
use bvhc::exec::Executor;

use crate::images::{meta, one_triangle};

fn put(bytes: &mut Vec<u8>, parts: &[&[u8]]) {
    parts.iter().for_each(|p| bytes.extend_from_slice(p));
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn longs(values: &[u64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

#[test]
fn one_triangle_file_is_these_bytes() {
    let file = to_bytes(&one_triangle(), &meta(), &WriteOptions::default(), &Executor::current()).unwrap();

    // The sections' contents, by the specification.
    let node = [floats(&[0.0, 0.0, 0.0]), words(&[0]), floats(&[1.0, 1.0, 0.0]), words(&[1]), vec![0; 32]].concat();
    let tris = [
        floats(&[0.0, 0.0, 0.0]),
        words(&[0]),
        floats(&[1.0, 0.0, 0.0]),
        words(&[0]),
        floats(&[0.0, 1.0, 0.0]),
        words(&[0]),
    ]
    .concat();
    let name_hash = blake3::hash(b"triangle");
    let geom = [&words(&[0, 0, u32::MAX, 0, 0, 1, 1, 0])[..], name_hash.as_bytes()].concat();
    let blas = [
        floats(&[0.0, 0.0, 0.0]),
        words(&[2]),
        floats(&[1.0, 1.0, 0.0]),
        words(&[1]),
        longs(&[0, 0]),
        words(&[1, 0]),
        floats(&[1.0]),
        words(&[1]),
    ]
    .concat();
    let nams = [&words(&[1, 8, 8])[..], b"triangle"].concat();
    let string = |s: &str| [&(s.len() as u64).to_le_bytes()[..], s.as_bytes()].concat();
    let meta_bytes = [
        string("bvhc"),
        string("0.0.0"),
        string("sbvh"),
        words(&[1]),
        longs(&[2]),
        string("bins"),
        string("32"),
        string("degenerate"),
        string("drop"),
        longs(&[0, 0, 0]),
    ]
    .concat();

    // The table: kind, flags, elements, and where each lies at 64-byte alignment.
    type Row<'a> = (&'a [u8; 4], u32, u64, u32, &'a [u8]);
    let sections: [Row<'_>; 6] = [
        (b"NODE", 5, 2, 32, &node),
        (b"TRIS", 5, 1, 48, &tris),
        (b"GEOM", 5, 1, 64, &geom),
        (b"BLAS", 5, 1, 64, &blas),
        (b"NAMS", 2, 1, 0, &nams),
        (b"META", 2, 0, 0, &meta_bytes),
    ];
    let (mut table, mut body, mut content) =
        (Vec::new(), Vec::new(), blake3::Hasher::new_derive_key("bvhc v1 content id"));
    let mut by_name = sections.to_vec();
    by_name.sort_by_key(|s| s.0);
    for (kind, flags, _, elem_size, data) in by_name {
        if flags & 4 != 0 {
            let mut record = Vec::new();
            put(&mut record, &[kind, &words(&[0]), &[1, 0, 0, 0], &words(&[elem_size]), &longs(&[data.len() as u64])]);
            content.update(&record).update(blake3::hash(data).as_bytes());
        }
    }
    let start = 256 + 128 * sections.len();
    for (kind, flags, count, elem_size, data) in sections {
        body.resize(body.len().next_multiple_of(64), 0);
        let (at, len, hash) = ((start + body.len()) as u64, data.len() as u64, blake3::hash(data));
        put(
            &mut table,
            &[kind, &words(&[0, flags]), &[1, 0, 0, 6], &longs(&[at, len, len, count]), &words(&[elem_size])],
        );
        put(&mut table, &[&[0; 12], hash.as_bytes(), hash.as_bytes()]);
        body.extend(data);
    }
    body.resize(body.len().next_multiple_of(64), 0);

    // The header, with the file id that follows from all the rest.
    let mut key = blake3::Hasher::new_derive_key("bvhc v1 build key");
    let items: [(u8, &[u8]); 7] =
        [(1, &[1, 0]), (2, b"sbvh"), (3, &[1, 0, 0, 0]), (4, b"bins"), (5, b"32"), (4, b"degenerate"), (5, b"drop")];
    for (tag, value) in items {
        key.update(&[tag]).update(&(value.len() as u64).to_le_bytes()).update(value);
    }
    let header = |file_id: &[u8; 32]| {
        let mut h = Vec::new();
        put(&mut h, &[b"\x89BVH\r\n\x1A\n", &[1, 0, 0, 0, 0, 0, 0, 1], &longs(&[(start + body.len()) as u64, 0, 0])]);
        put(&mut h, &[&words(&[6, 128]), &longs(&[256]), &words(&[5, 2]), file_id]);
        put(
            &mut h,
            &[content.finalize().as_bytes(), key.finalize().as_bytes(), &longs(&[1, 1, 1]), &words(&[1, 0, 0, 0])],
        );
        put(&mut h, &[&floats(&[0.0, 0.0, 0.0, 1.0, 1.0, 0.0]), &[0; 32]]);
        h
    };
    let mut root = blake3::Hasher::new_derive_key("bvhc v1 file id");
    root.update(&header(&[0; 32])).update(&table);
    let expected = [header(root.finalize().as_bytes()), table, body].concat();
    assert_eq!(file.len(), expected.len());
    for (i, (got, want)) in file.iter().zip(&expected).enumerate() {
        assert_eq!(got, want, "byte {i:#x}");
    }
    Cache::from_bytes(&file, &OpenOptions::default()).unwrap();
}
