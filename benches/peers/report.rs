//! What was measured, as Markdown: a table a scene, means over the scenes, and who is beaten by whom.

use crate::measure::{Measured, Row};
use std::fmt::Write;

/// A scene's trees, the cheapest to trace first.
pub fn scene(measured: &Measured) -> String {
    let mut out =
        format!("\n### {} ({} triangles, {} rays a set)\n\n", measured.name, measured.triangles, measured.rays_per_set);
    out += "| tree | refs/tri | depth | SAH | EPO | primary v/t | diffuse v/t | AO v/t | ray cost | Mrays/s p / d / a | build ms 1T / 2T |\n";
    out += "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    let mut rows: Vec<&Row> = measured.trees.iter().collect();
    rows.sort_by(|a, b| a.ray_cost.total_cmp(&b.ray_cost));
    for row in rows {
        let [p, d, a] = row.visits.map(|[v, t]| format!("{v:.1}/{t:.1}"));
        let rates = row.mrays.map(|r| format!("{r:.2}")).join(" / ");
        let error =
            if row.epo_standard_error >= 0.005 { format!(" ±{:.2}", row.epo_standard_error) } else { String::new() };
        let _ = writeln!(
            out,
            "| {} | {:.2} | {} | {:.2} | {:.2}{error} | {p} | {d} | {a} | {:.2} | {rates} | {} / {} |",
            row.name(),
            row.refs_per_triangle,
            row.depth,
            row.sah,
            row.epo,
            row.ray_cost,
            ms(row.ms[0]),
            ms(row.ms[1]),
        );
    }
    out
}

fn ms(value: f64) -> String {
    if value.is_nan() { "–".to_string() } else { format!("{value:.1}") }
}

/// Whose figures are 1, where it was measured.
const REFERENCE: [&str; 3] = ["embree medium", "obvhs medium", "bvhc draft"];

/// Geometric means over the scenes, relative to one tree.
pub fn summary(scenes: &[Measured]) -> String {
    let has = |name: &&&str| scenes.iter().all(|s| find(s, name).is_some());
    let Some(reference) = REFERENCE.iter().find(has) else { return String::new() };
    let mut out = format!("\n### Geometric means over {} scenes, {reference} = 1\n\n", scenes.len());
    out += "| tree | ms/Mtri 1T | 2T | build 1T | 2T | SAH | EPO | ray cost | diffuse work | refs/tri |\n";
    out += "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    let mut lines: Vec<(f64, String)> = Vec::new();
    for name in scenes[0].trees.iter().map(Row::name).filter(|n| scenes.iter().all(|s| find(s, n).is_some())) {
        let mean = |value: &dyn Fn(&Measured, &Row) -> f64| {
            let logs = scenes.iter().map(|s| find(s, &name).map_or(f64::NAN, |row| value(s, row)).ln());
            (logs.sum::<f64>() / scenes.len() as f64).exp()
        };
        let ratio =
            |value: &dyn Fn(&Row) -> f64| mean(&|s, row| value(row) / find(s, reference).map_or(f64::NAN, value));
        let cost = ratio(&|r| r.ray_cost);
        let per_million = |i: usize| mean(&|s, r| r.ms[i] / s.triangles as f64 * 1e6);
        let cell = |v: f64, digits: usize| if v.is_nan() { "–".to_string() } else { format!("{v:.digits$}") };
        let cells = [
            cell(per_million(0), 0),
            cell(per_million(1), 0),
            cell(ratio(&|r| r.ms[0]), 2),
            cell(ratio(&|r| r.ms[1]), 2),
            cell(ratio(&|r| r.sah), 3),
            // A tree without any overlap has no geometric mean; what is below the last digit counts as that.
            cell(ratio(&|r| r.epo.max(0.005)), 3),
            cell(cost, 3),
            cell(ratio(&Row::diffuse_work), 3),
            cell(mean(&|_, r| r.refs_per_triangle), 2),
        ];
        lines.push((cost, format!("| {name} | {} |\n", cells.join(" | "))));
    }
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    lines.into_iter().for_each(|(_, line)| out += &line);
    out
}

fn find<'a>(scene: &'a Measured, name: &str) -> Option<&'a Row> {
    scene.trees.iter().find(|row| row.name() == name)
}

/// For every setting of a peer whether a recipe of ours builds no slower into a tree that is no dearer to trace; all exceptions in full.
pub fn dominance(scenes: &[Measured]) -> String {
    let mut out = "\n### Front: peers' settings for which a recipe of ours has both a lower or equal build time and a lower or equal ray cost\n\n".to_string();
    let mut exceptions = String::new();
    let peers: Vec<String> =
        scenes.first().map_or(vec![], |s| s.trees.iter().filter(|r| !r.is_ours()).map(Row::name).collect());
    if peers.is_empty() {
        return "\nNo peer was there to compare with.\n".to_string();
    }
    out += "| peer | 1 thread | 2 threads |\n|---|--:|--:|\n";
    for peer in peers {
        let mut cells = Vec::new();
        for (thread, label) in ["1T", "2T"].into_iter().enumerate() {
            let (mut beaten, mut all) = (0, 0);
            for scene in scenes {
                let Some(theirs) = find(scene, &peer).filter(|row| !row.ms[thread].is_nan()) else { continue };
                all += 1;
                match exception(scene, theirs, thread) {
                    None => beaten += 1,
                    Some(line) => exceptions += &format!("| {} | {peer} | {label} | {line} |\n", scene.name),
                }
            }
            cells.push(format!("{beaten} of {all}"));
        }
        let _ = writeln!(out, "| {peer} | {} |", cells.join(" | "));
    }
    if !exceptions.is_empty() {
        out += "\nExceptions, with the best that we do in their time and the time that we need for their cost:\n\n";
        out += "| scene | peer | threads | its ms · ray cost | ours in its time | ours at its cost |\n|---|---|---|--:|--:|--:|\n";
        out += &exceptions;
    }
    out
}

fn exception(scene: &Measured, theirs: &Row, thread: usize) -> Option<String> {
    let ours = || scene.trees.iter().filter(|row| row.is_ours());
    if ours().any(|r| r.ms[thread] <= theirs.ms[thread] && r.ray_cost <= theirs.ray_cost) {
        return None;
    }
    let show = |row: Option<&Row>| {
        row.map_or("none".to_string(), |r| format!("{} {:.1} · {:.2}", r.setting, r.ms[thread], r.ray_cost))
    };
    let in_time = ours().filter(|r| r.ms[thread] <= theirs.ms[thread]).min_by(|a, b| a.ray_cost.total_cmp(&b.ray_cost));
    let at_cost = ours().filter(|r| r.ray_cost <= theirs.ray_cost).min_by(|a, b| a.ms[thread].total_cmp(&b.ms[thread]));
    Some(format!("{:.1} · {:.2} | {} | {}", theirs.ms[thread], theirs.ray_cost, show(in_time), show(at_cost)))
}

/// Comma-separated values: a row for each tree of each scene.
pub fn csv(scenes: &[Measured]) -> String {
    let mut out = "scene,triangles,family,setting,ms_1t,ms_2t,refs_per_triangle,depth,sah,epo,epo_standard_error,\
                   primary_v,primary_t,diffuse_v,diffuse_t,occlusion_v,occlusion_t,ray_cost,\
                   primary_mrays,diffuse_mrays,occlusion_mrays\n"
        .to_string();
    for (scene, row) in scenes.iter().flat_map(|s| s.trees.iter().map(move |row| (s, row))) {
        let setting = format!("\"{}\"", row.setting.replace('"', "\"\""));
        let mut cells = vec![scene.name.clone(), scene.triangles.to_string(), row.family.clone(), setting];
        cells.extend(row.ms.iter().map(f64::to_string));
        cells.extend([row.refs_per_triangle.to_string(), row.depth.to_string()]);
        cells.extend([row.sah, row.epo, row.epo_standard_error].map(|v| v.to_string()));
        cells.extend(row.visits.iter().flatten().map(f64::to_string));
        cells.push(row.ray_cost.to_string());
        cells.extend(row.mrays.iter().map(f64::to_string));
        out += &(cells.join(",") + "\n");
    }
    out
}
