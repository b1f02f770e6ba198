//! Builders that cannot be run from here, by what was once measured of them.
//!
//! `recorded.csv` holds trees of tinybvh 1.6.7, madmann91/bvh v2, three-mesh-bvh 0.9.17 and others, all built and traced in one run on another
//! machine with two cores (AMD Zen 4) and judged as here, though with other cameras. So only ratios are used: each tree relative to Embree's MEDIUM
//! tree of that run, beside ours relative to the MEDIUM tree of this one.

use crate::measure::{Measured, Row};
use std::fmt::Write;

struct Record {
    scene: &'static str,
    tree: &'static str,
    ray_cost: f64,
    /// On one thread and on two; infinite for a tree put together from two builders, which nobody timed.
    ms: [f64; 2],
}

const REFERENCE: (&str, &str) = ("embree.bvh2-medium", "embree medium");

/// Those that run live where they can be had.
fn is_live(tree: &str) -> bool {
    let embree = tree.starts_with("embree.bvh2-") && !tree.contains('+');
    embree || tree.starts_with("obvhs.") || tree.starts_with("svbvh.")
}

fn records() -> Vec<Record> {
    let number = |text: &str| text.parse().unwrap_or(f64::INFINITY);
    let record = |line: &'static str| {
        let cells: Vec<&str> = line.split(',').collect();
        let [scene, tree, _, _, cost, one, two] = cells[..] else { return None };
        Some(Record { scene, tree, ray_cost: number(cost), ms: [number(one), number(two)] })
    };
    include_str!("recorded.csv").lines().skip(1).filter_map(record).collect()
}

/// For each recorded tree whether a recipe of ours is, relative to Embree's MEDIUM tree, both as quick and as good. Empty without that tree.
pub fn dominance(scenes: &[Measured]) -> String {
    let records = records();
    let mut lines: Vec<(String, [[usize; 2]; 2], String)> = Vec::new();
    for record in records.iter().filter(|r| !is_live(r.tree)) {
        let reference = records.iter().find(|r| r.scene == record.scene && r.tree == REFERENCE.0);
        let scene = scenes.iter().find(|s| s.name == record.scene);
        let (Some(reference), Some(scene)) = (reference, scene) else { continue };
        let Some(medium) = scene.trees.iter().find(|r| r.name() == REFERENCE.1) else { continue };
        let at = lines.iter().position(|l| l.0 == record.tree).unwrap_or_else(|| {
            lines.push((record.tree.to_string(), [[0; 2]; 2], String::new()));
            lines.len() - 1
        });
        let cost = record.ray_cost / reference.ray_cost;
        for thread in 0..2 {
            let time = record.ms[thread] / reference.ms[thread];
            let ours = |r: &&Row| r.is_ours() && r.ms[thread] / medium.ms[thread] <= time;
            let best =
                scene.trees.iter().filter(ours).map(|r| r.ray_cost / medium.ray_cost).fold(f64::INFINITY, f64::min);
            lines[at].1[thread][1] += 1;
            lines[at].1[thread][0] += usize::from(best <= cost);
            if best > cost && (thread == 1 || time.is_finite()) {
                let best = if best.is_finite() { format!("{best:.3}") } else { "none".to_string() };
                let time = if time.is_finite() { format!("{time:.1} ×") } else { "any time".to_string() };
                let label = ["1T", "2T"][thread];
                let text = &mut lines[at].2;
                let between = if text.is_empty() { "" } else { "; " };
                let _ = write!(text, "{between}{} {label}: {cost:.3} in {time}, ours {best}", record.scene);
            }
        }
    }
    if lines.is_empty() {
        return String::new();
    }
    let mut out = "\n### Front: recorded trees, relative to Embree's MEDIUM tree of their own run\n\n".to_string();
    out += "| recorded tree | 1 thread | 2 threads | exceptions: its ray cost and build time, our best ray cost in that time |\n|---|--:|--:|---|\n";
    for (tree, [one, two], exceptions) in lines {
        let _ = writeln!(out, "| {tree} | {} of {} | {} of {} | {exceptions} |", one[0], one[1], two[0], two[1]);
    }
    out
}
