//! `bvhc build`: what is written, what is refused, and what is said.

use crate::{Place, gltf, strip};
use bvhc::build::{METHODS, option};

/// A folder with `a.obj` and its cache.
fn built() -> Place {
    let place = Place::new();
    place.write("a.obj", strip(50));
    place.ok("build a.obj -o a.bvhc");
    place
}

#[test]
fn the_line_names_counts_size_and_time() {
    let place = Place::new();
    place.write("a.obj", strip(500));
    let said = place.ok("build a.obj -o a.bvhc --method binned");
    assert!(said.out.starts_with("a.bvhc  1,000 tris → 1,000 refs (+0.0%), "), "{}", said.out);
    for word in [" nodes, depth ", ", SAH ", " KiB, "] {
        assert!(said.out.contains(word), "{word} in {}", said.out);
    }
    assert_eq!(said.out.lines().count(), 1);
    assert_eq!(said.err, "");
}

#[test]
fn build_check_stats_work_end_to_end() {
    let place = built();
    assert_eq!(place.run("check a.bvhc").code, 0);
    assert!(place.ok("stats a.bvhc").out.contains("SAH"));
}

#[test]
fn several_inputs_go_to_a_folder() {
    let place = Place::new();
    place.write("a.obj", strip(5));
    place.write("b.obj", strip(6));
    let said = place.ok("build a.obj b.obj -o out/");
    assert_eq!(said.out.lines().count(), 2);
    assert!(said.err.contains("2 built"));
    assert!(place.path("out/a.bvhc").exists() && place.path("out/b.bvhc").exists());
    assert!(place.ok("build a.obj b.obj -o out").err.contains("2 up to date"), "an existing folder needs no slash");
    assert_eq!(place.run("build a.obj b.obj -o one.bvhc").code, 2);
    place.ok("build a.obj -o alone/");
    assert!(place.path("alone/a.bvhc").exists());
}

#[test]
fn inputs_of_one_name_are_refused_before_anything_is_written() {
    let place = Place::new();
    place.write("x/a.obj", strip(5));
    place.write("y/a.obj", strip(6));
    let said = place.run("build x/a.obj y/a.obj -o out/");
    assert_eq!(said.code, 2);
    assert!(said.err.contains("x/a.obj and y/a.obj would both become out/a.bvhc"), "{}", said.err);
    assert!(!place.path("out").exists());
}

#[test]
fn one_bad_input_does_not_stop_the_others() {
    let place = Place::new();
    place.write("a.obj", strip(5));
    place.write("bad.obj", "v 0 0 0\nf 1 2 99\n");
    place.write("worse.obj", "v zero 0 0\nf 1 1 1\n");
    let said = place.run("build bad.obj a.obj missing.obj -o out/");
    assert_eq!(said.code, 10, "{}", said.err);
    assert!(place.path("out/a.bvhc").exists() && !place.path("out/bad.bvhc").exists());
    assert!(said.err.contains("error: cannot build out/bad.bvhc\n  cannot read bad.obj"), "{}", said.err);
    assert!(said.err.ends_with("1 built, 2 failed\n"), "{}", said.err);
    assert_eq!(place.run("build bad.obj worse.obj -o out/").code, 4, "all failed alike");
    assert_eq!(place.run("build missing.obj gone.obj -o out/").code, 3);
}

#[test]
fn an_existing_output_survives_every_failure() {
    let place = built();
    let before = place.read("a.bvhc");
    place.write("a.obj", "v 0 0 0\nf 1 2 99\n");
    assert_eq!(place.run("build a.obj -o a.bvhc").code, 4);
    assert_eq!(place.run("build gone.obj -o a.bvhc").code, 3);
    assert_eq!(place.read("a.bvhc"), before);
    assert_eq!(place.names(), ["a.bvhc", "a.obj"]);
}

#[test]
fn an_output_that_is_an_input_is_refused() {
    let place = Place::new();
    let text = strip(5);
    place.write("a.obj", &text);
    assert_eq!(place.run("build a.obj -o a.obj").code, 2);
    assert_eq!(place.run("build a.obj -o ./a.obj").code, 2);
    assert_eq!(place.run("build a.obj -o a.bvhc --depfile a.obj").code, 2);
    assert_eq!(place.run("build a.obj -o a.bvhc --depfile a.bvhc").code, 2);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.obj", place.path("link.bvhc")).unwrap();
        assert_eq!(place.run("build a.obj -o link.bvhc").code, 2);
    }
    assert_eq!(place.read("a.obj"), text.as_bytes());

    let (model, bin) = gltf("t");
    place.write("t.gltf", model);
    place.write("t.bin", &bin);
    let said = place.run("build t.gltf -o t.bin --force");
    assert_eq!(said.code, 2, "{}", said.err);
    assert_eq!(place.read("t.bin"), bin);
}

#[test]
fn an_output_that_cannot_be_written_is_an_io_error() {
    let place = Place::new();
    place.write("a.obj", strip(5));
    let said = place.run("build a.obj -o no/such/folder/a.bvhc");
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.starts_with("error: cannot build no/such/folder/a.bvhc\n"), "{}", said.err);
    place.write("file", "");
    assert_eq!(place.run("build a.obj -o file/").code, 3);
}

#[test]
fn a_folder_or_a_pipe_is_no_model() {
    let place = Place::new();
    std::fs::create_dir(place.path("folder.obj")).unwrap();
    assert_eq!(place.run("build folder.obj -o a.bvhc").code, 3);
    #[cfg(unix)]
    {
        assert!(std::process::Command::new("mkfifo").arg(place.path("pipe.obj")).status().unwrap().success());
        let said = place.run("build pipe.obj -o a.bvhc");
        assert_eq!(said.code, 3, "and it does not wait for a writer: {}", said.err);
        assert_eq!(place.run("check pipe.obj").code, 3);
    }
}

#[test]
fn what_was_left_out_is_said() {
    let place = Place::new();
    place.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\n");
    let said = place.ok("build a.obj -o a.bvhc");
    assert_eq!(said.err, "warning: a.obj: left out 1 triangle without area\n");
    assert_eq!(place.ok("build a.obj -o b.bvhc -q").err, "");
    assert_eq!(place.run("build a.obj -o c.bvhc --degenerate error").code, 4);
}

#[test]
fn quiet_says_nothing_and_verbose_says_where_the_time_went() {
    let place = Place::new();
    place.write("a.obj", strip(5));
    let said = place.ok("build a.obj -o a.bvhc -q");
    assert_eq!((said.out.as_str(), said.err.as_str()), ("", ""));
    let said = place.ok("build a.obj -o b.bvhc -v");
    assert!(said.err.contains("read ") && said.err.contains("build ") && said.err.contains("write "), "{}", said.err);
}

#[test]
fn json_is_one_document_with_every_result() {
    let place = Place::new();
    place.write("a.obj", strip(5));
    place.write("bad.obj", "v 0 0 0\nf 1 2 99\n");
    let said = place.run("build a.obj bad.obj -o out/ --json");
    let all = said.json();
    assert_eq!((all["schema"].as_str(), all["exit_code"].as_i64(), said.code), (Some("bvhc.build.v1"), Some(10), 10));
    let [good, bad] = all["files"].as_array().unwrap().as_slice() else { panic!("{all}") };
    assert_eq!((good["status"].as_str(), good["built"]["triangles"].as_u64()), (Some("built"), Some(10)));
    assert_eq!(good["build_key"].as_str().unwrap().len(), 64);
    assert!(good["built"]["times"]["total_ms"].as_f64().unwrap() > 0.0);
    assert_eq!((bad["status"].as_str(), bad["error"]["exit_code"].as_u64()), (Some("failed"), Some(4)));
    let error: serde_json::Value = serde_json::from_str(said.err.trim()).unwrap();
    assert_eq!((error["reason"].as_str(), error["exit_name"].as_str()), (Some("error"), Some("model")));

    let again = place.ok("build a.obj -o out/ --json").json();
    assert_eq!(again["files"][0]["status"], "up-to-date");
    assert_eq!(again["files"][0]["build_key"], good["build_key"]);
}

#[test]
fn every_tree_option_is_accepted_and_reaches_the_file() {
    let place = Place::new();
    place.write("a.obj", strip(50));
    place.ok(
        "build a.obj -o a.bvhc --preset balanced --builder sbvh --axes longest --bins 8 -O spatial-bins=9 -O max-leaf=3 -O sah-trav=2 \
         -O sah-isect=1.5 -O clip=box --split-alpha 0.25 --split-budget 1.125 -O unsplit=false --reinsert 5 --adapt 77 -O collapse=true --levels two --rays-for bake",
    );
    let options = place.ok("info a.bvhc --field meta.options").out;
    for (name, value) in [
        ("axes", "longest"),
        ("bins", "8"),
        ("spatial-bins", "9"),
        ("max-leaf", "3"),
        ("sah-trav", "2"),
        ("sah-isect", "1.5"),
        ("clip", "box"),
        ("split-alpha", "0.25"),
        ("split-budget", "1.125"),
        ("unsplit", "false"),
        ("reinsert", "5"),
        ("adapt", "77"),
        ("collapse", "true"),
        ("levels", "two"),
        ("rays-for", "bake"),
        ("degenerate", "drop"),
    ] {
        assert!(options.contains(&format!(r#"{{"name":"{name}","value":"{value}"}}"#)), "{name} in {options}");
    }
    place.ok("build a.obj -o a.bvhc --preset draft --method agglomerative -O radius=5 -O presplit=0.25");
    let options = place.ok("info a.bvhc --field meta.options").out;
    for (name, value) in [("radius", "5"), ("presplit", "0.25"), ("max-leaf", "8")] {
        assert!(options.contains(&format!(r#"{{"name":"{name}","value":"{value}"}}"#)), "{name} in {options}");
    }
    assert_eq!(place.run("build a.obj -o a.bvhc --flatten --levels two").code, 2);
    assert_eq!(place.run("build a.obj -o a.bvhc --method octree").code, 2);
}

/// Nothing that was typed is ignored in silence: what is not read is refused, and the methods that read it are named.
#[test]
fn an_option_that_is_not_read_is_refused() {
    let place = Place::new();
    place.write("a.obj", strip(50));
    // The names of the methods that read an option, as the table of options has them.
    let readers = |name: &str| {
        let row = option(name).unwrap();
        let rows = METHODS.iter().filter(|method| row.is_read_by(method.method));
        rows.map(|method| method.name).collect::<Vec<_>>().join(", ")
    };
    let cutters = &*readers("presplit");
    for (args, readers) in [
        ("-O presplit=0.3", cutters),
        ("--preset best -O presplit=0.3", cutters),
        ("-O prune=1", "bonsai"),
        ("-O radius=3", "agglomerative, oabb"),
        ("-O basis=leaf", "oabb"),
        ("--method oabb -O presplit=0.3", cutters),
        ("--method binned --spatial-bins 8", "sbvh"),
        ("--preset draft -O spatial-bins=8", "sbvh"),
        ("--method auto --bins 64", "binned, sbvh"),
        ("--method best --reinsert 8", &readers("reinsert")),
        ("--preset balanced -O presplit=0.3", cutters),
    ] {
        let said = place.run(&format!("build a.obj -o a.bvhc {args}"));
        assert_eq!(said.code, 2, "{args}: {}{}", said.out, said.err);
        assert!(said.err.contains(&format!("is read by {readers}\n")), "{args}: {}", said.err);
    }
    assert_eq!(place.names(), ["a.obj"]);
    place.ok("build a.obj -o a.bvhc --bins 64 --reinsert 8");
    place.ok("build a.obj -o a.bvhc --preset best --split-budget 1.1 -O max-leaf=4 --flatten");
}

#[test]
fn a_scene_is_chosen_only_where_there_are_scenes() {
    let place = Place::new();
    place.write("a.obj", strip(5));
    place.write("untold", strip(5));
    let (model, bin) = gltf("t");
    place.write("t.gltf", model);
    place.write("t.bin", bin);
    for input in ["a.obj", "untold"] {
        let said = place.run(&format!("build {input} -o a.bvhc --scene 3"));
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.contains("OBJ model, which has no scenes") && said.err.contains("--scene 3"), "{}", said.err);
        assert_eq!(place.run(&format!("build {input} -o a.bvhc --scene 0 -n")).code, 2);
    }
    let mut piped = place.command();
    piped.args(["build", "-", "-o", "a.bvhc", "--scene", "0"]).stdin(std::fs::File::open(place.path("a.obj")).unwrap());
    assert_eq!(piped.output().unwrap().status.code(), Some(2));
    place.ok("build t.gltf -o t.bvhc --scene 0");
}

#[test]
fn two_builds_of_one_output_at_once_leave_a_whole_file() {
    let place = Place::new();
    place.write("a.obj", strip(4000));
    let start =
        |bins: &str| place.command().args(["build", "a.obj", "-o", "a.bvhc", "-f", "--bins", bins]).spawn().unwrap();
    for _ in 0..3 {
        let mut both = [start("8"), start("16")];
        for child in &mut both {
            let code = child.wait().unwrap().code().unwrap();
            assert!(code == 0 || code == 75, "{code}");
        }
        place.ok("check a.bvhc");
    }
    assert_eq!(place.names(), ["a.bvhc", "a.obj"]);
}

#[test]
fn memory_for_duplicates_is_limited_before_it_is_set_aside() {
    let place = Place::new();
    place.write("a.obj", strip(1000));
    let said = place.run("build a.obj -o a.bvhc --split-budget 64 --max-memory 2M");
    assert_eq!(said.code, 6, "{}{}", said.out, said.err);
    assert!(said.err.contains("2,000 triangles need 3.9 MiB") && said.err.contains("--max-memory"), "{}", said.err);
    assert!(!place.names().contains(&"a.bvhc".to_string()));
    place.ok("build a.obj -o a.bvhc --max-memory 2M");
}
