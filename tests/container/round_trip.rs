use bvhc::cache::{
    Cache, Codec, ConvertOptions, Image, Meta, OpenOptions, SectionKind, Validation, WriteOptions, convert, to_bytes,
    write_file,
};
use bvhc::exec::Executor;
use bvhc::trace::Turns;
use bvhc::trace::wide::CompactTrees;
use proptest::prelude::*;

use crate::common::vectors::scenes::two_level;
use crate::common::vectors::valid;
use crate::images::{any_image, empty, meta, one_triangle, two_instances};

/// Images of any content, most of which break rules about records.
const ZSTD: WriteOptions = WriteOptions { codec: Codec::Zstd { level: 3 }, check: false };
const RAW: WriteOptions = WriteOptions { codec: Codec::Raw, check: false };

fn hash_level() -> OpenOptions {
    OpenOptions { validation: Validation::Hash, ..OpenOptions::default() }
}

/// What a reader hands out, as an image again.
fn content(cache: &Cache) -> Image {
    let view = cache.view();
    let (names, has_sides) = (cache.names(), cache.find(SectionKind::SIDE, 0).is_some());
    Image {
        nodes: view.nodes.to_vec(),
        triangles: view.triangles.to_vec(),
        geoms: view.geoms.to_vec(),
        blases: view.blases.to_vec(),
        tlas_nodes: view.tlas_nodes.to_vec(),
        instances: view.instances.to_vec(),
        names: (0..names.len()).map(|i| names.get(i).unwrap().to_owned()).collect(),
        materials: (0..cache.materials().len()).map(|i| cache.material(i as u32).to_owned()).collect(),
        sides: if has_sides {
            (0..view.geoms.len() as u32).map(|i| u32::from(cache.is_mirrored(i))).collect()
        } else {
            Vec::new()
        },
        vertices: cache.vertices().to_vec(),
        compact: cache.compact().map(|wide| CompactTrees {
            nodes: wide.nodes.to_vec(),
            rows: wide.rows.to_vec(),
            order: wide.order.to_vec(),
        }),
        turns: cache.turned().and_then(|turned| {
            let tree = cache.view().blas(0)?;
            Turns::new(&tree, turned.rows.to_vec(), &Executor::current())
        }),
        flags: cache.header().tree_flags,
    }
}

fn normal(image: &Image) -> Image {
    let named = |names: &Vec<String>| if names.iter().all(String::is_empty) { Vec::new() } else { names.clone() };
    Image { names: named(&image.names), materials: named(&image.materials), ..image.clone() }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn what_is_written_is_read(image in any_image(), zstd in any::<bool>()) {
        let options = if zstd { ZSTD } else { RAW };
        let bytes = to_bytes(&image, &meta(), &options, &Executor::current()).unwrap();
        let cache = Cache::from_bytes(&bytes, &hash_level()).unwrap();
        prop_assert_eq!(content(&cache), normal(&image));
        prop_assert_eq!(cache.meta(), Some(&meta()));
        prop_assert_eq!(cache.header().build_key, meta().build_key());
        prop_assert_eq!(bytes.len() as u64, cache.header().file_len);
        prop_assert_eq!(to_bytes(&image, &meta(), &options, &Executor::current()).unwrap(), bytes);
    }
}

#[test]
fn an_empty_scene_is_a_file_and_opens_at_every_level() {
    let bytes = to_bytes(&empty(), &Meta::default(), &WriteOptions::default(), &Executor::current()).unwrap();
    for validation in [Validation::Quick, Validation::Hash, Validation::Tree] {
        let cache = Cache::from_bytes(&bytes, &OpenOptions { validation, ..OpenOptions::default() }).unwrap();
        assert_eq!((cache.nodes().len(), cache.header().blas_count, cache.sections().len()), (0, 0, 5));
    }
}

#[test]
fn well_formed_files_open_at_the_deepest_level() {
    for image in [one_triangle(), two_instances()] {
        let bytes = to_bytes(&image, &meta(), &WriteOptions::default(), &Executor::current()).unwrap();
        Cache::from_bytes(&bytes, &OpenOptions { validation: Validation::Tree, ..OpenOptions::default() }).unwrap();
    }
    let mut image = one_triangle();
    image.nodes[0].count = 2;
    let bytes = to_bytes(&image, &meta(), &RAW, &Executor::current()).unwrap();
    Cache::from_bytes(&bytes, &hash_level()).unwrap();
    let tree = OpenOptions { validation: Validation::Tree, ..OpenOptions::default() };
    assert_eq!(Cache::from_bytes(&bytes, &tree).unwrap_err().rule(), Some("E0408"));
}

#[test]
fn facts_of_the_header_repeat_the_sections() {
    let bytes = to_bytes(&two_instances(), &meta(), &WriteOptions::default(), &Executor::current()).unwrap();
    let cache = Cache::from_bytes(&bytes, &hash_level()).unwrap();
    let header = cache.header();
    assert_eq!((header.prim_count, header.ref_count, header.node_count), (1, 1, 2));
    assert_eq!((header.blas_count, header.instance_count, header.max_depth), (1, 2, 0));
    assert_eq!(header.scene_bounds(), cache.tlas_nodes()[0].bounds());
    assert_eq!((header.builder_id, cache.meta().map(|m| m.method.as_str())), (2, Some("sbvh")));
    assert_eq!(cache.names().get(0), Some("triangle"));
}

#[test]
fn raw_to_zstd_to_raw_keeps_the_content_and_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let [raw, packed, again] = ["raw", "packed", "again"].map(|n| folder.path().join(n));
    let image = crate::refuse::many_triangles();
    write_file(&raw, &image, &meta(), &RAW, &Executor::current()).unwrap();
    let to_zstd = ConvertOptions { write: ZSTD, ..ConvertOptions::default() };
    convert(&raw, &packed, &hash_level(), &to_zstd, &Executor::current()).unwrap();
    let to_raw = ConvertOptions { write: RAW, ..ConvertOptions::default() };
    let summary = convert(&packed, &again, &hash_level(), &to_raw, &Executor::current()).unwrap();
    assert_eq!(std::fs::read(&raw).unwrap(), std::fs::read(&again).unwrap());
    assert!(std::fs::metadata(&packed).unwrap().len() * 10 < std::fs::metadata(&raw).unwrap().len());
    let packed = Cache::open(&packed).unwrap();
    assert_eq!(packed.header().content_id, summary.written.header.content_id);
    assert_eq!(content(&packed), image);

    // In place, and without mapping.
    convert(&raw, &raw, &OpenOptions { mmap: false, ..hash_level() }, &to_zstd, &Executor::current()).unwrap();
    assert_eq!(content(&Cache::open(&raw).unwrap()), image);
}

/// Compact trees come and go, and nothing else changes: what is added is what a build adds, and without it the file is what it was.
#[test]
fn compact_trees_are_added_and_left_out_with_the_same_content() {
    let folder = tempfile::tempdir().unwrap();
    let [binary, both, converted, again] = ["binary", "both", "converted", "again"].map(|n| folder.path().join(n));
    for image in [valid::empty(), valid::plane(), valid::duplicates(), two_level()] {
        let with = |compact| ConvertOptions { write: RAW, compact, ..ConvertOptions::default() };
        let go = |from: &_, to: &_, compact| {
            convert(from, to, &hash_level(), &with(compact), &Executor::current()).unwrap().written.header
        };
        let first = write_file(&binary, &image, &meta(), &RAW, &Executor::current()).unwrap().header;
        let mut wide = image.clone();
        wide.add_compact().unwrap();
        let second = write_file(&both, &wide, &meta(), &RAW, &Executor::current()).unwrap().header;
        assert_eq!((first.content_id, first.build_key), (second.content_id, second.build_key));
        assert_eq!((first.minor, second.minor, second.min_minor), (0, 4, 0));
        assert_eq!(content(&Cache::open(&both).unwrap()).compact, wide.compact.filter(|trees| !trees.rows.is_empty()));

        let read = |path: &_| std::fs::read(path).unwrap();
        go(&binary, &converted, Some(true));
        assert!(read(&converted) == read(&both));
        go(&both, &converted, Some(true));
        assert!(read(&converted) == read(&both));
        go(&both, &converted, None);
        assert!(read(&converted) == read(&both));
        go(&both, &again, Some(false));
        assert!(read(&again) == read(&binary));
        go(&binary, &again, Some(false));
        assert!(read(&again) == read(&binary));
    }
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let mut image = one_triangle();
    image.triangles.resize(200_000, image.triangles[0]);
    image.triangles.iter_mut().enumerate().for_each(|(i, t)| t.prim = i as u32);
    for options in [RAW, ZSTD] {
        let with = |threads| to_bytes(&image, &meta(), &options, &Executor::new(threads).unwrap()).unwrap();
        assert!(with(1) == with(7), "{options:?}");
    }
}

#[test]
#[ignore = "long: writes 400 MB and opens it"]
fn long_quick_opening_does_not_read_the_400_mb_that_it_opens() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.bvhc");
    let mut image = one_triangle();
    image.triangles.resize(5_000_000, image.triangles[0]);
    image.nodes.resize(5_000_000, image.nodes[0]);
    let size = write_file(&path, &image, &meta(), &RAW, &Executor::current()).unwrap().header.file_len;
    assert!(size >= 400_000_000);
    let quick = OpenOptions { validation: Validation::Quick, ..OpenOptions::default() };
    let mut times: Vec<_> = (0..20)
        .map(|_| {
            let start = std::time::Instant::now();
            assert_eq!(Cache::open_with(&path, &quick).unwrap().triangles().len(), 5_000_000);
            start.elapsed()
        })
        .collect();
    times.sort();
    let start = std::time::Instant::now();
    Cache::open(&path).unwrap();
    let hashed = start.elapsed();
    println!("{size} bytes: quick {:?} (median of 20), hash {hashed:?}", times[10]);
    assert!(20 * times[10] < hashed, "{times:?}, {hashed:?} with hashes");
}
