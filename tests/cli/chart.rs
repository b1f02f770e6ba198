//! `chart`: build time against ray cost, and speed against wrong hits, on one page.

use crate::frames::heli;
use crate::{Place, repository, strip};
use serde_json::Value;

/// A strip of 80 triangles.
fn roof() -> Place {
    let place = Place::new();
    place.write("roof.obj", strip(40));
    place
}

const QUICK: &str = "--rays 64 --accuracy-rays 0 --budget 600s";

fn text(place: &Place, name: &str) -> String {
    String::from_utf8(place.read(name)).unwrap()
}

#[test]
fn the_page_holds_every_recipe_with_its_figures_and_asks_no_network() {
    let place = roof();
    let mut command = place.command();
    command.args(["chart", "roof.obj", "--rounds", "3", "--json", "-o", "page.html", "--svg", "page.svg", "--csv"]);
    command.args(["page.csv", "--accuracy-rays", "200", "--rays", "64", "--budget", "600s"]);
    command.args(["--recipe", "moved=--method sweep --reinsert 2"]);
    let json = crate::said(command.output().unwrap()).json();
    assert_eq!((json["schema"].as_str(), json["interrupted"].as_bool()), (Some("bvhc.chart.v1"), Some(false)));
    let model = &json["models"][0];
    let recipes = model["recipes"].as_array().unwrap();
    let names: Vec<&str> = recipes.iter().map(|row| row["name"].as_str().unwrap()).collect();
    for name in
        ["draft", "balanced", "auto", "best", "binned", "sbvh", "bonsai", "sweep", "agglomerative", "oabb", "moved"]
    {
        assert!(names.contains(&name), "{name} is not among {names:?}");
    }
    assert!(recipes.iter().all(|row| row["build"]["rounds"] == 3), "{json}");
    assert!(recipes.iter().any(|row| row["front"] == true));
    assert_eq!(model["left_out"].as_array().unwrap().len(), 0);

    let (html, svg, csv) = (text(&place, "page.html"), text(&place, "page.svg"), text(&place, "page.csv"));
    for (row, recipe) in recipes.iter().enumerate() {
        let name = recipe["name"].as_str().unwrap();
        // Names may have a quote, which a page escapes.
        let shown = name.replace('\'', "&#39;");
        let cost = format!("{:.2}", recipe["rays"]["cost"].as_f64().unwrap());
        let line = html.lines().find(|line| line.contains(&format!("<th scope=\"row\">{shown}</th>"))).unwrap();
        assert!(line.contains(&format!(">{cost}<")) && line.contains(recipe["flags"].as_str().unwrap()), "{line}");
        // A point on the wide picture and one on the narrow one lead to it.
        assert!(
            html.matches(&format!("data-row=\"{row}\" tabindex=\"0\" role=\"img\" aria-label=\"{shown}, ")).count()
                >= 2
        );
        assert!(svg.contains(name.trim_end_matches("'s choice")), "{name}");
        assert!(csv.contains(&format!("roof.obj,recipes,{name},")), "{csv}");
    }
    assert_eq!(model["arithmetic"]["rows"].as_array().unwrap().len(), 12);
    assert!(html.contains("watertight f32, plain boxes") && csv.contains(",arithmetic,"));
    assert!(
        !html.contains("http://") && !html.contains("https://") && !html.contains("src="),
        "the page asks a network"
    );
    assert!(html.contains("prefers-color-scheme: dark") && html.contains("@media print"));
    assert!(html.contains("bvhc chart roof.obj -o page.html --recipe &#39;moved=--method sweep --reinsert 2&#39;"));
    assert!(svg.starts_with("<!-- bvhc -->\n<svg"));
}

#[test]
fn ray_cost_is_what_stats_says_of_the_file() {
    let place = Place::new();
    std::fs::copy(repository().join("samples/helicopter/heli.0001.obj"), place.path("heli.obj")).unwrap();
    let json = place.ok("chart heli.obj --rays 256 --accuracy-rays 0 --rounds 1 --budget 600s --json").json();
    let recipes = json["models"][0]["recipes"].as_array().unwrap();
    let find = |name: &str| recipes.iter().find(|row| row["name"] == name).unwrap();
    for name in ["agglomerative", "balanced", "auto"] {
        let row = find(name);
        place.ok(&format!("build heli.obj -o heli.bvhc -q {}", row["flags"].as_str().unwrap()));
        let file = place.ok("stats heli.bvhc --rays 256 --epo off --json").json()["files"][0].clone();
        assert_eq!(row["rays"], file["rays"], "{name}");
        for field in ["nodes", "sah"] {
            assert_eq!(row[field], file["blas"][field], "{name}: {field}");
        }
    }
    // What the search chose is a point of its own, with the same figures and flags that build it.
    let (auto, choice) =
        (find("auto"), recipes.iter().find(|row| !row["chosen_by"].as_array().unwrap().is_empty()).unwrap());
    assert_eq!((&auto["rays"], &auto["nodes"]), (&choice["rays"], &choice["nodes"]));
    place.ok(&format!("build heli.obj -o choice.bvhc -q {}", choice["flags"].as_str().unwrap()));
    place.ok("build heli.obj -o heli.bvhc -q");
    let id = |name: &str| place.ok(&format!("info {name} --field content_id")).out;
    assert_eq!(id("choice.bvhc"), id("heli.bvhc"));
}

/// The document without what a clock says, and how many threads there were.
fn without_times(mut value: Value) -> Value {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(fields) => {
                let timed = |name: &str| name.ends_with("seconds") || name.ends_with("per_second");
                fields.retain(|name, _| {
                    !timed(name)
                        && !["threads", "front", "indistinct", "predictions", "advice"].contains(&name.as_str())
                });
                fields.values_mut().for_each(strip);
            }
            Value::Array(values) => values.iter_mut().for_each(strip),
            _ => {}
        }
    }
    strip(&mut value);
    value
}

#[test]
fn all_but_times_is_the_same_for_any_number_of_threads() {
    let place = roof();
    let of = |jobs: &str| {
        let args = "chart roof.obj --rays 64 --accuracy-rays 300 --rounds 1 --budget 600s --json";
        without_times(place.ok(&format!("{args} --jobs {jobs}")).json())
    };
    assert_eq!(of("1"), of("3"));
}

#[test]
fn without_a_budget_the_quickest_recipe_is_there_and_the_others_are_told() {
    let place = roof();
    let said = place.ok("chart roof.obj --budget 0s -o page.html");
    assert!(said.err.contains("the budget left no time for") && said.err.contains("best"), "{}", said.err);
    assert!(text(&place, "page.html").contains("the budget left no time for"));
    let model = place.ok("chart roof.obj --budget 0s --json").json()["models"][0].clone();
    assert_eq!(model["recipes"].as_array().unwrap().len(), 1);
    assert!(model["left_out"].as_array().unwrap().iter().all(|left| left["reason"] == "budget"));
    assert_eq!((&model["arithmetic"], &model["arithmetic_left_out"]), (&Value::Null, &Value::from("budget")));
}

#[test]
fn a_recipe_that_does_not_exist_is_refused_before_anything_is_read() {
    let place = Place::new();
    for recipe in [
        "--method swep",
        "--preset fast",
        "--method sweep --reinsert",
        "x=",
        "draft=--method sweep",
        "--method sweep --bins 4",
    ] {
        let mut command = place.command();
        let said = crate::said(
            command.args(["chart", "missing.obj", "-o", "page.html", "--recipe", recipe]).output().unwrap(),
        );
        assert_eq!(said.code, 2, "{recipe}: {}", said.err);
        assert!(!said.err.contains("missing.obj"), "{recipe}: {}", said.err);
    }
    assert_eq!(place.run("chart missing.obj -o page.html").code, 3);
    assert_eq!(place.names(), [""; 0]);
}

#[test]
fn only_its_own_outputs_are_written_over() {
    let place = roof();
    let foreign = "<!doctype html>\n<p>somebody's only copy</p>\n";
    for flag in ["-o", "--svg", "--csv"] {
        place.write("page", foreign);
        let said = place.run(&format!("chart roof.obj {QUICK} --rounds 1 {flag} page"));
        assert!(said.code == 2 && said.err.contains("bvhc did not make it"), "{flag}: {}", said.err);
        assert_eq!(text(&place, "page"), foreign);
        let own =
            format!("chart roof.obj {QUICK} --budget 0s --rounds 1 {flag} own{flag}").replace(" --budget 600s", "");
        place.ok(&own);
        place.ok(&own);
    }
    for args in ["-o -", "-o page --svg page", "-o nowhere/page.html", "-o roof.obj"] {
        let said = place.run(&format!("chart roof.obj {QUICK} {args}"));
        assert!(said.code == 2 || said.code == 3, "{args}: {}", said.err);
    }
    assert_eq!(text(&place, "roof.obj"), strip(40));
}

#[test]
fn models_and_sequences_stand_on_one_page_and_what_fails_is_told() {
    let place = heli();
    place.write("roof.obj", strip(40));
    place.ok("build in/heli.%04d.obj --missing skip -o heli.bvhc --preset draft -q");
    let said =
        place.run(&format!("chart roof.obj missing.obj heli.bvhc {QUICK} --rounds 1 -o page.html --csv page.csv"));
    assert!(said.code == 10 && said.err.contains("missing.obj"), "{} {}", said.code, said.err);
    let html = text(&place, "page.html");
    assert!(html.contains("Not measured: missing.obj.") && html.contains("Frames: heli.bvhc"), "{html}");
    // Recipes and forms of the model, frames, and what predicts time.
    assert_eq!(html.matches("<section id=").count(), 4);
    assert!(text(&place, "page.csv").contains("heli.bvhc,frames,1,,"));

    // A still file is no model, and it is said what to do with it.
    place.ok("build roof.obj -o roof.bvhc -q");
    let said = place.run("chart roof.bvhc");
    assert!(said.code == 2 && said.err.contains("bvhc stats roof.bvhc --rays"), "{}", said.err);
}

#[test]
fn figures_are_printed_as_text_and_as_markdown() {
    let place = roof();
    let said = place.ok(&format!("chart roof.obj {QUICK} --rounds 1"));
    assert!(said.out.starts_with("Build time against ray cost: roof.obj, 80 triangles\n"), "{}", said.out);
    let said = place.ok(&format!("chart *.obj {QUICK} --rounds 1 --markdown"));
    let row = said.out.lines().find(|line| line.starts_with("| sweep |")).unwrap();
    assert!(row.ends_with("| `--method sweep` |"), "{row}");
    assert!(said.out.contains("```sh\nbvhc chart roof.obj -o chart.html"), "{}", said.out);
    assert_eq!(place.names(), ["roof.obj"]);
}

#[cfg(unix)]
#[test]
fn an_interruption_writes_what_is_measured() {
    use std::process::{Command, Stdio};
    use std::time::Duration;
    let place = Place::new();
    place.write("big.obj", strip(60_000));
    let mut run = place.command();
    run.args([
        "chart",
        "big.obj",
        "-o",
        "page.html",
        "--rounds",
        "1000",
        "--budget",
        "1000s",
        "--rays",
        "64",
        "--json",
    ]);
    let child = run.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Some recipes are built by then, and not all rounds, which take half an hour: a run that did not listen would end by its budget, and with 0.
    std::thread::sleep(Duration::from_secs(4));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let said = crate::said(child.wait_with_output().unwrap());
    assert_eq!(said.code, 130);
    if !place.path("page.html").exists() {
        // The machine was so slow that not one recipe was built.
        assert!(said.out.is_empty() && said.err.contains("interrupted"), "{}{}", said.out, said.err);
        return;
    }
    let html = text(&place, "page.html");
    assert!(html.contains("The run was interrupted") && html.ends_with("</html>\n"), "{html}");
    assert_eq!((said.json()["interrupted"].as_bool(), said.json()["exit_code"].as_u64()), (Some(true), Some(130)));
}

#[test]
fn pixels_show_what_the_picture_shows() {
    let place = roof();
    place.ok(&format!("chart roof.obj {QUICK} --rounds 1 --png all.png --svg all.svg"));
    let reader = png::Decoder::new(std::io::Cursor::new(place.read("all.png"))).read_info().unwrap();
    let (width, height) = (reader.info().width / 2, reader.info().height / 2);
    assert!(text(&place, "all.svg").contains(&format!("<svg width=\"{width}\" height=\"{height}\"")));
    // It is known again, and another kind of file is not made under its name.
    place.ok(&format!("chart roof.obj {QUICK} --rounds 1 --png all.png"));
    assert_eq!(place.run(&format!("chart roof.obj {QUICK} --png all.svg")).code, 2);
}

#[test]
fn forms_lose_no_hit_and_what_predicts_time_is_told() {
    let place = roof();
    let json = place.ok(&format!("chart roof.obj {QUICK} --rounds 3 --json")).json();
    let forms = json["models"][0]["forms"]["rows"].as_array().unwrap();
    assert_eq!(forms.len(), 4);
    assert!(forms.iter().all(|form| form["lost"] == 0 && form["mrays_per_second"].as_f64().unwrap() > 0.0), "{json}");
    let told: Vec<&str> =
        json["predictions"].as_array().unwrap().iter().map(|p| p["predictor"].as_str().unwrap()).collect();
    assert_eq!(told, ["SAH", "EPO", "SAH + EPO", "leaf variability", "ray cost"]);
}

/// A worker that makes one leaf of everything.
const WORKER: &str = "import struct, sys
read, write = sys.stdin.buffer.read, sys.stdout.buffer.write
(count,) = struct.unpack('=I', read(4))
floats = struct.unpack('=%df' % (9 * count), read(36 * count))
low, high = [[pick(floats[axis::3]) for axis in range(3)] for pick in (min, max)]
while read(1):
    write(struct.pack('=dI3fI3fI32xI%dI' % count, 2.5, 2, *low, 0, *high, count, count, *range(count)))
    sys.stdout.flush()
";

#[test]
fn a_builder_of_others_is_a_point_and_one_that_fails_is_told() {
    let place = roof();
    place.write("worker.py", WORKER);
    let python = std::process::Command::new("python3").arg("--version").output();
    if !python.is_ok_and(|output| output.status.success()) {
        return;
    }
    let mut command = place.command();
    command.args([
        "chart",
        "roof.obj",
        "--rays",
        "64",
        "--accuracy-rays",
        "0",
        "--rounds",
        "3",
        "--budget",
        "600s",
        "--json",
    ]);
    command.args(["--peer", "BVH=python3 worker.py", "--peer", "obvhs=./nothing", "-o", "page.html"]);
    let said = crate::said(command.output().unwrap());
    assert_eq!(said.code, 3, "a peer failed: {}", said.err);
    assert!(said.err.contains("obvhs worker failed") && text(&place, "page.html").contains("obvhs worker failed"));
    let json = said.json();
    assert_eq!(json["exit_code"], 3);
    let rows = json["models"][0]["recipes"].as_array().unwrap();
    let peer = rows.iter().find(|row| row["origin"] == "peer").expect("the worker's tree");
    assert_eq!((peer["name"].as_str(), peer["nodes"].as_u64()), (Some("bvh default"), Some(1)));
    assert_eq!((peer["build"]["median_seconds"].as_f64(), peer["build"]["rounds"].as_u64()), (Some(0.0025), Some(3)));
    let cost = |row: &Value| row["rays"]["cost"].as_f64().unwrap();
    assert!(rows.iter().all(|row| cost(row) <= cost(peer)), "one leaf is the worst tree");
    let left = json["models"][0]["left_out"].as_array().unwrap();
    let told = (left.len(), left[0]["reason"].as_str(), left[0]["origin"].as_str());
    assert_eq!(told, (1, Some("failed"), Some("peer")));

    // One that ends after its first answer has failed as well, and its point stays.
    place.write("once.py", WORKER.replace("while read(1)", "if read(1)"));
    let mut command = place.command();
    command.args(["chart", "roof.obj", "--rays", "64", "--accuracy-rays", "0", "--rounds", "3", "--json"]);
    let said = crate::said(command.args(["--budget", "600s", "--peer", "bvh=python3 once.py"]).output().unwrap());
    let model = &said.json()["models"][0];
    assert_eq!((said.code, model["left_out"][0]["name"].as_str()), (3, Some("bvh default")));
    assert!(model["recipes"].as_array().unwrap().iter().any(|row| row["name"] == "bvh default"));
    assert_eq!(place.run("chart roof.obj --peer nobody=worker").code, 2);
}

#[test]
fn scenes_that_builders_fail_on_are_judged() {
    let place = Place::new();
    let said = place.run(
        "chart --stability=F36,gait,nan,F29 --sizes 100,300 --rays 64 --rounds 1 --json -o page.html --csv page.csv",
    );
    let json = said.json();
    assert_eq!(json["schema"], "bvhc.stability.v1");
    // What a clock says of so small builds is not held against them here.
    let broken = json["broken"].as_array().unwrap();
    assert!(broken.iter().all(|what| what.as_str().unwrap().contains("times the time")), "{broken:?}");
    assert_eq!(said.code, i32::from(!broken.is_empty()));
    let scene = &json["scenes"][0];
    assert_eq!((scene["id"].as_str(), scene["recipes"].as_array().unwrap().len()), (Some("F36"), 16));
    for row in scene["recipes"].as_array().unwrap() {
        assert_eq!((row["large"]["wrong"].as_u64(), row["large"]["triangles"].as_u64()), (Some(0), Some(300)));
        assert!(row["large"]["peak_bytes"].as_u64().unwrap() > 0, "the program counts what builds hold");
    }
    assert_eq!(json["motions"][0]["rows"].as_array().unwrap().len(), 3);
    assert!(json["refused"][0]["refusal"].is_string() && json["splits"].is_object());
    assert!(text(&place, "page.html").contains("F36 cloud") && text(&place, "page.csv").contains("cloud,F36,auto,"));

    let unjudged = place.run("chart --stability=F36,gait,F29 --sizes 100,300 --rays 64 --budget 0s --json");
    assert_eq!(unjudged.code, 6, "what was not judged is not kept: {}", unjudged.err);
    assert_eq!(unjudged.json()["left_out"], serde_json::json!(["cloud", "gait", "F29"]));
    let growing = place.ok("chart --stability=F20 --sizes 300,900 --rays 1024 --json").json();
    assert_eq!(growing["exit_code"], 0, "the search begins between these sizes");
    let unknown = place.run("chart --stability=nowhere");
    assert!(unknown.code == 2 && unknown.err.contains("hall"), "{}", unknown.err);
    assert_eq!(place.run("chart roof.obj --stability").code, 2);
    assert_eq!(place.run("chart --stability --sizes 200,100").code, 2);
    let named = place.run("chart --stability=CLOUD,f29,Nan --sizes 100,300 --rays 64 --rounds 1 --json").json();
    assert_eq!((named["scenes"][0]["id"].as_str(), named["refused"].as_array().unwrap().len()), (Some("F36"), 1));
    assert!(named["splits"].is_object());
}

#[test]
fn flags_about_something_else_are_refused() {
    let place = heli();
    place.write("roof.obj", strip(40));
    place.ok("build in/heli.%04d.obj --missing skip -o heli.bvhc --preset draft -q");
    let refused = |args: &str, flag: &str| {
        let said = place.run(&format!("chart {args} -o page.html"));
        assert!(said.code == 2 && said.err.contains(flag) && said.err.contains("help: "), "{args}: {}", said.err);
        assert!(!place.path("page.html").exists(), "{args}");
    };
    refused("roof.obj --sizes 100,300", "--sizes");
    for flag in ["--accuracy-rays 5", "--scene 0", "--clip walk", "--time 1", "--degenerate keep", "--allow-outside"] {
        refused(&format!("--stability {flag}"), flag.split(' ').next().unwrap());
    }
    refused("--stability --ignore-extension X", "--ignore-extension");
    for flag in ["--recipe=--method=sweep", "--peer bvh=x", "--rounds 2", "--accuracy-rays 5", "--scene 0"] {
        refused(&format!("heli.bvhc {flag}"), flag.split([' ', '=']).next().unwrap());
    }
    place.ok("chart heli.bvhc --rays 64 -o page.html");
}

#[test]
fn few_rays_are_told_and_count_nothing_below_zero() {
    let place = roof();
    let said = place.ok("chart roof.obj --rays 1 --accuracy-rays 0 --rounds 1 --budget 600s -o page.html");
    assert!(said.err.contains("12 rays tell no recipes apart") && said.err.contains("--rays 4096"), "{}", said.err);
    assert!(text(&place, "page.html").contains("12 rays tell no recipes apart"));
    assert!(!said.out.contains("-0.00") && !said.out.contains("preset auto suits"), "{}", said.out);
    let many = "chart roof.obj --rays 4096 --accuracy-rays 0 --rounds 1 --budget 600s";
    let said = place.ok(many);
    assert!(!said.err.contains("rays tell no"), "{}", said.err);
    // The last line is what to type.
    let advice = said.out.lines().last().unwrap();
    let typed = advice.split_once("Type: bvhc ").unwrap_or_else(|| panic!("{advice}")).1;
    assert!(advice.starts_with("For roof.obj preset ") && typed.starts_with("build roof.obj -o roof.bvhc --preset "));
    place.ok(typed);
    let model = place.ok(&format!("{many} --json")).json()["models"][0].clone();
    let recipes = model["recipes"].as_array().unwrap();
    let cost = |row: &Value| row["rays"]["cost"].as_f64().unwrap();
    let least = recipes.iter().map(cost).fold(f64::INFINITY, f64::min);
    let advised = recipes.iter().find(|row| row["flags"] == model["advice"]).unwrap();
    assert!(advised["origin"] == "preset" && cost(advised) <= 1.05 * least, "{advised}");
    let nothing = place.ok("chart roof.obj --budget 0s --json").json();
    assert_eq!(nothing["models"][0]["advice"], Value::Null, "one preset is no choice");
}
