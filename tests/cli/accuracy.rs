//! `verify --accuracy`: the table, the JSON document and the chart.

use crate::{Place, repository};

fn pillar() -> Place {
    let place = Place::new();
    std::fs::copy(repository().join("samples/pillar.obj"), place.path("pillar.obj")).unwrap();
    place.ok("build pillar.obj -o pillar.bvhc -q");
    place
}

#[test]
fn the_table_and_the_document_say_that_ours_is_never_wrong() {
    let place = pillar();
    let text = place.ok("verify pillar.bvhc --accuracy --rays 3k --source pillar.obj").out;
    assert!(text.starts_with("pillar.bvhc: ") && text.contains("rays judged"), "{text}");
    let rows: Vec<&str> = text.lines().filter(|l| l.contains("conservative")).collect();
    assert_eq!(rows.len(), 4, "{text}");
    let ours: Vec<&str> =
        rows[3].strip_prefix("f64 (bvhc), conservative").expect("ours last").split_whitespace().collect();
    assert_eq!(ours[..6], ["0"; 6], "missed, farther, false of fair and of hard rays: {text}");
    assert!(ours[7].parse::<f64>().unwrap() <= 0.5, "half a unit is what rounding costs: {text}");

    let json = place.ok("verify pillar.bvhc pillar.bvhc --accuracy --rays 3k --json").json();
    assert_eq!(json["schema"], "bvhc.accuracy.v1");
    let (files, all) = (json["files"].as_array().unwrap(), &json["all"]);
    assert_eq!((files.len(), files[0]["rows"].as_array().unwrap().len()), (2, 12), "{json}");
    let row = &all["rows"][11];
    assert_eq!((row["triangles"].as_str(), row["boxes"].as_str()), (Some("double"), Some("conservative")), "{row}");
    assert_eq!(row["hard"]["missed"], 0);
    let twice = |key: &str| all[key].as_u64().unwrap() == 2 * files[0][key].as_u64().unwrap();
    assert!(twice("fair_rays") && twice("hard_rays") && twice("instanced_triangles"), "{json}");
    for row in all["rows"].as_array().unwrap() {
        assert!(row["mrays_per_second"].as_f64().unwrap() > 0.0, "{row}");
        assert!(row["distance"]["max_ulps"].as_f64().unwrap() >= row["distance"]["median_ulps"].as_f64().unwrap());
    }
}

#[test]
fn the_chart_goes_where_svg_says() {
    let place = pillar();
    place.ok("verify pillar.bvhc --accuracy --rays 1k --svg chart.svg");
    let svg = String::from_utf8(place.read("chart.svg")).unwrap();
    assert!(
        svg.starts_with("<!-- bvhc -->\n<svg") && svg.contains("pillar.bvhc") && svg.contains("watertight f32"),
        "{svg}"
    );
    let said = place.run("verify pillar.bvhc --accuracy --rays 1k --svg nowhere/chart.svg");
    assert!(said.code == 3 && said.err.contains("nowhere/chart.svg"), "{} {}", said.code, said.err);
}

#[test]
fn the_report_is_not_mixed_with_verdicts() {
    let place = pillar();
    for args in ["--svg chart.svg", "--accuracy --any-hit", "--accuracy --device cpu", "--accuracy --junit x.xml"] {
        assert_eq!(place.run(&format!("verify pillar.bvhc {args}")).code, 2, "{args}");
    }
    let said = place.run("verify pillar.obj --accuracy");
    assert!(said.code != 0 && said.err.contains("pillar.obj"), "{}", said.err);
}
