//! What `bvhc build` takes as a model: files, patterns, standard input.

use crate::{Place, Said, gltf, said, strip};
use std::io::Write;
use std::process::Stdio;

fn piped(place: &Place, args: &str, model: &[u8]) -> Said {
    let mut command = place.command();
    command.args(args.split_whitespace()).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // A program that refuses at once closes the pipe.
    let _ = child.stdin.take().unwrap().write_all(model);
    said(child.wait_with_output().unwrap())
}

#[test]
fn a_quoted_pattern_names_files_in_natural_order() {
    let place = Place::new();
    for name in ["f.10.obj", "f.9.obj", "g.1.obj"] {
        place.write(&format!("in/{name}"), strip(3));
    }
    let built = place.ok("build in/f.*.obj -o out/");
    let names: Vec<&str> = built.out.lines().filter_map(|l| l.split_whitespace().next()).collect();
    assert_eq!(names, ["out/f.9.bvhc", "out/f.10.bvhc"]);
    let none = place.run("build in/h*.obj -o out/");
    assert_eq!((none.code, none.err.contains("no file matches the pattern")), (3, true), "{}", none.err);

    // A file of that very name is meant before what the pattern would match.
    place.write("in/f[19].obj", strip(1));
    assert!(place.ok("build in/f[19].obj -o one.bvhc").out.contains("2 tris"));
}

#[test]
fn standard_input_gives_the_bytes_that_the_file_gives_but_for_its_name() {
    let place = Place::new();
    let model = strip(20);
    place.write("a.obj", &model);
    place.ok("build a.obj -o a.bvhc");
    for args in ["build - --input-format obj -o b.bvhc --force", "build - -o b.bvhc --force"] {
        let built = piped(&place, args, model.as_bytes());
        assert_eq!(built.code, 0, "{}", built.err);
        let id = |file: &str| place.ok(&format!("info {file} --field content_id")).out;
        assert_eq!(id("a.bvhc"), id("b.bvhc"));
    }
    place.ok("check b.bvhc --source a.obj");

    // Up to date by content, whether it comes through the pipe or from a file.
    assert!(piped(&place, "build - -o b.bvhc", model.as_bytes()).out.contains("up to date"));
    assert!(piped(&place, "build - -o a.bvhc", model.as_bytes()).out.contains("up to date"));
    assert!(place.ok("build a.obj -o b.bvhc").out.contains("up to date"));
    assert!(piped(&place, "build - -o b.bvhc -v", strip(21).as_bytes()).err.contains("the model changed"));
}

#[test]
fn standard_input_that_cannot_be_built_is_refused() {
    let place = Place::new();
    let (json, bin) = gltf("tri");
    place.write("tri.bin", bin);
    let refused = |args: &str, model: &[u8]| piped(&place, args, model).code;
    assert_eq!(refused("build - --input-format gltf -o a.bvhc", json.as_bytes()), 4, "its buffer lies in another file");
    assert_eq!(refused("build - -o a.bvhc", b"\x00\x01"), 5);
    assert_eq!(refused("build - -o out/", strip(1).as_bytes()), 2);
    assert_eq!(refused("build - - -o out/", strip(1).as_bytes()), 2);
    assert_eq!(refused("build - -o a.bvhc --depfile a.d", strip(1).as_bytes()), 2);
    assert_eq!(refused("build - -o a.bvhc --max-memory 10", strip(1).as_bytes()), 6);
    assert_eq!(refused("build tri.gltf --input-format gltf -o a.bvhc", b""), 2);
    assert_eq!(place.names(), ["tri.bin"]);
}

#[test]
fn what_cannot_succeed_says_how_it_could() {
    let place = Place::new();
    place.write("a.obj", strip(3));
    place.write("nothing.obj", "");
    place.ok("build a.obj -o good.bvhc");
    for (args, code, fix) in [
        ("build a.obj -o no/where/a.bvhc", 3, "mkdir -p no/where"),
        ("build a.obj -o a.obj/a.bvhc", 3, "a.obj is not a folder"),
        ("build . -o a.bvhc", 2, "write -o a.bvhc/"),
        ("build a.obj -o -", 2, "./-"),
        ("convert good.bvhc -o -", 2, "./-"),
        ("convert good.bvhc -o no/where/a.bvhc", 3, "mkdir -p no/where"),
        ("convert good.bvhc -o a.obj/a.bvhc", 3, "a.obj is not a folder"),
        ("build b.obj -o a.bvhc", 3, "paths start from"),
        ("build b.obj -o a.bvhc --dry-run", 3, "paths start from"),
        ("build a.obj -o a.bvhc --jobs 100000", 2, "0 to 1024"),
        ("stats a.obj", 1, "bvhc build MODEL"),
        ("check a.obj", 1, "bvhc build MODEL"),
        ("build nothing.obj -o n.bvhc", 4, "--empty keep"),
    ] {
        let said = place.run(args);
        assert_eq!(said.code, code, "{args}: {}", said.err);
        assert!((said.err.clone() + &said.out).contains(fix), "{args}: {}", said.err);
    }
}

#[test]
fn a_dry_run_reads_what_would_be_built_and_tells_what_is_wrong_with_it() {
    let place = Place::new();
    place.write("good.obj", strip(3));
    place.write("bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n");
    place.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    let said = place.run("build good.obj bad.obj flat.obj -o out/ -n");
    assert_eq!(said.code, 10, "{}{}", said.out, said.err);
    assert_eq!(said.out, "out/good.bvhc  would build: missing\n");
    assert!(said.err.contains("cannot read bad.obj line 3") && said.err.contains("there is no triangle in flat.obj"));
    assert!(said.err.contains("help: correct line 3, or export the model once more"), "{}", said.err);
    assert!(said.err.contains("1 would be built, 2 failed"), "{}", said.err);
    assert_eq!(place.names(), ["bad.obj", "flat.obj", "good.obj"], "nothing is written");
    // What is up to date is not read, and what is wrong with it does not matter.
    place.ok("build flat.obj -o flat.bvhc --empty keep");
    assert!(place.ok("build flat.obj -o flat.bvhc --empty keep -n").err.is_empty());
    // A place that cannot be written is told as well, but for a folder that the build makes.
    let no_folder = place.run("build good.obj -o nowhere/good.bvhc -n");
    assert!(no_folder.code == 3 && no_folder.err.contains("there is no folder nowhere"), "{}", no_folder.err);
}

#[test]
fn what_an_obj_has_that_is_not_read_is_told_with_its_line() {
    let place = Place::new();
    place.write("a.obj", format!("{}<<<<<<< ours\nF 1 2 3\ncall b.obj\n", strip(3)));
    let said = place.ok("build a.obj -o a.bvhc");
    assert_eq!(said.err, "warning: a.obj: left out 3 unknown statements (the first is '<<<<<<<' in line 15)\n");
    assert!(place.ok("info a.bvhc").out.contains("3 unknown statements"));
    place.write("e.obj", format!("{}\u{1b}[2J 1\n", strip(3)));
    let said = place.ok("build e.obj -o e.bvhc");
    assert!(said.err.contains("\\u{1b}[2J") && !said.err.contains('\u{1b}'), "{}", said.err);
    place.write("b.obj", format!("{}v 0 1e39 0\nf 1 2 -1\n", strip(3)));
    let said = place.ok("build b.obj -o b.bvhc");
    let told = "left out 1 triangle with positions beyond the range of f32 (1.0e39; the limit is 3.4e38)";
    assert!(said.err.contains(told), "{}", said.err);
    let wide: Vec<u8> = format!("\u{feff}{}", strip(3)).encode_utf16().flat_map(u16::to_le_bytes).collect();
    place.write("c.obj", wide);
    let said = place.run("build c.obj -o c.bvhc");
    assert!(said.code == 4 && said.err.contains("text in UTF-16"), "{}", said.err);
    assert!(said.err.contains("help: save it as UTF-8"), "{}", said.err);
    let face = |corners: usize| format!("f{}\n", " 1".repeat(corners));
    place.write("d.obj", format!("{}{}", strip(3), face(16_385)));
    let said = place.run("build d.obj -o d.bvhc");
    assert!(said.code == 6 && said.err.contains("cannot read d.obj line 15"), "{} {}", said.code, said.err);
    assert!(said.err.contains("the limit is 16384") && said.err.contains("help: export the model in triangles"));
}

#[test]
fn outputs_without_a_name_stand_beside_their_inputs() {
    let place = Place::new();
    place.write("a.obj", strip(3));
    place.write("in/b.obj", strip(4));
    place.ok("build a.obj in/b.obj");
    assert!(place.path("a.bvhc").exists() && place.path("in/b.bvhc").exists());
    assert!(place.ok("build a.obj").out.contains("a.bvhc  up to date"));
    place.write("a.glb", "glTF");
    for (args, fix) in [
        ("build a.obj a.glb", "another folder"),
        ("build in/f.%d.obj", "-o frames.bvhc"),
        ("build -", "name the file itself with -o"),
    ] {
        place.write("in/f.1.obj", strip(1));
        place.write("in/f.2.obj", strip(2));
        let said = piped(&place, args, strip(2).as_bytes());
        assert!(said.code == 2 && said.err.contains(fix), "{args}: {}", said.err);
    }
}

#[test]
fn every_command_takes_quoted_patterns() {
    let place = Place::new();
    for (name, size) in [("a10", 3), ("a9", 4)] {
        place.write(&format!("{name}.obj"), strip(size));
        place.ok(&format!("build {name}.obj"));
    }
    for command in ["info", "check", "stats", "verify --device cpu --rays 100", "verify --device cpu --ray 0,0,0,0,0,1"]
    {
        let said = place.run(&format!("{command} a*.bvhc"));
        let (first, second) = (said.out.find("a9.bvhc"), said.out.find("a10.bvhc"));
        assert!(said.code == 0 && first.is_some() && first < second, "{command}: {}{}", said.out, said.err);
        let none = place.run(&format!("{command} c*.bvhc"));
        assert!(none.code == 3 && none.err.contains("no file matches"), "{command}: {}", none.err);
    }
    assert!(place.ok("help check").out.contains("Usage: bvhc check"));
}

#[test]
fn a_search_that_gives_way_to_one_recipe_says_so() {
    let place = Place::new();
    place.write("a.obj", strip(30));
    for asked in ["--bins 16", "--preset best --bins 16"] {
        let said = place.ok(&format!("build a.obj -f {asked}"));
        assert!(said.err.contains("does not read --bins 16") && said.err.contains("`sbvh`"), "{asked}: {}", said.err);
    }
    for asked in ["", "--method sbvh --bins 16", "--preset balanced --bins 16"] {
        assert!(!place.ok(&format!("build a.obj -f {asked}")).err.contains("does not read"), "{asked}");
    }
}

#[test]
fn a_face_that_is_cut_off_is_told_as_what_it_is() {
    let place = Place::new();
    place.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\nf ");
    let said = place.ok("build a.obj");
    let told = "left out 1 line and point primitive, 1 face of fewer than three corners";
    assert!(said.err.contains(told), "{}", said.err);
}

#[test]
fn warnings_are_errors_where_asked() {
    let place = Place::new();
    place.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n");
    place.write("b.obj", strip(3));
    let said = place.run("build a.obj b.obj -o out/ --warnings-as-errors");
    assert!(said.code == 10 && said.err.contains("left out 1 line and point primitive"), "{}", said.err);
    assert!(!place.path("out/a.bvhc").exists() && place.path("out/b.bvhc").exists());
    assert_eq!(place.run("build a.obj --warnings-as-errors -n").code, 4);
    // What was built before is no better for being up to date.
    place.ok("build a.obj b.obj");
    assert!(place.ok("build b.obj --warnings-as-errors").out.contains("up to date"));
    assert_eq!(place.run("build a.obj --warnings-as-errors").code, 4);
    place.write("f.1.obj", strip(3));
    place.write("f.2.obj", strip(3) + "l 1 2\n");
    assert_eq!(place.run("build f.%d.obj -o f.bvhc --warnings-as-errors").code, 4);
    assert!(!place.path("f.bvhc").exists());
    place.ok("build f.%d.obj -o f.bvhc");
    let said = place.run("build f.%d.obj -o f.bvhc --warnings-as-errors");
    assert!(said.code == 4 && said.err.contains("skipped primitives: 1"), "{}", said.err);
}

#[test]
fn frames_that_are_empty_or_left_out_are_warnings_too() {
    let place = Place::new();
    let built = |pattern: &str| place.run(&format!("build {pattern} -o f.bvhc -q --warnings-as-errors")).code;
    place.write("f.1.obj", strip(3));
    place.write("f.2.obj", "v 0 0 0\n");
    assert_eq!(built("f.%d.obj"), 4);
    place.ok("build f.%d.obj -o f.bvhc -q");
    assert_eq!(built("f.%d.obj"), 4, "up to date");
    // A file of another padding is nobody's frame; that frames are missing is what --missing accepts.
    place.write("f.2.obj", strip(3));
    assert_eq!(built("f.%d.obj"), 0);
    place.write("f.4.obj", strip(3));
    assert_eq!(built("f.%d.obj --missing skip"), 0);
    place.write("f.03.obj", strip(3));
    assert_eq!(built("f.%d.obj --missing skip"), 4);
}

#[test]
fn a_policy_that_was_typed_is_no_warning() {
    let place = Place::new();
    place.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\n");
    for (options, code) in [("", 4), ("--degenerate drop", 0), ("--degenerate keep", 0), ("--degenerate error", 4)] {
        assert_eq!(place.run(&format!("build a.obj -f --warnings-as-errors {options}")).code, code, "{options}");
        assert_eq!(place.run(&format!("build a.obj --warnings-as-errors {options}")).code, code, "{options}, again");
    }
    place.write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\nl 1 2\n");
    assert_eq!(place.run("build b.obj --warnings-as-errors --degenerate drop").code, 4);
}

#[test]
fn long_names_are_cut_and_stay_apart() {
    let place = Place::new();
    let long = "x".repeat(5000);
    let group = |end: char, first: u32| {
        format!("g {long}{end}\nv 0 0 {first}\nv 1 0 {first}\nv 0 1 {first}\nf {first} {} {}\n", first + 1, first + 2)
    };
    place.write("a.obj", group('A', 1) + &group('B', 4));
    place.ok("build a.obj -o a.bvhc --warnings-as-errors");
    place.ok("check a.bvhc --source a.obj");
    let cache = bvhc::cache::Cache::open(place.path("a.bvhc")).unwrap();
    let names = cache.names();
    let (first, second) = (names.get(0).unwrap(), names.get(1).unwrap());
    assert!(first != second && first.len() <= 4096 && first.starts_with("/xxx"), "{first} {second}");
}

#[test]
fn a_data_uri_may_stand_behind_white_space_and_is_never_shown() {
    let place = Place::new();
    let (model, bin) = gltf("t");
    let base64 = {
        use base64::Engine;
        base64::engine::general_purpose::STANDARD.encode(&bin)
    };
    place.write("a.gltf", model.replace("t.bin", &format!("  data:;base64,{base64}")));
    place.ok("build a.gltf -o a.bvhc");
    for start in ["data;base64,", ";base64,", "application/octet-stream;base64,"] {
        place.write("b.gltf", model.replace("t.bin", &format!("{start}{base64}")));
        let said = place.run("build b.gltf -o b.bvhc");
        assert!(said.code == 4 && said.err.contains("looks like a data URI"), "{}", said.err);
        assert!(!said.err.contains(&base64[..12]), "{}", said.err);
    }
}
