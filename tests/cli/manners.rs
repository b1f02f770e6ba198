//! Nothing is ignored in silence, and what is told is told in one form.

use crate::{Place, gltf, said, strip};

/// A cache file `a.bvhc` of `a.obj`.
fn built() -> Place {
    let place = Place::new();
    place.write("a.obj", strip(4));
    place.ok("build a.obj -o a.bvhc -q");
    place
}

#[test]
fn a_file_that_cannot_be_read_stands_in_the_document_with_its_error() {
    let place = built();
    for command in ["info", "check", "stats", "verify --device cpu --rays 100", "verify --accuracy --rays 50"] {
        let said = place.run(&format!("{command} gone.bvhc a.bvhc --json"));
        let files = said.json()["files"].clone();
        assert_eq!(said.code, 10, "{command}: {}", said.err);
        assert_eq!(files[0]["path"], "gone.bvhc", "{command}: {files}");
        assert_eq!(files[0]["error"]["exit_name"], "io", "{command}: {files}");
        assert_eq!((files[1]["path"].as_str(), files[1].get("error")), (Some("a.bvhc"), None), "{command}: {files}");
        assert_eq!(said.err.lines().filter(|line| line.contains("bvhc.error.v1")).count(), 1, "{command}");
    }
    let none = place.run("check gone.bvhc --json");
    assert_eq!((none.code, none.json()["files"][0]["error"]["exit_code"].as_u64()), (3, Some(3)));
}

#[test]
fn warnings_are_data_in_json_and_objects_on_stderr() {
    let place = Place::new();
    let flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\nF 1 2 3\n";
    place.write("a.obj", flat);
    let told = place.ok("build a.obj -o a.bvhc --json");
    let warnings = told.json()["files"][0]["warnings"].clone();
    let kinds: Vec<&str> = warnings.as_array().unwrap().iter().map(|w| w["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["without-area", "left-out"], "{warnings}");
    for line in told.err.lines() {
        let line: serde_json::Value = serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
        assert_eq!((line["schema"].as_str(), line["reason"].as_str()), (Some("bvhc.remark.v1"), Some("warning")));
    }
    assert_eq!(told.err.lines().count(), 2, "{}", told.err);
    assert_eq!(place.ok("build a.obj -o a.bvhc --force --json -q").err, "");

    // What is up to date still says so, and a dry run as well.
    let kinds = |args: &str| {
        let file = place.ok(args).json()["files"][0].clone();
        let kinds: Vec<String> =
            file["warnings"].as_array().unwrap().iter().map(|w| w["kind"].as_str().unwrap().to_owned()).collect();
        (file["status"].as_str().unwrap().to_owned(), kinds)
    };
    let both = ["without-area", "left-out"].map(String::from).to_vec();
    assert_eq!(kinds("build a.obj -o a.bvhc --json"), ("up-to-date".into(), both.clone()));
    assert_eq!(kinds("build a.obj -o b.bvhc -n --json"), ("would-build".into(), both));

    // Errors are told in the same form.
    let failed = place.run("check gone.bvhc --json");
    let line: serde_json::Value = serde_json::from_str(failed.err.trim()).unwrap();
    for part in [&line, &failed.json()["files"][0]["error"]] {
        assert_eq!(part["text"], "cannot open gone.bvhc", "{part}");
        assert!(part["facts"].is_array() && part["help"].is_string(), "{part}");
    }
    let warned: serde_json::Value = serde_json::from_str(told.err.lines().next().unwrap()).unwrap();
    assert!(warned["text"].is_string() && warned["facts"].is_array() && warned["help"].is_null(), "{warned}");
}

#[test]
fn what_no_model_reads_is_refused() {
    let place = built();
    let (model, bin) = gltf("t");
    place.write("t.gltf", model);
    place.write("t.bin", bin);
    for (args, named) in [
        ("build a.obj -o b.bvhc --scene 1", "--scene"),
        ("build a.obj -o b.bvhc --missing skip", "--missing"),
        ("check a.bvhc --source a.obj --clip Walk", "--clip"),
        ("verify a.bvhc --device cpu --device-timeout 5s", "--device-timeout"),
        ("verify a.bvhc --device cpu --reference brute --judge 5", "--judge"),
        ("build a.obj -o b.bvhc --depfile-phony", "--depfile-phony"),
    ] {
        let said = place.run(args);
        assert!(said.code == 2 && said.err.contains(named) && said.err.contains("help: "), "{args}: {}", said.err);
    }
    assert!(!place.path("b.bvhc").exists());
    // What only permits may stand everywhere, so that one rule of a build system serves all models.
    for flag in ["--allow-outside", "--ignore-extension KHR_x", "--at-rest"] {
        place.ok(&format!("build a.obj -o b.bvhc {flag}"));
        place.ok(&format!("build a.obj t.gltf -o out/ {flag}"));
    }
    place.ok("check a.bvhc --source a.obj --allow-outside");
    place.ok("verify a.bvhc --source a.obj --ignore-extension KHR_x --device cpu --rays 100");
}

#[test]
fn what_would_be_ignored_is_refused_or_told() {
    let place = built();
    place.write("many/b.obj", strip(4));
    place.write("many/c.obj", strip(5));
    for (args, told) in [
        ("build a.obj -o b.bvhc --method sweep --rays-for bake", "every other method with adapt"),
        ("build a.obj -o b.bvhc --reinsert 8 --rays-for bake", "every other method with adapt"),
        ("build a.obj -o b.bvhc --fps 24", "cannot read a.obj with --fps"),
        ("build a.obj -o b.bvhc --play 0..1", "cannot read a.obj with --play"),
        ("build a.obj -o b.bvhc --depfile -", "cannot write a depfile to standard output"),
        ("verify a.bvhc --list-devices", "devices are listed, and nothing is traced"),
        ("verify --list-devices --junit a.xml", "devices are listed, and nothing is traced"),
        ("verify a.bvhc --svg a.svg --junit a.xml", "cannot take --svg without --accuracy"),
        ("view a.bvhc -o a.png --depth 2", "cannot take --depth without --tree"),
        ("view a.bvhc -o a.png --scale 8", "the colours stand for no numbers"),
        ("stats a.bvhc --csv --depths", "and of no depth"),
        ("man --out -", "cannot write manual pages to standard output"),
        ("explain E01O1", "did you mean E0101?"),
        ("explain w04ol", "did you mean W0401?"),
    ] {
        let said = place.run(args);
        assert!(said.code == 2 && said.err.contains(told) && said.err.contains("help: "), "{args}: {}", said.err);
    }
    place.ok("build a.obj -o c.bvhc --rays-for bake");
    place.ok("build a.obj -o c.bvhc --method sweep --adapt 64 --rays-for bake");

    // A name that no model has may be misspelt; among several models some may lack it.
    let idle = "--ignore-extension KHR_x changes nothing";
    assert!(place.ok("build a.obj -o c.bvhc -f --ignore-extension KHR_x").err.contains(idle));
    assert!(!place.ok("build many -o out/ -f --ignore-extension KHR_x").err.contains(idle));
    assert!(place.ok("build many -o out/ -f -v --ignore-extension KHR_x").err.contains(idle));

    // An effort that is asked for later does not make the file another one.
    let late = "was not recorded then";
    assert!(place.ok("build a.obj -o c.bvhc --record-effort --ignore-extension KHR_x").err.contains(late));
    place.ok("build a.obj -o c.bvhc --record-effort -f");
    assert!(!place.ok("build a.obj -o c.bvhc --record-effort").err.contains(late));

    // Counts are written alike everywhere.
    place.ok("stats a.bvhc --rays 1k");
    assert_eq!(place.run("stats a.bvhc --rays 2M").code, 2);
    assert!(place.run("chart a.obj --rays 0 -o x.html").err.contains("write 1 or more"));
    assert_eq!(place.ok("man --out pages -q").out, "");
}

#[test]
fn what_was_asked_wrongly_is_not_blamed_on_the_model() {
    let place = built();
    let (model, bin) = gltf("t");
    place.write("t.gltf", model);
    place.write("t.bin", bin);
    let said = place.run("build t.gltf -o t.bvhc --scene 3");
    assert!(said.code == 4 && said.err.contains("it has no scene 3") && said.err.contains("--scene"), "{}", said.err);
    place.write("b.obj", b"glTF\x02\0\0\0\x20\0\0\0\x08\0\0\0JSON{}      ");
    let said = place.run("build b.obj -o t.bvhc");
    assert!(said.code == 4 && said.err.contains("a GLB model") && said.err.contains("*.glb"), "{}", said.err);
    place.write("a.glb", strip(4));
    let said = place.run("build a.glb -o t.bvhc");
    assert!(said.code == 4 && said.err.contains("an OBJ model") && said.err.contains("*.obj"), "{}", said.err);
}

#[test]
fn memory_is_told_of_what_was_built_alone() {
    let place = built();
    place.write("b.obj", strip(5));
    let peak = |args: &str| place.ok(args).json()["files"][0]["built"]["peak_memory"].clone();
    assert_eq!(peak("build a.obj b.obj -o caches/ --json"), serde_json::Value::Null, "the system counts a process");
    let told = place.ok("build a.obj b.obj -o caches/ -f -v").err;
    if cfg!(target_os = "linux") {
        assert!(peak("build a.obj -o c.bvhc --json").as_u64() > Some(1 << 20));
        assert!(told.contains("peak memory of all builds together") && !told.contains("per triangle"), "{told}");
    }
}

#[test]
fn flags_that_do_not_go_together_say_why() {
    let place = built();
    for (args, why, help) in [
        ("verify a.bvhc --frame 1 --source a.obj", "a model is one moment", "bvhc convert FILE -o STILL --frame N"),
        ("build a.obj -o b.bvhc --flatten --levels two", "short for --levels one", "leave out --flatten"),
        ("info a.bvhc --field content_id --json", "one value", "leave out --json"),
        ("stats a.bvhc --csv --json", "both are forms", "leave out --csv"),
        ("check a.bvhc -q -v", "fewer words", "leave out --quiet"),
    ] {
        let said = place.run(args);
        assert!(said.code == 2 && said.err.contains(why) && said.err.contains(help), "{args}: {}", said.err);
        let said = place.run(&format!("{args} --json"));
        let error: serde_json::Value = serde_json::from_str(said.err.trim()).unwrap_or_default();
        assert!(said.code == 2 && error["help"].is_string(), "{args}: {}", said.err);
    }
}

#[test]
fn a_bad_variable_is_called_by_its_name() {
    let place = built();
    for (variable, value) in [("BVHC_JOBS", "many"), ("BVHC_MAX_MEMORY", "much"), ("BVHC_COLOR", "blue")] {
        let run = |args: &[&str]| said(place.command().env(variable, value).args(args).output().unwrap());
        let told = run(&["info", "a.bvhc"]);
        assert!(told.code == 2 && told.err.contains(variable) && told.err.contains(value), "{}", told.err);
        assert!(told.err.contains(&format!("help: unset {variable}")), "{}", told.err);
        // A flag that is typed wins, and is blamed where it is wrong.
        let flag = format!("--{}", variable.trim_start_matches("BVHC_").to_lowercase().replace('_', "-"));
        let typed = run(&["info", "a.bvhc", &flag, "odd"]);
        assert!(typed.code == 2 && !typed.err.contains(variable), "{}", typed.err);
        let good = match variable {
            "BVHC_JOBS" => "1",
            "BVHC_MAX_MEMORY" => "1G",
            _ => "never",
        };
        for args in [["info", "a.bvhc", &flag, good], [&flag, good, "info", "a.bvhc"]] {
            assert_eq!(run(&args).code, 0, "{args:?}: nobody asks the variable");
        }
        let unset = said(place.command().env(variable, "").args(["info", "a.bvhc"]).output().unwrap());
        assert_eq!(unset.code, 0, "{}", unset.err);
        let wrong = said(place.command().env(variable, value).args(["info", "a.bvhc", "--json"]).output().unwrap());
        let error: serde_json::Value = serde_json::from_str(wrong.err.trim()).unwrap();
        assert_eq!(error["exit_code"], 2, "{}", wrong.err);
    }
}

#[test]
fn folders_stand_for_the_files_in_them() {
    let place = built();
    place.write("models/b9.obj", strip(3));
    place.write("models/b10.obj", strip(2));
    place.write("models/b.mtl", "");
    place.write("models/.b9.obj", "no model");
    place.ok("build models -o caches/");
    for command in ["info", "check", "stats", "verify --device cpu --rays 100"] {
        let said = place.ok(&format!("{command} caches"));
        let (first, second) = (said.out.find("b9.bvhc"), said.out.find("b10.bvhc"));
        assert!(first.is_some() && first < second, "{command}: {}", said.out);
        let none = place.run(&format!("{command} models"));
        assert!(none.code == 3 && none.err.contains("no cache file"), "{command}: {}", none.err);
    }
    assert_eq!(place.run("build caches -o other/").code, 3);
}

#[test]
fn each_of_several_outputs_has_a_depfile_of_its_own() {
    let place = built();
    place.write("b.obj", strip(3));
    for _ in 0..2 {
        place.ok("build a.obj b.obj -o out/ --depfile-dir deps/");
        assert_eq!(String::from_utf8(place.read("deps/a.bvhc.d")).unwrap(), "out/a.bvhc: \\\n  a.obj\n");
        assert_eq!(String::from_utf8(place.read("deps/b.bvhc.d")).unwrap(), "out/b.bvhc: \\\n  b.obj\n");
        std::fs::remove_dir_all(place.path("deps")).unwrap();
    }
    place.write("c/a.obj", strip(3));
    let twice = place.run("build a.obj c/a.obj --depfile-dir deps");
    assert!(twice.code == 2 && twice.err.contains("both have the depfile"), "{}", twice.err);
}

#[cfg(unix)]
#[test]
fn a_buffer_that_a_depfile_cannot_name_is_refused_before_the_build() {
    let place = Place::new();
    let (model, bin) = gltf("t%0A");
    place.write("t.gltf", model);
    place.write("t\n.bin", bin);
    for more in ["", " --dry-run"] {
        let said = place.run(&format!("build t.gltf -o t.bvhc --depfile t.d{more}"));
        assert!(said.code == 2 && said.err.contains("line break"), "{}", said.err);
    }
    assert!(!place.path("t.bvhc").exists() && !place.path("t.d").exists());
}

#[test]
fn what_is_no_document_has_no_json() {
    let place = Place::new();
    for args in ["completions bash --json", "man -o . --json"] {
        let said = place.run(args);
        assert!(said.code == 2 && said.out.is_empty() && said.err.contains("leave out --json"), "{args}: {}", said.err);
    }
}

#[test]
fn one_name_is_one_figure_in_build_info_and_stats() {
    let place = Place::new();
    place.write("a.gltf", instanced(9));
    place.write("t.bin", gltf("t").1);
    let build = place.ok("build a.gltf -o a.bvhc --json").json()["files"][0]["built"].clone();
    let stats = place.ok("stats a.bvhc --json").json()["files"][0].clone();
    assert_eq!(
        (build["nodes"].as_u64(), build["top_nodes"].as_u64()),
        (stats["blas"]["nodes"].as_u64(), stats["tlas"]["nodes"].as_u64())
    );
    assert_eq!(build["max_depth"], stats["blas"]["max_depth"]);
    let told = place.ok("info a.bvhc --json").json()["files"][0].clone();
    for name in ["triangles", "references", "nodes", "top_nodes", "trees", "instances"] {
        assert!(told[name].is_u64() && told[name] == build[name], "{name}: {told} {build}");
    }
    let (info, stats) = (place.ok("info a.bvhc").out, place.ok("stats a.bvhc").out);
    let row =
        |name: &str| stats.lines().find(|l| l.starts_with(name)).unwrap().split_whitespace().last().unwrap().to_owned();
    for (name, shown) in [("nodes", "nodes"), ("top-level nodes", "top-level nodes"), ("instances", "instances")] {
        let figure = format!("{} {shown}", row(name));
        assert!(info.contains(&figure), "{figure}: {info}");
    }
    assert!(row("top-level nodes").parse::<u32>().unwrap() > row("nodes").parse::<u32>().unwrap());
}

/// One triangle in so many places.
fn instanced(count: usize) -> String {
    let (model, _) = gltf("t");
    let node = |i: usize| format!(r#"{{"mesh":0,"translation":[{},0,0]}}"#, 3 * i);
    let nodes: Vec<String> = (0..count).map(node).collect();
    let scene: Vec<String> = (0..count).map(|i| i.to_string()).collect();
    model
        .replace(r#""nodes":[{"mesh":0}]"#, &format!(r#""nodes":[{}]"#, nodes.join(",")))
        .replace(r#"{"nodes":[0]}"#, &format!(r#"{{"nodes":[{}]}}"#, scene.join(",")))
}

#[test]
fn a_sequence_is_told_by_the_same_figures_everywhere() {
    let place = Place::new();
    for frame in 1..=3 {
        place.write(&format!("f.{frame}.obj"), bent_quad(frame));
    }
    let said = place.ok("build f.%d.obj -o f.bvhc --trees 1");
    assert!(said.err.contains("cut into other triangles") && said.err.contains("--trees"), "{}", said.err);
    let (info, stats) = (place.ok("info f.bvhc").out, place.ok("stats f.bvhc").out);
    for figure in ["3 frames", "2 topologies"] {
        assert!(
            said.out.contains(figure) && info.contains(figure) && stats.contains(figure),
            "{figure}: {}{info}{stats}",
            said.out
        );
    }
    // Meshes that move have trees of their own kind, which read no option of trees.
    let options = info.lines().find(|line| line.starts_with("options")).unwrap();
    assert!(
        !options.contains("max-leaf") && info.contains("meshes that move") && info.contains("stand still: auto"),
        "{info}"
    );
    let first = place.ok("build f.%d.obj -o g.bvhc --trees first").out + &place.ok("info g.bvhc").out;
    assert!(first.lines().any(|line| line.starts_with("options") && line.contains("max-leaf")), "{first}");
}

/// A quad that is cut along another diagonal in its last frame, since its second corner has come to lie beyond the first one.
fn bent_quad(frame: u32) -> String {
    let second = ["2 0.5 0", "2 0.4 0", "0.5 0 1.2"][frame as usize - 1];
    format!("v 0 0 0\nv {second}\nv 2 0 2\nv 0 0 2\nf 1 2 3 4\n")
}

#[test]
fn verify_says_where_its_time_goes_and_judges_as_many_rays_as_asked() {
    let place = built();
    let said = place.ok("verify a.bvhc --device cpu --rays 5000 --judge 130 -v");
    let judged = said.out.lines().find(|line| line.starts_with("brute force")).unwrap();
    assert!(
        judged.contains("a sample of 130 rays: ") && judged.ends_with('s') && judged.contains(" unsure; "),
        "{judged}"
    );
    assert!(said.out.contains("on the stack of a traversal"), "{}", said.out);
    let json = place.ok("verify a.bvhc --device cpu --rays 5000 --judge 130 --json").json();
    let file = &json["files"][0];
    assert_eq!((file["oracle"]["rays"].as_u64(), file["stack"].as_u64().is_some_and(|n| n > 0)), (Some(130), true));
}

#[test]
fn a_model_that_rounding_bends_is_told_of_by_check_and_verify_alike() {
    let place = Place::new();
    let (model, bin) = gltf("t");
    let far = model.replace(r#"{"mesh":0}"#, r#"{"mesh":0,"translation":[3e6,0,0],"scale":[0.7,0.7,0.7]}"#);
    place.write("t.gltf", far);
    place.write("t.bin", bin);
    place.ok("build t.gltf -o t.bvhc --levels one");
    assert_eq!(place.run("verify t.bvhc --source t.gltf --device cpu --rays 100").code, 1);
    let check = place.ok("check t.bvhc --source t.gltf");
    assert!(check.err.contains("rounding") && check.err.contains("bvhc verify --source"), "{}", check.err);
    place.ok("build t.gltf -o t.bvhc --levels two");
    assert!(!place.ok("check t.bvhc --source t.gltf").err.contains("rounding"));
}

#[test]
fn what_a_build_took_is_in_meta_where_that_was_asked_for() {
    let place = built();
    place.ok("build a.obj -o noted.bvhc --record-effort");
    place.ok("build a.obj -o noted.bvhc").out.contains("up to date").then_some(()).expect("no other build");
    let told = place.ok("stats noted.bvhc a.bvhc --json").json();
    let effort = &told["files"][0]["effort"];
    assert!(effort["seconds"].as_f64() > Some(0.0) && effort["threads"].as_u64() > Some(0), "{effort}");
    assert!(told["files"][1]["effort"].is_null());
    if cfg!(target_os = "linux") {
        assert!(effort["peak_memory"].as_u64() > Some(1 << 20), "{effort}");
    }
    let text = place.ok("stats noted.bvhc").out;
    assert!(text.contains("build time") && text.contains("build memory") && !text.contains("the build took"), "{text}");
    assert!(place.ok("info noted.bvhc").out.contains("the build took"));
    place.ok("check noted.bvhc --source a.obj");
    // Of several, none tells the memory of all.
    place.write("b.obj", strip(5));
    place.ok("build a.obj b.obj -o out/ --record-effort");
    assert!(place.ok("stats out/b.bvhc --json").json()["files"][0]["effort"]["peak_memory"].is_null());
}
