//! `--orient`: subtrees that are turned where measured rays say that it pays.

use crate::{Place, repository};

/// One of the samples.
fn sample(name: &str) -> String {
    repository().join("samples").join(name).display().to_string()
}

#[test]
fn turned_subtrees_are_built_checked_told_of_and_verified() {
    let place = Place::new();
    let roof = sample("corrugated_roof.obj");
    place.ok(&format!("build {roof} -o plain.bvhc --method sweep"));
    place.ok(&format!("build {roof} -o turned.bvhc --method sweep --orient"));
    let field = |file: &str, name: &str| place.ok(&format!("info {file} --field {name}")).out;
    assert_eq!(field("plain.bvhc", "content_id"), field("turned.bvhc", "content_id"), "the tree is the same");
    assert_ne!(field("plain.bvhc", "build_key"), field("turned.bvhc", "build_key"));
    assert_eq!(
        (field("plain.bvhc", "format.minor"), field("turned.bvhc", "format.minor")),
        ("0\n".into(), "5\n".into())
    );

    // The pass is part of the recipe.
    assert!(place.ok(&format!("build {roof} -o turned.bvhc --method sweep --orient")).out.contains("up to date"));
    let told = place.ok(&format!("build {roof} -o turned.bvhc --method sweep --dry-run")).out;
    assert!(told.contains("orient"), "{told}");

    assert_eq!(place.run(&format!("check turned.bvhc --source {roof}")).code, 0);
    let told = place.ok("stats turned.bvhc plain.bvhc").out;
    assert!(told.contains("turned subtrees") && told.contains("rays pay 0."), "{told}");
    assert!(!place.ok("stats plain.bvhc").out.contains("turned"));
    let told = place.ok("verify turned.bvhc --device cpu --rays 20000").out;
    let line = told.lines().find(|line| line.trim_start().starts_with("turned ")).expect("a line for turned subtrees");
    assert!(line.contains(" 0 mismatches"), "{told}");
    assert!(!place.ok("verify plain.bvhc --device cpu --rays 4000").out.contains("turned"));

    // Other codecs keep them, and threads change nothing.
    place.ok("convert turned.bvhc -o packed.bvhc --codec zstd");
    place.ok("convert packed.bvhc -o unpacked.bvhc");
    assert_eq!(place.read("unpacked.bvhc"), place.read("turned.bvhc"));
    place.ok(&format!("build {roof} -o again.bvhc --method sweep --orient -j 1"));
    assert_eq!(place.read("again.bvhc"), place.read("turned.bvhc"));
}

/// `n` by `n` squares in a plane along two of the scene's axes.
fn sheet(n: u32) -> String {
    let vertices = (0..=n).flat_map(|z| (0..=n).map(move |x| format!("v {x} 0 {z}\n")));
    let squares = (0..n).flat_map(|z| (0..n).map(move |x| z * (n + 1) + x + 1));
    let faces = squares.map(|v| format!("f {v} {} {} {}\n", v + 1, v + n + 2, v + n + 1));
    vertices.chain(faces).collect()
}

#[test]
fn what_does_not_pay_along_other_axes_stays_as_it_is() {
    let place = Place::new();
    place.write("a.obj", sheet(20));
    place.ok("build a.obj -o plain.bvhc");
    place.ok("build a.obj -o asked.bvhc --orient");
    let of = |file: &str| {
        let bytes = place.read(file);
        let cache = bvhc::Cache::from_bytes(&bytes, &bvhc::cache::OpenOptions::default()).unwrap();
        let kinds: Vec<_> = cache.sections().iter().map(|section| section.kind).collect();
        (cache.nodes().to_vec(), cache.triangles().to_vec(), kinds, cache.header().minor)
    };
    assert!(of("plain.bvhc") == of("asked.bvhc"), "{}", place.ok("info asked.bvhc").out);
    let told = place.ok("stats asked.bvhc").out;
    assert!(told.contains("no subtree is turned"), "{told}");
    assert!(place.ok("build a.obj -o asked.bvhc --orient").out.contains("up to date"));
}

#[test]
fn orient_is_refused_where_it_does_not_go_together() {
    let place = Place::new();
    let forest = sample("forest.glb");
    for (command, why, help) in [
        (
            format!("build {forest} -o a.bvhc --orient --levels two"),
            "--orient is about files of one level",
            "--levels one",
        ),
        (
            format!("build {forest} -o a.bvhc --orient --flatten --nodes compact8"),
            "--nodes compact8 and --orient",
            "leave out --orient",
        ),
        (
            format!("build {} -o a.bvhc --orient --frames 1-2", sample("helicopter/heli.%04d.obj")),
            "still files",
            "leave it out",
        ),
    ] {
        let said = place.run(&command);
        assert_eq!(said.code, 2, "{command}: {}{}", said.out, said.err);
        assert!(said.err.contains(why) && said.err.contains(help), "{command}: {}", said.err);
        assert!(!place.path("a.bvhc").exists(), "{command}");
    }
}

#[test]
fn what_turning_takes_is_held_against_the_limit() {
    let place = Place::new();
    place.write("a.obj", sheet(100));
    let build = "build a.obj -o a.bvhc --method binned --max-memory 6M";
    place.ok(build);
    let said = place.run(&format!("{build} --orient"));
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    assert!(said.err.contains("cannot turn subtrees") && said.err.contains("leave out --orient"), "{}", said.err);
}

/// A box that is too small loses rays, and it is the turned subtrees that do.
#[test]
fn verify_names_the_turned_subtrees_where_they_lose_hits() {
    let place = Place::new();
    place.ok(&format!("build {} -o a.bvhc --method sweep --orient", sample("corrugated_roof.obj")));
    let mut bytes = place.read("a.bvhc");
    let at = {
        let cache = bvhc::Cache::from_bytes(&bytes, &bvhc::cache::OpenOptions::default()).unwrap();
        cache.sections()[cache.find(bvhc::cache::SectionKind::ONOD, 0).unwrap()].offset as usize
    };
    // The first box ends where it begins.
    bytes.copy_within(at..at + 12, at + 16);
    place.write("a.bvhc", crate::common::vectors::bytes::refix(bytes));
    assert!(place.run("check a.bvhc").out.contains("E0438"));
    let said = place.run("verify a.bvhc --device cpu --rays 20000");
    assert_eq!(said.code, 1, "{}", said.out);
    let line = |name: &str| said.out.lines().find(|line| line.trim_start().starts_with(name)).map(str::to_owned);
    assert!(line("cpu ").is_some_and(|line| line.contains(" 0 mismatches")), "{}", said.out);
    assert!(line("turned ").is_some_and(|line| !line.contains(" 0 mismatches")), "{}", said.out);
    let replay = said.out.lines().find_map(|line| line.strip_prefix("help: bvhc ")).unwrap();
    let said = place.run(&format!("{replay} --device cpu"));
    assert_eq!(said.code, 1, "{replay}: {}{}", said.out, said.err);
    assert!(said.out.lines().any(|line| line.starts_with("turned ") && line.contains("wrong")), "{}", said.out);
}
