//! All scenes in one table, and as a chart: build time across, ray work upwards, one panel a scene.

use std::fmt::Write;

/// The builders of the table; the chart shows all.
const SHOWN: [&str; 5] = ["bvhc draft", "bvhc balanced", "bvhc best", "obvhs fast", "obvhs very_slow"];

pub struct Scene {
    pub name: String,
    pub trees: Vec<Built>,
}

pub struct Built {
    pub name: String,
    pub work: f64,
    pub sah: f64,
    /// Milliseconds on one thread and on two.
    pub times: [f64; 2],
}

/// Markdown: a row a builder, a column a scene.
pub fn table(scenes: &[Scene]) -> String {
    let names: Vec<&str> = scenes.iter().map(|s| s.name.as_str()).collect();
    let mut text = format!("| tree | {} |\n|---|{}\n", names.join(" | "), "--:|".repeat(scenes.len()));
    for shown in SHOWN {
        let cell = |scene: &Scene| {
            scene.trees.iter().find(|t| t.name == shown).map_or("-".to_string(), |t| {
                format!("{:.1} · {:.1} · {:.0} / {:.0}", t.work, t.sah, t.times[0], t.times[1])
            })
        };
        let cells: Vec<String> = scenes.iter().map(cell).collect();
        text.push_str(&format!("| {shown} | {} |\n", cells.join(" | ")));
    }
    text
}

/// The ends of each line in the chart.
const NAMED: [&str; 4] = ["bvhc draft", "bvhc best", "obvhs fastest", "obvhs very_slow"];
const FAMILIES: [(&str, &str); 2] = [("bvhc ", "#d1495b"), ("obvhs ", "#3a7ca5")];
const PANEL: [f64; 2] = [300.0, 220.0];
const MARGIN: [f64; 2] = [46.0, 34.0];
/// Dark enough for white, light enough for black.
const INK: &str = "#777";

/// Two panels a row. Build times stand on a logarithmic scale, because presets span a factor of twenty and more.
pub fn svg(scenes: &[Scene]) -> String {
    let rows = scenes.len().div_ceil(2);
    let (width, height) = (2.0 * (PANEL[0] + MARGIN[0]) + 20.0, rows as f64 * (PANEL[1] + 2.0 * MARGIN[1]) + 24.0);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"11\" fill=\"{INK}\">\n"
    );
    for (n, scene) in scenes.iter().enumerate() {
        let left = MARGIN[0] + (n % 2) as f64 * (PANEL[0] + MARGIN[0]);
        let top = MARGIN[1] + (n / 2) as f64 * (PANEL[1] + 2.0 * MARGIN[1]);
        panel(&mut out, scene, [left, top]);
    }
    let names = FAMILIES
        .map(|(name, colour)| format!("<tspan fill=\"{colour}\" font-weight=\"bold\">{name}</tspan>"))
        .join("and ");
    let legend = "build time in ms on one thread (logarithmic) against work a ray; lower left is better";
    let (middle, bottom) = (width / 2.0, height - 8.0);
    let _ =
        writeln!(out, "<text x=\"{middle}\" y=\"{bottom}\" text-anchor=\"middle\">{names}: {legend}</text>\n</svg>");
    out
}

fn panel(out: &mut String, scene: &Scene, [left, top]: [f64; 2]) {
    let range = |value: &dyn Fn(&Built) -> f64| {
        let values = scene.trees.iter().map(value).filter(|v| v.is_finite());
        values.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)))
    };
    let ((fast, slow), (_, most)) = (range(&|t| t.times[0]), range(&|t| t.work));
    let (fast, slow, most) = (fast * 0.7, slow * 1.9, most * 1.1);
    let x = |ms: f64| left + (ms / fast).ln() / (slow / fast).ln() * PANEL[0];
    let y = |work: f64| top + (1.0 - work / most) * PANEL[1];

    // The frame, and marks at round numbers.
    let [w, h] = PANEL;
    let _ =
        writeln!(out, "<rect x=\"{left}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" fill=\"none\" stroke=\"{INK}\"/>");
    let _ = writeln!(out, "<text x=\"{left}\" y=\"{}\" font-weight=\"bold\">{}</text>", top - 6.0, scene.name);
    for ms in (0..7).flat_map(|e| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(e))).filter(|ms| (fast..slow).contains(ms)) {
        let _ = writeln!(out, "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{ms}</text>", x(ms), top + h + 14.0);
    }
    let step = if most > 50.0 { 20.0 } else { 10.0 };
    for work in (0..10).map(|i| f64::from(i) * step).filter(|work| *work < most) {
        let _ =
            writeln!(out, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{work}</text>", left - 5.0, y(work) + 4.0);
    }

    // A line through each family, and its presets as dots with their names.
    for (family, colour) in FAMILIES {
        let mut trees: Vec<&Built> = scene.trees.iter().filter(|t| t.name.starts_with(family)).collect();
        trees.sort_by(|a, b| a.times[0].total_cmp(&b.times[0]));
        let points: Vec<String> = trees.iter().map(|t| format!("{:.1},{:.1}", x(t.times[0]), y(t.work))).collect();
        let _ = writeln!(out, "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\"/>", points.join(" "));
        for tree in trees {
            let (cx, cy) = (x(tree.times[0]), y(tree.work));
            let _ = writeln!(out, "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"3\" fill=\"{colour}\"/>");
            // One family's names stand below its line, the other's above.
            let at = if family == "bvhc " { cy + 14.0 } else { cy - 7.0 };
            if NAMED.contains(&tree.name.as_str()) {
                let name = tree.name.trim_start_matches(family);
                let _ = writeln!(
                    out,
                    "<text x=\"{cx:.1}\" y=\"{at:.1}\" text-anchor=\"middle\" fill=\"{colour}\">{name}</text>"
                );
            }
        }
    }
}
