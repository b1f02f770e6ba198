//! `bvhc build` a second time: when nothing is written, and why.

use crate::{Place, gltf, strip};
use bvhc::scene::{Degenerate, ReadOptions};
use std::time::{Duration, SystemTime};

/// A folder with `a.obj` and its cache, whose time stamp is an hour old.
fn built() -> (Place, SystemTime) {
    let place = Place::new();
    place.write("a.obj", strip(50));
    place.ok("build a.obj -o a.bvhc");
    let old = SystemTime::now() - Duration::from_secs(3600);
    set_modified(&place, "a.bvhc", old);
    let old = modified(&place, "a.bvhc");
    (place, old)
}

fn modified(place: &Place, name: &str) -> SystemTime {
    place.path(name).metadata().unwrap().modified().unwrap()
}

fn set_modified(place: &Place, name: &str, time: SystemTime) {
    std::fs::File::options().append(true).open(place.path(name)).unwrap().set_modified(time).unwrap();
}

#[test]
fn a_second_build_changes_nothing() {
    let (place, old) = built();
    let before = place.read("a.bvhc");
    let said = place.ok("build a.obj -o a.bvhc");
    assert!(said.out.starts_with("a.bvhc  up to date (key "), "{}", said.out);
    assert_eq!(place.read("a.bvhc"), before);
    assert_eq!(modified(&place, "a.bvhc"), old);
    assert_eq!(place.names(), ["a.bvhc", "a.obj"]);
}

#[test]
fn a_second_build_hashes_the_model_and_does_not_read_it() {
    let place = Place::new();
    place.write("a.obj", strip(20_000));
    place.ok("build a.obj -o a.bvhc --preset draft");
    // In so little memory the model cannot be read.
    assert_eq!(place.run("build a.obj -o a.bvhc --preset draft --max-memory 1K --force").code, 6);
    let said = place.ok("build a.obj -o a.bvhc --preset draft --max-memory 1K");
    assert!(said.out.starts_with("a.bvhc  up to date (key "), "{}", said.out);
}

#[test]
fn a_forced_build_does_not_ask_what_it_replaces() {
    let (place, _) = built();
    let reason = |args: &str| {
        let said = place.ok(&format!("build a.obj -o a.bvhc --force --json {args}")).out;
        let document: serde_json::Value = serde_json::from_str(&said).unwrap();
        document["files"][0]["reason"].as_str().unwrap().to_owned()
    };
    let whole = place.read("a.bvhc");
    assert_eq!([reason(""), reason("-O max-leaf=4")], ["forced", "forced"]);
    assert_ne!(place.read("a.bvhc"), whole);
    place.write("a.bvhc", &whole[..300]);
    assert_eq!(reason(""), "forced");
    assert_eq!(place.read("a.bvhc"), whole);
    std::fs::remove_file(place.path("a.bvhc")).unwrap();
    assert_eq!(reason(""), "missing");
    assert_eq!(place.read("a.bvhc"), whole);
}

#[test]
fn times_play_no_part_only_content_does() {
    let (place, old) = built();
    set_modified(&place, "a.obj", SystemTime::now());
    place.ok("build a.obj -o a.bvhc");
    assert_eq!(modified(&place, "a.bvhc"), old, "the input is newer but the same");

    place.write("a.obj", strip(51));
    set_modified(&place, "a.obj", old - Duration::from_secs(3600));
    place.ok("build a.obj -o a.bvhc");
    assert_ne!(modified(&place, "a.bvhc"), old, "the input is older but another");
}

#[test]
fn a_dry_run_says_why_and_does_nothing() {
    let (place, old) = built();
    let why = |args: &str| place.ok(&format!("build a.obj -o a.bvhc --dry-run {args}")).out;
    assert!(why("").contains("up to date"));
    assert_eq!(why("-O max-leaf=4"), "a.bvhc  would build: option max-leaf 8 → 4\n");
    assert!(why("--bins 8").contains("method auto → sbvh"), "{}", why("--bins 8"));
    assert_eq!(why("--force"), "a.bvhc  would build: forced\n");
    assert!(why("--method binned").contains("method auto → binned"));
    assert!(why("--degenerate keep").contains("option degenerate drop → keep"));

    // What lies on the disk can be stale in several ways.
    place.write("a.obj", strip(51));
    assert!(why("").contains("a.obj changed"));
    let cut = place.read("a.bvhc")[..300].to_vec();
    place.write("a.bvhc", cut);
    assert!(why("").contains("would build: cannot read a.bvhc"), "{}", why(""));
    std::fs::remove_file(place.path("a.bvhc")).unwrap();
    assert_eq!(why(""), "a.bvhc  would build: missing\n");
    assert_eq!(place.names(), ["a.obj"]);
    let _ = old;
}

#[test]
fn a_dry_run_can_answer_by_its_exit_code() {
    let (place, _) = built();
    assert_eq!(place.run("build a.obj -o a.bvhc -n --exit-code").code, 0);
    assert_eq!(place.run("build a.obj -o a.bvhc -n --exit-code --bins 8").code, 1);
    assert_eq!(place.run("build a.obj -o a.bvhc --exit-code").code, 2, "only with --dry-run");
}

#[test]
fn the_codec_is_compared_too() {
    let place = Place::new();
    place.write("a.obj", strip(3000));
    place.ok("build a.obj -o a.bvhc");
    assert!(place.ok("build a.obj -o a.bvhc --codec zstd -n").out.contains("codec raw → zstd"));
    place.ok("build a.obj -o a.bvhc --codec zstd");
    assert!(place.ok("build a.obj -o a.bvhc --codec zstd").out.contains("up to date"));
    assert!(place.ok("build a.obj -o a.bvhc -n").out.contains("codec zstd → raw"));
}

#[test]
fn a_tiny_file_that_zstd_cannot_shrink_is_up_to_date_with_it() {
    let place = Place::new();
    place.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    place.ok("build a.obj -o a.bvhc --codec zstd");
    assert!(place.ok("build a.obj -o a.bvhc --codec zstd").out.contains("up to date"));
}

#[test]
fn touch_moves_the_time_stamp_and_nothing_else() {
    let (place, old) = built();
    let before = place.read("a.bvhc");
    place.ok("build a.obj -o a.bvhc --touch");
    assert!(modified(&place, "a.bvhc") > old);
    assert_eq!(place.read("a.bvhc"), before);
}

#[test]
fn force_writes_the_same_bytes_again() {
    let (place, old) = built();
    let before = place.read("a.bvhc");
    place.ok("build a.obj -o a.bvhc --force");
    assert_ne!(modified(&place, "a.bvhc"), old);
    assert_eq!(place.read("a.bvhc"), before);
}

#[test]
fn an_external_buffer_is_an_input() {
    let place = Place::new();
    let (model, mut bin) = gltf("t");
    place.write("m/t.gltf", model);
    place.write("m/t.bin", &bin);
    place.ok("build m/t.gltf -o t.bvhc");
    assert!(place.ok("build m/t.gltf -o t.bvhc").out.contains("up to date"));
    bin[12] ^= 1;
    place.write("m/t.bin", &bin);
    assert!(place.ok("build m/t.gltf -o t.bvhc -n").out.contains("t.bin changed"));
    std::fs::remove_file(place.path("m/t.bin")).unwrap();
    for args in ["build m/t.gltf -o t.bvhc -n", "build m/t.gltf -o t.bvhc"] {
        let said = place.run(args);
        assert!(said.code == 3 && said.err.contains("t.bin, which cannot be opened"), "{}", said.err);
    }
}

/// A buffer outside of the model's folder, by an absolute path: remembered by the way to it, and found again.
#[cfg(unix)]
#[test]
fn a_buffer_from_outside_is_up_to_date_too() {
    let place = Place::new();
    let (model, bin) = gltf("t");
    let bin_path = place.write("buffers/t.bin", &bin);
    let named = model.replace("t.bin", bin_path.to_str().unwrap());
    assert!(named.contains(bin_path.to_str().unwrap()));
    place.write("m/t.gltf", named);
    place.ok("build m/t.gltf -o t.bvhc --allow-outside");
    assert!(place.ok("build m/t.gltf -o t.bvhc --allow-outside").out.contains("up to date"));
    assert_eq!(place.ok("info t.bvhc --field meta.inputs.1.name").out.trim(), "../buffers/t.bin");
    let root = place.root().to_str().unwrap().as_bytes().to_vec();
    assert!(!place.read("t.bvhc").windows(root.len()).any(|w| w == root), "the file names the machine's folders");
    place.write("buffers/t.bin", bin.iter().map(|b| b ^ 1).collect::<Vec<_>>());
    assert!(place.ok("build m/t.gltf -o t.bvhc --allow-outside -n").out.contains("../buffers/t.bin changed"));
}

#[test]
fn another_level_of_zstd_is_no_reason_to_build() {
    let place = Place::new();
    place.write("a.obj", strip(3000));
    place.ok("build a.obj -o a.bvhc --codec zstd:1");
    assert!(place.ok("build a.obj -o a.bvhc --codec zstd:9").out.contains("up to date"));
    assert!(place.ok("build a.obj -o a.bvhc -n").out.contains("codec zstd → raw"));
}

#[test]
fn vertices_are_kept_where_they_are_asked_for_and_a_file_without_them_is_then_out_of_date() {
    let (place, _) = built();
    let without = place.read("a.bvhc");
    let asked = place.ok("build a.obj -o a.bvhc --vertices -n").out;
    assert!(asked.contains("would build: option vertices unset → true"), "{asked}");
    place.ok("build a.obj -o a.bvhc --vertices");
    assert!(place.ok("info a.bvhc").out.contains("VERT"));
    assert!(place.ok("build a.obj -o a.bvhc --vertices").out.contains("up to date"));
    assert_eq!(place.ok("check a.bvhc --source a.obj").out.lines().count(), 1);
    let again = place.ok("build a.obj -o a.bvhc -n").out;
    assert!(again.contains("would build: option vertices true → unset"), "{again}");
    place.ok("build a.obj -o a.bvhc");
    assert_eq!(place.read("a.bvhc"), without);
}

/// A program that builds by the library and a pipeline that builds by the command line share their files.
#[test]
fn what_the_library_builds_of_a_model_is_up_to_date() {
    let place = Place::new();
    let model = place.write("a.obj", strip(6));
    let kept = ReadOptions { degenerate: Degenerate::Keep, vertices: true, ..ReadOptions::default() };
    for (read, flags) in [(ReadOptions::default(), ""), (kept, " --degenerate keep --vertices")] {
        bvhc::Build::of_model_with(&model, &read).unwrap().run().unwrap().write(place.path("a.bvhc")).unwrap();
        let by_library = place.read("a.bvhc");
        assert!(place.ok(&format!("build a.obj -o a.bvhc{flags}")).out.contains("up to date"), "{flags}");
        place.ok(&format!("build a.obj -o a.bvhc{flags} --force"));
        assert!(place.read("a.bvhc") == by_library, "{flags}: the program's file has other bytes");
    }
}
