//! What is written over, what is written of nothing, and what a damaged output is taken for.

use crate::common::cases_dir;
use crate::{Place, gltf, said, strip};

#[test]
fn a_file_that_is_no_cache_is_not_replaced() {
    let place = Place::new();
    let other = strip(7);
    place.write("a.obj", strip(5));
    place.write("b.obj", &other);
    for args in ["build a.obj -o b.obj", "build a.obj -o b.obj -n", "build a.obj -o b.obj --codec zstd"] {
        let said = place.run(args);
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.contains("b.obj") && said.err.contains("not a .bvhc file"), "{}", said.err);
        assert!(said.err.contains("help: ") && said.err.contains("--force"), "{}", said.err);
    }
    place.ok("build a.obj -o a.bvhc");
    assert_eq!(place.run("convert a.bvhc -o b.obj").code, 2);
    assert_eq!(place.run("build a.obj -o c.bvhc --depfile b.obj").code, 2);
    assert_eq!(place.read("b.obj"), other.as_bytes());

    // What is asked for by name is done.
    place.ok("convert a.bvhc -o b.obj --force");
    assert_eq!(place.read("b.obj"), place.read("a.bvhc"));
    place.write("b.obj", &other);
    place.ok("build a.obj -o b.obj --force");
    place.ok("check b.obj");
}

#[cfg(unix)]
#[test]
fn one_folder_under_two_names_is_one_place() {
    let place = Place::new();
    place.write("a/x.obj", strip(5));
    std::os::unix::fs::symlink("a", place.path("b")).unwrap();
    for more in ["", " -n"] {
        let said = place.run(&format!("build a/x.obj b/x.obj{more}"));
        assert!(said.code == 2 && said.err.contains("a/x.obj and b/x.obj would both become"), "{}", said.err);
    }
    assert!(!place.path("a/x.bvhc").exists());
}

/// As a user who may not write there; root may write anywhere.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_no_files_is_told_before_the_build() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    use std::os::unix::process::CommandExt;
    let place = Place::new();
    place.write("a.obj", strip(5));
    place.write("b.obj", strip(5));
    std::fs::create_dir(place.path("out")).unwrap();
    let allow = |name: &str, mode| {
        std::fs::set_permissions(place.path(name), std::fs::Permissions::from_mode(mode)).unwrap();
    };
    allow("out", 0o555);
    allow("", 0o755);
    let is_root = place.path("out").metadata().unwrap().uid() == 0;
    // The program itself may lie where nobody else looks. Another process copies it: a file that this one has open for writing is open in what other tests start at
    // that moment, too, and is then too busy to be run.
    let copied = std::process::Command::new("cp").arg(crate::program()).arg(place.path("bvhc")).status();
    assert!(copied.unwrap().success());
    allow("bvhc", 0o755);
    for more in ["", "-n"] {
        let mut command = std::process::Command::new(place.path("bvhc"));
        command.current_dir(place.root()).args(["build", "a.obj", "b.obj", "-o", "out/"]);
        command.args(Some(more).filter(|more| !more.is_empty()));
        if is_root {
            command.uid(65_534).gid(65_534);
        }
        let said = said(command.output().unwrap());
        assert_eq!(said.code, 3, "{more}: {}{}", said.out, said.err);
        assert_eq!(said.err.matches("the folder out takes no files: Permission denied").count(), 2, "{}", said.err);
        assert!(said.out.is_empty() && !said.err.contains(".tmp"), "{}{}", said.out, said.err);
    }
    allow("out", 0o755);
}

#[test]
fn caches_empty_files_and_depfiles_are_replaced() {
    let place = Place::new();
    place.write("a.obj", strip(5));
    place.write("b.obj", strip(6));
    place.ok("build a.obj -o out.bvhc");
    place.ok("build b.obj -o out.bvhc --depfile out.d");
    place.ok("build a.obj -o out.bvhc --depfile out.d");
    place.ok("convert out.bvhc -o small.bvhc --codec zstd");
    place.ok("convert out.bvhc -o small.bvhc --codec raw");
    place.write("empty", "");
    place.ok("build a.obj -o empty");
}

#[test]
fn a_damaged_output_is_built_again() {
    for codec in ["raw", "zstd"] {
        let place = Place::new();
        place.write("a.obj", strip(400));
        let build = format!("build a.obj -o a.bvhc --preset draft --codec {codec}");
        place.ok(&build);
        let good = place.read("a.bvhc");
        for at in (0..good.len()).step_by(good.len() / 23).filter(|at| *at >= 8).chain([good.len() - 1]) {
            let mut bad = good.clone();
            bad[at] ^= 0x10;
            place.write("a.bvhc", &bad);
            assert!(place.ok(&format!("{build} -n")).out.contains("would build: "), "byte {at}");
            assert!(!place.ok(&build).out.contains("up to date"), "byte {at}");
            assert_eq!(place.read("a.bvhc"), good, "byte {at}");
        }
        assert!(place.ok(&build).out.contains("up to date"));
    }
}

#[test]
fn no_model_is_no_cache() {
    let place = Place::new();
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0123\nsize 2380763\n";
    for (name, text, advice) in [
        ("rock.obj", pointer, "git lfs pull"),
        ("page.obj", "<!DOCTYPE html><html><body>Not Found</body></html>\n", "download"),
        ("upper.obj", "V 0 0 0\nV 1 0 0\nV 0 1 0\nF 1 2 3\n", "small letters"),
    ] {
        place.write(name, text);
        for policy in ["", " --empty keep"] {
            let said = place.run(&format!("build {name} -o out.bvhc{policy}"));
            assert_eq!(said.code, 4, "{}", said.err);
            assert!(said.err.contains(advice) && !place.path("out.bvhc").exists(), "{}", said.err);
        }
    }
}

#[test]
fn a_model_of_no_triangle_is_refused_unless_it_may_be_empty() {
    let place = Place::new();
    place.write("none.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
    place.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 3 2 1\n");
    place.write("blank.obj", "# nothing here\n");
    let (model, bin) = gltf("t");
    place.write("t.bin", &bin);
    place.write("none.gltf", model.replace(r#""nodes":[0]"#, r#""nodes":[]"#));
    for (name, fact) in [
        ("none.obj", "left out 1 line and point primitive"),
        ("flat.obj", "left out 2 triangles without area"),
        ("blank.obj", "there is no triangle in blank.obj"),
        ("none.gltf", "there is no triangle in none.gltf"),
    ] {
        let said = place.run(&format!("build {name} -o out.bvhc"));
        assert_eq!(said.code, 4, "{}", said.err);
        assert!(said.err.contains(fact) && said.err.contains("--empty keep"), "{}", said.err);
        assert!(!place.path("out.bvhc").exists());
        let said = place.ok(&format!("build {name} -o out.bvhc --empty keep"));
        assert!(said.err.contains("there is no triangle in it"), "{}", said.err);
        place.ok("check out.bvhc");
        let again = place.ok(&format!("build {name} -o out.bvhc --empty keep -v"));
        assert!(again.out.contains("up to date") && again.err.contains("there is no triangle in it"), "{}", again.err);
        // An empty cache is not what a build by the other policy would leave.
        assert_eq!(place.run(&format!("build {name} -o out.bvhc")).code, 4);
        std::fs::remove_file(place.path("out.bvhc")).unwrap();
    }
    place.ok("build flat.obj -o out.bvhc --degenerate keep");
}

#[test]
fn the_cases_of_outputs_are_right() {
    let Some(cases) = cases_dir() else { return };
    let place = Place::new();
    let copy = |from: &str, to: &str| place.write(to, std::fs::read(cases.join(from)).unwrap());
    for name in ["rock.obj", "page.obj", "upper.obj"] {
        copy(&format!("06-lfs-pointer-obj/{name}"), name);
        assert_eq!(place.run(&format!("build {name} -o out.bvhc")).code, 4, "{name}");
        assert!(!place.path("out.bvhc").exists());
    }
    for name in ["nul.obj", "nul_long.obj"] {
        copy(&format!("10-nul-at-end-obj/{name}"), name);
        assert!(place.ok(&format!("build {name} -o {name}.bvhc")).out.contains("  1 tri "), "{name}");
    }
    for name in ["two_objects.obj", "same_object_name.obj", "slash.obj"] {
        copy(&format!("07-objects-sharing-group-name/{name}"), name);
        place.ok(&format!("build {name} -o {name}.bvhc"));
        let cache = bvhc::cache::Cache::open(place.path(&format!("{name}.bvhc"))).unwrap();
        let rows: Vec<_> = cache.geoms().iter().map(|g| (g.source_part, g.first_prim, g.prim_count)).collect();
        assert_eq!(rows, [(0, 0, 1), (1, 1, 1)], "{name}");
    }
    copy("21-damaged-cache-up-to-date/tri.obj", "tri.obj");
    place.ok("build tri.obj -o tri.bvhc");
    let good = place.read("tri.bvhc");
    for section in ["NODE", "TRIS", "GEOM", "BLAS", "META"] {
        let cache = bvhc::cache::Cache::open(place.path("tri.bvhc")).unwrap();
        let entry = cache.sections().iter().find(|s| s.kind.to_string() == section).unwrap();
        let mut bad = good.clone();
        bad[entry.offset as usize + 5] ^= 1;
        drop(cache);
        place.write("tri.bvhc", bad);
        assert!(!place.ok("build tri.obj -o tri.bvhc").out.contains("up to date"), "{section}");
        assert_eq!(place.read("tri.bvhc"), good, "{section}");
    }
}

/// Opening a pipe waits for its other end, and nobody is there: without a refusal these commands never end.
#[cfg(unix)]
#[test]
fn pipes_are_refused_at_once() {
    let place = Place::new();
    place.write("a.obj", strip(2));
    let (json, _) = gltf("pipe");
    place.write("a.gltf", json);
    for name in ["out.bvhc", "pipe.bin"] {
        assert!(std::process::Command::new("mkfifo").arg(place.path(name)).status().unwrap().success());
    }
    place.ok("build a.obj -o whole.bvhc");
    for (args, fact) in [
        ("build a.obj -o out.bvhc", "it is a pipe"),
        ("build a.obj -o out.bvhc --force", "it is a pipe"),
        ("convert whole.bvhc -o out.bvhc", "it is a pipe"),
        ("build a.gltf -o b.bvhc", "it is not a regular file"),
    ] {
        let said = place.run(args);
        assert_eq!(said.code, 3, "{args}: {}", said.err);
        assert!(said.err.contains(fact), "{args}: {}", said.err);
    }
}

/// As a full disk does, and without a signal that would leave a temporary file behind.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_on_the_size_of_files_is_an_io_error_and_leaves_nothing() {
    let place = Place::new();
    place.write("a.obj", strip(400));
    let limited = |args: &str| {
        let limited = format!("ulimit -f 1; exec {} {args}", crate::program().display());
        said(std::process::Command::new("sh").args(["-c", &limited]).current_dir(place.root()).output().unwrap())
    };
    let fails = |args: &str| {
        let said = limited(args);
        assert!(said.code == 3 && said.err.contains("cannot write"), "{args}, {}: {}", said.code, said.err);
    };
    fails("build a.obj -o a.bvhc");
    assert_eq!(place.names(), ["a.obj"]);

    // Reports and pictures that are there stay as they are.
    place.ok("build a.obj -o a.bvhc");
    for (args, output) in [
        ("view a.bvhc -o a.png --size 400x400 --shade cost", "a.png"),
        ("view a.bvhc --html a.html", "a.html"),
        ("verify a.bvhc --device cpu --rays 1000 --junit a.xml", "a.xml"),
        ("verify a.bvhc --accuracy --rays 1000 --svg a.svg", "a.svg"),
    ] {
        place.ok(args);
        let (before, names) = (place.read(output), place.names());
        fails(args);
        assert!(place.read(output) == before && place.names() == names, "{args}");
    }
}
