//! `info`, `stats`, `check`, `convert` and `explain`.

use crate::{Place, strip};

fn built(options: &str) -> Place {
    let place = Place::new();
    place.write("a.obj", strip(2000));
    place.ok(&format!("build a.obj -o a.bvhc {options}"));
    place
}

#[test]
fn info_agrees_with_the_build_in_text_and_json() {
    let place = built("");
    let built = place.ok("build a.obj -o a.bvhc -f --json").json()["files"][0].clone();
    let info = place.ok("info a.bvhc --json").json();
    assert_eq!(info["schema"], "bvhc.info.v1");
    let file = &info["files"][0];
    assert_eq!(file["path"], "a.bvhc");
    let stats = place.ok("stats a.bvhc --json").json()["files"][0]["blas"].clone();
    for name in ["triangles", "references", "nodes", "trees"] {
        assert!(file[name].is_u64(), "{name}");
        assert_eq!((&file[name], &file[name]), (&built["built"][name], &stats[name]), "{name}");
    }
    assert_eq!(file["file_len"], built["built"]["file_len"]);
    assert_eq!(file["build_key"], built["build_key"]);
    assert_eq!(file["content_id"], built["built"]["content_id"]);
    assert_eq!(file["file_len"].as_u64().unwrap(), place.path("a.bvhc").metadata().unwrap().len());
    let kinds: Vec<&str> = file["sections"].as_array().unwrap().iter().map(|s| s["type"].as_str().unwrap()).collect();
    assert!(kinds.starts_with(&["NODE", "TRIS", "GEOM", "BLAS"]), "{kinds:?}");
    assert_eq!(file["meta"]["inputs"][0]["name"], "a.obj");

    let text = place.ok("info a.bvhc --sections").out;
    assert!(text.contains("4,000 tris") && text.contains("NODE") && text.contains("CRITICAL|CONTENT"), "{text}");
}

#[test]
fn info_prints_single_fields_for_scripts() {
    let place = built("");
    assert_eq!(place.ok("info a.bvhc --field triangles").out, "4000\n");
    assert_eq!(place.ok("info a.bvhc --field content_id").out.len(), 65);
    assert_eq!(place.ok("info a.bvhc --field sections.0.type").out, "NODE\n");
    let said = place.run("info a.bvhc --field nonsense");
    assert_eq!(said.code, 2);
    assert!(said.err.contains("content_id"), "lists the choices: {}", said.err);
}

#[test]
fn what_a_search_tried_is_shown_by_info_and_stats() {
    let place = built("");
    let notes = place.ok("info a.bvhc --json").json()["files"][0]["meta"]["notes"].clone();
    let notes: Vec<&str> = notes.as_array().unwrap().iter().map(|n| n.as_str().unwrap()).collect();
    assert!(notes[0].starts_with("auto: took ") && notes[0].contains(" for 4000 triangles"), "{notes:?}");
    assert!(notes[1].starts_with("auto: tried, by ") && notes[1].contains(" families, worst and mean regret: "));
    let (named, measured) = notes.split_last().unwrap();
    assert!(named.starts_with("auto: without the search: method="), "{notes:?}");
    assert!(measured.iter().any(|note| note.starts_with("auto: a ray pays: outside ")), "{notes:?}");
    assert_eq!(place.ok("stats a.bvhc --json").json()["files"][0]["notes"], serde_json::json!(notes));
    for command in ["info", "stats"] {
        let few = place.ok(&format!("{command} a.bvhc")).out;
        assert!(few.contains("auto: took ") && few.contains("more; -v shows them"), "{few}");
        assert!(!few.contains("auto: tried") && few.contains("auto: without the search: --method "), "{few}");
        let text = place.ok(&format!("{command} a.bvhc -v")).out;
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(measured.iter().all(|note| words.contains(note)), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 110 || !line.contains("auto: tried")), "{text}");
        // The file has names and values; the flags are this program's.
        assert!(text.contains("auto: without the search: --method "), "{text}");
    }

    // The flags that are told give the same tree, and no notes.
    let text = place.ok("info a.bvhc").out;
    let flags = text.lines().find_map(|line| line.split_once("without the search: ")).unwrap().1;
    place.ok(&format!("build a.obj -o b.bvhc {flags}"));
    let content = |file: &str| place.ok(&format!("info {file} --field content_id")).out;
    assert_eq!(content("a.bvhc"), content("b.bvhc"));
    assert_eq!(place.ok("info b.bvhc --field meta.notes").out, "[]\n");
}

#[test]
fn stats_show_several_files_as_columns() {
    let place = built("--method sbvh");
    place.ok("build a.obj -o b.bvhc --method binned");
    let text = place.ok("stats a.bvhc b.bvhc").out;
    let heading: Vec<&str> = text.lines().next().unwrap().split_whitespace().collect();
    assert_eq!(heading, ["a.bvhc", "b.bvhc"]);
    for row in
        ["nodes", "SAH", "EPO", "nodes' share", "duplicated", "sibling overlap", "bytes per triangle", "leaves by size"]
    {
        assert!(text.contains(row), "{row} in {text}");
    }
    assert!(place.ok("stats a.bvhc --depths").out.contains("by depth"));

    let csv = place.ok("stats a.bvhc b.bvhc --csv").out;
    let widths: Vec<usize> = csv.lines().map(|l| l.split(',').count()).collect();
    assert_eq!(widths.len(), 3);
    assert!(widths.iter().all(|w| *w == widths[0]));

    let json = place.ok("stats a.bvhc b.bvhc --json").json();
    let blas = &json["files"][1]["blas"];
    assert_eq!((blas["references"].as_u64(), blas["duplication"].as_f64()), (Some(4000), Some(0.0)));
    let leaves: u64 = blas["leaf_sizes"].as_array().unwrap().iter().map(|p| p[1].as_u64().unwrap()).sum();
    assert_eq!(blas["leaves"].as_u64(), Some(leaves));
    let (nodes, inner) =
        (blas["sah"].as_f64().unwrap(), blas["sah_nodes"].as_f64().unwrap() + blas["sah_leaves"].as_f64().unwrap());
    assert!((nodes - inner).abs() < 1e-9);
}

#[test]
fn stats_measure_the_end_point_overlap() {
    // Slivers that cross each other.
    let place = Place::new();
    let mut obj = String::new();
    for i in 0..300 {
        let t = f64::from(i) / 300.0;
        let (a, b) = if i % 2 == 0 { ([t, 0.0], [1.0 - t, 1.0]) } else { ([0.0, t], [1.0, 1.0 - t]) };
        for [x, y] in [a, b, [a[0] + 0.01, a[1] + 0.01]] {
            obj += &format!("v {x} {y} {t}\n");
        }
        obj += "f -3 -2 -1\n";
    }
    place.write("a.obj", obj);
    place.ok("build a.obj -o a.bvhc --method binned");
    let epo = |how: &str| place.ok(&format!("stats a.bvhc --json {how}")).json()["files"][0]["epo"].clone();
    let (exact, sampled) = (epo("--epo exact"), epo("--epo sampled"));
    let (value, about) = (exact["value"].as_f64().unwrap(), sampled["value"].as_f64().unwrap());
    let error = sampled["standard_error"].as_f64().unwrap();
    assert!(value > 0.0 && (about - value).abs() <= 4.0 * error, "{exact} {sampled}");
    assert_eq!((exact["standard_error"].as_f64(), exact["points"].as_u64()), (Some(0.0), Some(0)));
    assert_eq!(sampled["points"], 1 << 18);
    assert_eq!(epo(""), exact, "a small file needs no sampling");
    for how in ["exact", "sampled"] {
        let jobs = |n| epo(&format!("--epo {how} --jobs {n}"));
        assert_eq!(jobs(1), jobs(3), "the same for any number of threads");
    }
    assert!(epo("--epo off").is_null());

    let shown = |how: &str| {
        let text = place.ok(&format!("stats a.bvhc {how}")).out;
        text.lines().find(|l| l.starts_with("EPO")).unwrap().split_whitespace().nth(1).unwrap().to_string()
    };
    assert_eq!(shown("--epo exact"), format!("{value:.2}"));
    assert_eq!(shown("--epo off"), "-");
    let csv = place.ok("stats a.bvhc --epo exact --csv").out;
    let cells: Vec<Vec<&str>> = csv.lines().map(|l| l.split(',').collect()).collect();
    let column = cells[0].iter().position(|name| *name == "epo").unwrap();
    assert_eq!(cells[1][column].parse::<f64>().unwrap(), value);
}

#[test]
fn a_damaged_file_is_a_negative_verdict_and_names_the_finding() {
    let place = built("");
    let mut bytes = place.read("a.bvhc");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    place.write("bad.bvhc", &bytes);
    let said = place.run("check bad.bvhc");
    assert_eq!(said.code, 1);
    assert!(said.out.starts_with("bad.bvhc: invalid (1 error)\nE0201 "), "{}", said.out);
    assert!(said.out.contains("more: bvhc explain E0201"), "{}", said.out);
    assert_eq!(place.run("check bad.bvhc --level quick").code, 0, "quick reads no sections");
    assert_eq!(place.run("stats bad.bvhc").code, 1);
    assert_eq!(place.run("check a.bvhc bad.bvhc").code, 1);

    let json = place.run("check a.bvhc bad.bvhc --json").json();
    assert_eq!((json["files"][0]["valid"].as_bool(), json["files"][1]["valid"].as_bool()), (Some(true), Some(false)));
    assert_eq!(json["files"][1]["findings"][0]["id"], "E0201");
}

#[test]
fn check_tells_missing_foreign_newer_and_valid_apart() {
    let place = built("");
    assert!(place.ok("check a.bvhc").out.starts_with("a.bvhc: valid"));
    assert_eq!(place.ok("check a.bvhc -q").out, "");
    for level in ["quick", "hash", "tree"] {
        place.ok(&format!("check a.bvhc --level {level}"));
    }
    assert_eq!(place.run("check missing.bvhc").code, 3);
    place.write("text.bvhc", "this is no cache file");
    assert_eq!(place.run("check text.bvhc").code, 1);
    place.write("empty.bvhc", "");
    assert_eq!(place.run("check empty.bvhc").code, 1);
    let mut newer = place.read("a.bvhc");
    newer[8] = 2;
    place.write("newer.bvhc", &newer);
    assert_eq!(place.run("check newer.bvhc").code, 5);
    assert_eq!(place.run("info newer.bvhc").code, 5);
    assert_eq!(place.run("check newer.bvhc missing.bvhc a.bvhc").code, 10, "different ends");
}

#[test]
fn check_against_the_source() {
    let place = built("");
    place.ok("check a.bvhc --level source --source a.obj");
    place.ok("check a.bvhc --source a.obj");
    assert_eq!(place.run("check a.bvhc --level source").code, 2, "which source?");
    place.write("b.obj", strip(2001));
    assert_eq!(place.run("check a.bvhc --source b.obj").code, 1);
    assert_eq!(place.run("check a.bvhc --source missing.obj").code, 3);
}

#[test]
fn convert_keeps_the_content() {
    let place = built("");
    let id = place.ok("info a.bvhc --field content_id").out;
    let said = place.ok("convert a.bvhc -o z.bvhc --codec zstd:9");
    assert!(said.out.contains(&id[..8]) && said.out.contains(" unchanged"), "{}", said.out);
    assert!(place.read("z.bvhc").len() < place.read("a.bvhc").len());
    place.ok("check z.bvhc");
    place.ok("convert z.bvhc -o r.bvhc");
    assert!(place.read("r.bvhc") == place.read("a.bvhc"), "there and back");
    assert_eq!(place.ok("convert a.bvhc -o y.bvhc --codec zstd --json").json()["files"][0]["content_id"], id.trim());
    assert_eq!(place.run("convert a.bvhc -o a.bvhc --codec zstd").code, 2);
    assert_eq!(place.run("convert a.bvhc -o b.bvhc --codec zip").code, 2);
    assert_eq!(place.run("convert missing.bvhc -o b.bvhc").code, 3);
    assert_eq!(place.run("convert a.bvhc -o no/such/b.bvhc").code, 3);
}

#[test]
fn reading_works_without_mapping_and_within_limits() {
    let place = built("--codec zstd");
    assert_eq!(place.ok("stats a.bvhc --no-mmap").out, place.ok("stats a.bvhc").out);
    assert_eq!(place.run("stats a.bvhc --max-memory 1K").code, 6);
    let said = place.run("check a.bvhc --max-memory 1K");
    assert!(said.code == 6 && said.out.starts_with("a.bvhc: not judged "), "{}", said.out);
    assert_eq!(place.run("build a.obj -o b.bvhc --max-memory 1K").code, 6);
}

#[test]
fn every_rule_can_be_explained() {
    let place = Place::new();
    let list = place.ok("explain --list").out;
    assert!(list.lines().count() > 30);
    let ids: Vec<&str> = list.lines().map(|l| l.split_whitespace().next().unwrap()).collect();
    let text = place.ok(&format!("explain {}", ids.join(" "))).out;
    assert!(ids.iter().all(|id| text.contains(&format!("{id} "))));
    assert_eq!(place.ok("explain e0402").out, place.ok("explain node-child-order").out);
    let said = place.run("explain E9999");
    assert!(said.code == 2 && !said.err.contains("did you mean"), "numbers are all alike: {}", said.err);
    let said = place.run("explain Node-child-ordre");
    assert!(said.code == 2 && said.err.contains("did you mean node-child-order?"), "{}", said.err);
    assert_eq!(place.ok("explain E0402 --json").json()["rules"][0]["name"], "node-child-order");
}

#[test]
fn stats_counts_what_rays_do_in_each_set() {
    let place = built("");
    let plain = place.ok("stats a.bvhc --json").json()["files"][0].clone();
    assert!(plain["rays"].is_null() && plain["blas"]["mean_empty_share"].as_f64().unwrap() < 1.0);
    let rays = place.ok("stats a.bvhc --rays 400 --json").json()["files"][0]["rays"].clone();
    let sets = rays["sets"].as_array().unwrap();
    let names: Vec<&str> = sets.iter().map(|set| set["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["primary", "diffuse", "occlusion"]);
    let of = |set: &serde_json::Value, field: &str| set[field].as_f64().unwrap();
    let costs = sets.iter().map(|set| 1.2 * of(set, "visits") + of(set, "tests"));
    assert!((costs.sum::<f64>() / 3.0 - of(&rays, "cost")).abs() < 1e-9);
    assert!(sets.iter().all(|set| of(set, "leaves") <= of(set, "tests") && set["rays"] == 400));
    let text = place.ok("stats a.bvhc --rays 400").out;
    assert!(text.contains("leaf variability") && text.contains("occlusion rays"), "{text}");
    assert!(place.ok("stats a.bvhc --rays 400 --csv").out.contains("leaf_variability"));
}

#[test]
fn stats_tells_what_each_family_of_rays_pays() {
    let place = built("");
    let families = |args: &str| place.ok(&format!("stats a.bvhc --json {args}")).json()["files"][0]["families"].clone();
    assert_eq!(families(""), serde_json::json!([]));
    let told = families("--rays 400");
    let told = told.as_array().unwrap();
    let of = |family: &serde_json::Value, field: &str| family[field].as_f64().unwrap();
    assert!(told.len() >= 6, "{told:?}");
    for family in told {
        let error = of(family, "deviation") / of(family, "rays").sqrt();
        assert!((error - of(family, "standard_error")).abs() < 1e-9 && of(family, "cost") > 0.0, "{family}");
    }
    let text = place.ok("stats a.bvhc --rays 400").out;
    let csv = place.ok("stats a.bvhc --rays 400 --csv").out;
    for family in told {
        let (name, cost) = (family["name"].as_str().unwrap(), of(family, "cost"));
        let shown = text.lines().find(|line| line.starts_with(&format!("  {name} "))).unwrap_or_default();
        assert!(shown.contains(&format!("{cost:.2} ±")), "{name}: {text}");
        assert!(csv.contains(&format!("{name}_cost")) && csv.contains(&cost.to_string()), "{csv}");
    }
}

#[test]
fn stats_shows_many_files_below_each_other() {
    let place = built("");
    let name = |i: usize| format!("many/b{i}.bvhc");
    place.ok("build a.obj -o many/");
    for i in 0..5 {
        std::fs::copy(place.path("a.bvhc"), place.path(&name(i))).unwrap();
    }
    let said = place.ok("stats many");
    let lines: Vec<&str> = said.out.lines().collect();
    assert!(lines.len() == 7 && lines[0].contains("triangles") && lines[0].contains("SAH"), "{}", said.out);
    assert!(!said.out.contains("ray cost") && said.err.contains("--csv"), "nobody asked for rays: {}", said.out);
    let nodes = place.ok("stats a.bvhc").out;
    let nodes = nodes.lines().find(|line| line.starts_with("nodes")).unwrap().split_whitespace().last().unwrap();
    assert!(lines[1..].iter().all(|line| line.split_whitespace().any(|word| word == nodes)), "{}", said.out);
    assert!(place.ok("stats many --rays 100").out.contains("ray cost"));
}

#[test]
fn stats_compares_two_files_and_judges_for_ci() {
    let place = built("--preset draft");
    place.ok("build a.obj -o b.bvhc --preset draft -O max-leaf=1");
    let same = place.ok("stats --compare a.bvhc a.bvhc --rays 100");
    assert!(same.out.lines().skip(1).all(|line| line.ends_with('=')), "{}", same.out);
    let said = place.run("stats --compare a.bvhc b.bvhc --rays 100 --json --fail-if nodes>+10% --fail-if depth>64");
    let document = said.json();
    assert_eq!((said.code, document["exit_code"].as_u64()), (8, Some(8)), "{}", said.err);
    let holds: Vec<bool> =
        document["verdicts"].as_array().unwrap().iter().map(|v| v["holds"].as_bool().unwrap()).collect();
    assert_eq!(holds, [true, false]);
    let changes = document["changes"].as_array().unwrap();
    let nodes = changes.iter().find(|c| c["metric"] == "nodes").unwrap();
    let stats = |file: &str| place.ok(&format!("stats {file} --json")).json()["files"][0]["blas"]["nodes"].clone();
    assert_eq!(
        (&nodes["before"], &nodes["after"]),
        (&serde_json::json!(f(&stats("a.bvhc"))), &serde_json::json!(f(&stats("b.bvhc"))))
    );
    assert_eq!(place.run("stats --compare a.bvhc b.bvhc --fail-if ray-cost>+1000%").code, 0);

    assert_eq!(place.run("stats --compare a.bvhc b.bvhc --fail-if Ray-Cost>+1000%").code, 0);

    // Figures of other models are no change, and no comparison is made without one of the files.
    place.write("c.obj", strip(7));
    place.ok("build c.obj");
    let other = place.ok("stats --compare a.bvhc c.bvhc");
    place.ok("build a.obj -o two.bvhc --levels two");
    assert!(!place.ok("stats --compare a.bvhc two.bvhc").err.contains("warning"), "one model in two forms");
    assert!(other.err.contains("and 14 triangles") && !same.err.contains("warning"), "{}", other.err);
    assert_eq!(place.run("stats --compare a.bvhc gone.bvhc").code, 3);

    // A share without a sign may be meant of the value or of the change.
    let unsigned = place.run("stats --compare a.bvhc b.bvhc --fail-if ray-cost>110%");
    assert!(unsigned.code == 2 && unsigned.err.contains("+10%"), "{}", unsigned.err);
    let told = place.run("stats --compare a.bvhc b.bvhc --rays 0 --fail-if nodes>+10% --fail-if depth>64");
    assert!(told.out.contains("nodes>+10%: FAILED (it changed by +") && told.out.contains("depth>64: passed (it is "));

    let unknown = place.run("stats --compare a.bvhc b.bvhc --fail-if speed>1");
    assert!(unknown.code == 2 && unknown.err.contains("ray-cost") && unknown.err.contains("leaf-variability"));
    for args in
        ["a.bvhc", "a.bvhc b.bvhc a.bvhc", "a.bvhc b.bvhc --fail-if sah", "a.bvhc b.bvhc --rays 0 --fail-if visits>1"]
    {
        assert_eq!(place.run(&format!("stats --compare {args}")).code, 2, "{args}");
    }
    assert_eq!(place.run("stats a.bvhc --fail-if sah>1").code, 2);
}

/// As the comparison has all its figures.
fn f(count: &serde_json::Value) -> f64 {
    count.as_u64().unwrap() as f64
}
