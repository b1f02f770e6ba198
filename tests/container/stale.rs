use std::fs;
use std::path::Path;

use bvhc::cache::keys::Recipe;
use bvhc::cache::{
    Freshness, Image, SectionEntry, SectionKind, Staleness, WriteOptions, freshness, hash_file, write_file,
};
use bvhc::exec::Executor;
use bvhc::scene::{InputFile, ReadReport};

use crate::common::vectors::bytes;
use crate::images::one_triangle;

fn recipe() -> Recipe {
    let options = [("bins", "32"), ("degenerate", "drop")].map(|(n, v)| (n.to_owned(), v.to_owned()));
    Recipe { method: "sbvh".into(), builder_revision: 3, options: options.into() }
}

fn input(folder: &Path, name: &str) -> InputFile {
    let path = folder.join(name);
    let (len, blake3) = hash_file(&path, &Executor::current()).unwrap();
    InputFile { path, name: name.into(), len, blake3 }
}

fn reason(path: &Path, model: &Path, recipe: &Recipe) -> Option<Staleness> {
    match freshness(path, model, recipe, &Executor::current()) {
        Freshness::Fresh { .. } => None,
        Freshness::Stale(why) => Some(why),
    }
}

#[test]
fn each_cause_of_staleness_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let (folder, path) = (folder.path(), folder.path().join("a.bvhc"));
    fs::create_dir(folder.join("buffers")).unwrap();
    fs::write(folder.join("a.gltf"), "model").unwrap();
    fs::write(folder.join("buffers/a.bin"), "buffer").unwrap();
    let model = folder.join("a.gltf");
    let build = || {
        let inputs = [input(folder, "a.gltf"), input(folder, "buffers/a.bin")];
        let meta = bvhc::cache::provenance(recipe(), &inputs, &ReadReport::default());
        write_file(&path, &one_triangle(), &meta, &WriteOptions::default(), &Executor::current()).unwrap();
    };
    let why = || reason(&path, &model, &recipe());

    assert_eq!(why(), Some(Staleness::Missing));
    build();
    match freshness(&path, &model, &recipe(), &Executor::current()) {
        Freshness::Fresh { inputs, .. } => assert_eq!(inputs, [model.clone(), folder.join("buffers/a.bin")]),
        Freshness::Stale(why) => panic!("{why}"),
    }

    // The recipe.
    let changed = |change: fn(&mut Recipe)| {
        let mut recipe = recipe();
        change(&mut recipe);
        reason(&path, &model, &recipe).unwrap().to_string()
    };
    assert_eq!(changed(|r| r.method = "binned".into()), "method sbvh → binned");
    assert_eq!(changed(|r| r.builder_revision = 4), "builder revision 3 → 4");
    assert_eq!(changed(|r| r.options[0].1 = "16".into()), "option bins 32 → 16");
    assert_eq!(changed(|r| r.options.push(("levels".into(), "two".into()))), "option levels unset → two");
    assert_eq!(changed(|r| drop(r.options.pop())), "option degenerate drop → unset");
    assert_eq!(changed(|r| r.options.reverse()), "the build key is another");

    // The inputs: same length, other length, missing, and back again with another time and another name.
    let bin = folder.join("buffers/a.bin");
    fs::write(&bin, "buffer".to_uppercase()).unwrap();
    assert_eq!(why(), Some(Staleness::InputChanged { name: "buffers/a.bin".into() }));
    fs::write(&bin, "longer than before").unwrap();
    assert_eq!(why(), Some(Staleness::InputChanged { name: "buffers/a.bin".into() }));
    fs::remove_file(&bin).unwrap();
    assert_eq!(why(), Some(Staleness::InputMissing { name: "buffers/a.bin".into() }));
    fs::write(&bin, "buffer").unwrap();
    fs::copy(&model, folder.join("renamed.gltf")).unwrap();
    assert_eq!(why(), None);
    assert_eq!(reason(&path, &folder.join("renamed.gltf"), &recipe()), None);

    // The file itself.
    let mut bytes = fs::read(&path).unwrap();
    bytes[300] ^= 1;
    fs::write(&path, bytes).unwrap();
    assert!(matches!(why(), Some(Staleness::Unreadable(text)) if text.contains("damaged")));
    fs::write(&path, "something else altogether").unwrap();
    assert!(matches!(why(), Some(Staleness::Unreadable(_))));
    build();
    assert_eq!(why(), None);
}

#[test]
fn a_file_that_lost_its_vertices_is_stale() {
    let folder = tempfile::tempdir().unwrap();
    let (model, path) = (folder.path().join("a.obj"), folder.path().join("a.bvhc"));
    fs::write(&model, "model").unwrap();
    let mut asked = recipe();
    asked.options.push(("vertices".into(), "true".into()));
    let meta = bvhc::cache::provenance(asked.clone(), &[input(folder.path(), "a.obj")], &ReadReport::default());
    for (vertices, why) in [(vec![[0, 1, 2]], None), (vec![], Some(Staleness::Section { kind: SectionKind::VERT }))] {
        let image = Image { vertices, ..one_triangle() };
        write_file(&path, &image, &meta, &WriteOptions::default(), &Executor::current()).unwrap();
        assert_eq!(reason(&path, &model, &asked), why);
    }
}

#[test]
fn a_known_section_in_a_layout_that_is_not_known_makes_a_file_stale() {
    let folder = tempfile::tempdir().unwrap();
    let (model, path) = (folder.path().join("a.obj"), folder.path().join("a.bvhc"));
    fs::write(&model, "model").unwrap();
    let mut asked = recipe();
    asked.options.push(("vertices".into(), "true".into()));
    let meta = bvhc::cache::provenance(asked.clone(), &[input(folder.path(), "a.obj")], &ReadReport::default());
    let image = Image { vertices: vec![[0, 1, 2]], materials: vec!["red".into()], ..one_triangle() };
    write_file(&path, &image, &meta, &WriteOptions::default(), &Executor::current()).unwrap();
    let good = fs::read(&path).unwrap();
    let edits: [fn(&mut SectionEntry); 3] = [|e| e.schema = 2, |e| e.ordinal = 1, |e| e.codec = 7];
    for kind in [SectionKind::VERT, SectionKind::NAMS, SectionKind::MATS] {
        for edit in edits {
            fs::write(&path, bytes::with_entry(good.clone(), kind, edit)).unwrap();
            let why = reason(&path, &model, &asked);
            assert!(matches!(why, Some(Staleness::Layout { kind: k, .. }) if k == kind), "{kind}: {why:?}");
            let of_bytes = bvhc::cache::freshness_of_bytes(&path, b"model", &asked, &Executor::current());
            assert!(matches!(of_bytes, Freshness::Stale(Staleness::Layout { .. })), "{kind}: {of_bytes:?}");
        }
    }
    // A section of somebody else's does not matter, and without it the file is what it was.
    fs::write(&path, bytes::with_section(&good, *b"XTRA", 2, b"anything")).unwrap();
    assert_eq!(reason(&path, &model, &asked), None);
}
