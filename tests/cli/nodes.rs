//! `--nodes`: compact trees beside the binary ones, in files that are built and in files that are converted.

use crate::frames::heli;
use crate::{Place, repository, strip};

#[test]
fn compact_trees_are_built_converted_told_of_and_verified() {
    let place = Place::new();
    place.write("a.obj", strip(300));
    place.ok("build a.obj -o plain.bvhc");
    place.ok("build a.obj -o same.bvhc --nodes binary");
    place.ok("build a.obj -o wide.bvhc --nodes binary,compact8");
    assert_eq!(place.read("plain.bvhc"), place.read("same.bvhc"));
    let field = |file: &str, name: &str| place.ok(&format!("info {file} --field {name}")).out;
    for name in ["content_id", "build_key"] {
        assert_eq!(field("plain.bvhc", name), field("wide.bvhc", name));
    }
    assert_eq!((field("plain.bvhc", "format.minor"), field("wide.bvhc", "format.minor")), ("0\n".into(), "4\n".into()));

    // What converting adds is what building writes, and either way back is the plain file.
    place.ok("convert plain.bvhc -o added.bvhc --nodes compact8");
    place.ok("convert wide.bvhc -o left.bvhc --nodes binary");
    place.ok("convert wide.bvhc -o packed.bvhc --codec zstd");
    place.ok("convert packed.bvhc -o unpacked.bvhc");
    assert_eq!(place.read("added.bvhc"), place.read("wide.bvhc"));
    assert_eq!(place.read("left.bvhc"), place.read("plain.bvhc"));
    assert_eq!(place.read("unpacked.bvhc"), place.read("wide.bvhc"));

    // A file that has the trees in other forms than those that are asked for is not up to date.
    assert!(place.ok("build a.obj -o wide.bvhc --nodes compact8").out.contains("up to date"));
    let told = place.ok("build a.obj -o wide.bvhc --dry-run").out;
    assert!(told.contains("nodes compact8 → binary"), "{told}");
    let told = place.ok("build a.obj -o plain.bvhc --nodes compact8 --dry-run").out;
    assert!(told.contains("nodes binary → compact8"), "{told}");

    assert_eq!(place.run("check wide.bvhc --source a.obj").code, 0);
    let told = place.ok("stats wide.bvhc plain.bvhc").out;
    assert!(told.contains("compact8 nodes") && told.contains("binary nodes"), "{told}");
    assert!(!place.ok("stats plain.bvhc").out.contains("compact8"));
    let told = place.ok("verify wide.bvhc --device cpu --rays 4000").out;
    let line = told.lines().find(|line| line.trim_start().starts_with("compact8 ")).expect("a line for compact trees");
    assert!(line.contains(" 0 mismatches"), "{told}");
    assert!(!place.ok("verify plain.bvhc --device cpu --rays 4000").out.contains("compact8"));
}

/// Duplicates may be found in another of their leaves, and instances are found through the binary top level.
#[test]
fn verify_finds_nothing_in_compact_trees_of_cut_triangles_and_of_instances() {
    let place = Place::new();
    let samples = repository().join("samples");
    for (model, options) in [("colonnade.obj", "--method sbvh --split-budget 1.5"), ("forest.glb", "--levels two")] {
        let model = samples.join(model);
        place.ok(&format!("build {} -o a.bvhc --nodes compact8 --force {options}", model.display()));
        let told = place.ok("verify a.bvhc --device cpu --rays 20000").out;
        let line = told.lines().find(|line| line.trim_start().starts_with("compact8 ")).expect("compact trees");
        assert!(line.contains(" 0 mismatches"), "{told}");
    }
}

/// A box that is too small loses rays, and it is the compact trees that do.
#[test]
fn verify_names_the_compact_trees_where_they_lose_hits() {
    let place = Place::new();
    place.write("a.obj", strip(300));
    place.ok("build a.obj -o a.bvhc --nodes compact8");
    let mut bytes = place.read("a.bvhc");
    let options = bvhc::cache::OpenOptions::default();
    let (at, far) = {
        let cache = bvhc::Cache::from_bytes(&bytes, &options).unwrap();
        let index = cache.find(bvhc::cache::SectionKind::CNOD, 0).unwrap();
        (cache.sections()[index].offset as usize, cache.compact_nodes()[0].planes[3])
    };
    let widest = (0..8).max_by_key(|lane| far[*lane]).unwrap();
    bytes[at + 56 + widest] /= 2;
    place.write("a.bvhc", crate::common::vectors::bytes::refix(bytes));
    assert!(place.run("check a.bvhc").out.contains("E0432"));
    let said = place.run("verify a.bvhc --device cpu --rays 20000");
    assert_eq!(said.code, 1, "{}", said.out);
    let line = |name: &str| said.out.lines().find(|line| line.trim_start().starts_with(name)).map(str::to_owned);
    assert!(line("cpu ").is_some_and(|line| line.contains(" 0 mismatches")), "{}", said.out);
    assert!(line("compact8 ").is_some_and(|line| !line.contains(" 0 mismatches")), "{}", said.out);
    // The command that it ends with shows the same of the one ray.
    let replay = said.out.lines().find_map(|line| line.strip_prefix("help: bvhc ")).unwrap();
    let said = place.run(&format!("{replay} --device cpu"));
    let answer = |name: &str| said.out.lines().find(|line| line.starts_with(name)).map(str::to_owned);
    assert_eq!(said.code, 1, "{replay}: {}{}", said.out, said.err);
    assert!(answer("cpu ").is_some_and(|line| line.ends_with("right")), "{}", said.out);
    assert!(answer("compact8 ").is_some_and(|line| line.contains("wrong")), "{}", said.out);
}

#[test]
fn sequences_have_no_compact_trees() {
    let place = heli();
    let said = place.run("build in/heli.%04d.obj -o heli.bvhc --missing skip --nodes compact8");
    assert_eq!(said.code, 2);
    assert!(said.err.contains("--nodes compact8 is about still files"), "{}", said.err);
    place.ok("build in/heli.%04d.obj -o heli.bvhc --missing skip");
    let said = place.run("convert heli.bvhc -o other.bvhc --nodes compact8");
    assert_eq!(said.code, 2);
    assert!(said.err.contains("this is a sequence"), "{}", said.err);
    let first = place.ok("info heli.bvhc --json").out;
    assert!(first.contains("\"frames\""));
    let said = place.run("convert heli.bvhc -o frame.bvhc --frame 1 --nodes compact8");
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(place.run("check frame.bvhc").code, 0);
    assert!(place.ok("info frame.bvhc").out.contains("CNOD"));
}
