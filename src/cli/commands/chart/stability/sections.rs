//! Pictures and tables of what was judged.

use super::super::sections::table_of;
use super::super::{ChartArgs, stability_command};
use super::Judged;
use crate::cli::figures;
use crate::report::chart::page::{Cell, Section};
use crate::report::chart::{Axis, Chart, Marker, Panel, Point, Series};
use crate::search::LEAST_TRIANGLES;
use crate::stability::{AUTO, AUTO_MARGIN, GROWTH, GROWTH_OF_RAYS, Grown, Kind, POOR, SceneReport, recipes};

/// The tables, the longest apart.
pub struct Sections {
    summary: Section,
    /// A row for each recipe on each scene: for the page alone.
    every: Section,
    rest: Vec<Section>,
}

impl Sections {
    pub fn all(&self) -> Vec<Section> {
        let mut all = vec![self.summary.clone(), self.every.clone()];
        all.extend(self.rest.iter().cloned());
        all
    }

    pub fn printed(&self) -> Vec<Section> {
        std::iter::once(&self.summary).chain(&self.rest).cloned().collect()
    }
}

pub fn lead(judged: &Judged) -> Vec<String> {
    let [small, large] = judged.effort.sizes.map(|size| figures::count(size as u64));
    vec![
        format!(
            "bvhc {} on {} {}. Each scene in two sizes of about {small} and {large} triangles, by {} recipes: every preset, method and pass.",
            env!("CARGO_PKG_VERSION"),
            std::env::consts::OS,
            std::env::consts::ARCH,
            recipes().len(),
        ),
        "Everything but build time is a count, the same on every machine.".into(),
    ]
}

pub fn of(judged: &Judged, args: &ChartArgs) -> Sections {
    let command = stability_command(args);
    let mut rest = vec![badly(judged), motions(judged), refused(judged)];
    rest.retain(|section: &Section| !section.table.rows.is_empty());
    let mut sections = Sections { summary: summary(judged), every: every(judged), rest };
    sections.summary.command.clone_from(&command);
    sections.every.command.clone_from(&command);
    sections.rest.iter_mut().for_each(|section| section.command.clone_from(&command));
    sections
}

/// A row a scene.
fn summary(judged: &Judged) -> Section {
    let columns = [
        ("scene", Cell::Name),
        ("triangles", Cell::Number),
        ("wrong hits", Cell::Number),
        ("depth", Cell::Number),
        ("leaf", Cell::Number),
        ("references", Cell::Number),
        ("time ×", Cell::Number),
        ("memory ×", Cell::Number),
        ("cheapest", Cell::Words),
        ("auto over", Cell::Number),
        ("verdict", Cell::Words),
    ];
    let cells = |scene: &SceneReport| {
        let [small, large] = scene.triangles();
        let growth = |of: &dyn Fn(&Grown) -> f64| {
            let most = scene.most(of);
            if most > 0.0 { format!("{most:.1}") } else { "-".into() }
        };
        let over = scene.auto().map_or(1.0, |auto| auto.over);
        vec![
            format!("{} {}", scene.id, scene.name),
            format!("{small} to {large}"),
            figures::count(scene.recipes.iter().map(|row| row.small.wrong + row.large.wrong).sum::<u64>()),
            format!("{:.0}", scene.most(|row| f64::from(row.large.depth))),
            format!("{:.0}", scene.most(|row| f64::from(row.large.largest_leaf))),
            format!("{:.2}", scene.most(|row| row.large.references)),
            growth(&|row| row.time_growth),
            growth(&|row| row.memory_growth),
            scene.cheapest().map_or_else(String::new, |row| row.large.recipe.to_string()),
            format!("{:+.1} %", 100.0 * (over - 1.0)),
            if scene.broken().is_empty() { "kept".into() } else { "broken".into() },
        ]
    };
    let kept = judged.scenes.iter().filter(|scene| scene.broken().is_empty()).count();
    let worst = judged.scenes.iter().filter_map(|s| Some((s.auto()?.over, s.name))).max_by(|a, b| a.0.total_cmp(&b.0));
    let mut notes = vec![format!(
        "{kept} of {} scenes keep all promises. Of the recipes each column has the most in the larger size: depth and leaf of a tree, references a triangle, and how many times \
         as long a build takes and as many bytes it holds there as in the smaller size, which may be {} and {} times what the triangles are. What asks rays (auto, best, adapt) may take {GROWTH_OF_RAYS} times as long, or \
         as many times as there are triangles; below {LEAST_TRIANGLES} triangles it asks none, and that is not held.",
        judged.scenes.len(),
        GROWTH[0],
        GROWTH[1],
    )];
    if let Some((over, name)) = worst {
        notes.push(format!(
            "auto costs at most {:.1} % more than the cheapest recipe, on {name}; allowed are {:.0} %. More than {POOR} times the cheapest is doing badly.",
            100.0 * (over - 1.0),
            100.0 * (AUTO_MARGIN - 1.0)
        ));
    }
    let title = format!("Stability: {kept} of {} scenes kept", judged.scenes.len());
    let table = table_of(&columns, judged.scenes.iter().map(cells).collect());
    Section { title, table, notes, ..Section::default() }
}

/// A row for each recipe that costs much more than the cheapest.
fn badly(judged: &Judged) -> Section {
    let columns =
        [("scene", Cell::Name), ("recipe", Cell::Words), ("times the cheapest", Cell::Number), ("reason", Cell::Words)];
    let mut rows = Vec::new();
    for scene in &judged.scenes {
        for (row, reason) in scene.recipes.iter().filter_map(|row| Some((row, row.poor?))) {
            let name = format!("{} {}", scene.id, scene.name);
            rows.push(vec![name, row.large.recipe.into(), format!("{:.2}", row.over), reason.into()]);
        }
    }
    Section { title: "What does badly where, and why".into(), table: table_of(&columns, rows), ..Section::default() }
}

/// A row for each recipe on each scene, and a point.
fn every(judged: &Judged) -> Section {
    let columns = [
        ("scene", Cell::Name),
        ("recipe", Cell::Words),
        ("over the cheapest", Cell::Number),
        ("ray cost", Cell::Number),
        ("wrong hits", Cell::Number),
        ("depth", Cell::Number),
        ("leaf", Cell::Number),
        ("references", Cell::Number),
        ("build, ms", Cell::Number),
        ("time ×", Cell::Number),
        ("bytes a triangle", Cell::Number),
        ("memory ×", Cell::Number),
        ("why it does badly", Cell::Words),
    ];
    let kinds: Vec<(&str, Kind)> = recipes().iter().map(|recipe| (recipe.name, recipe.kind)).collect();
    let kind_of = |name: &str| kinds.iter().find(|(of, _)| *of == name).map_or(Kind::Method, |(_, kind)| *kind);
    let (mut rows, mut points): (Vec<Vec<String>>, [Vec<Point>; 4]) = (Vec::new(), Default::default());
    for (number, scene) in judged.scenes.iter().enumerate() {
        for grown in &scene.recipes {
            let row = &grown.large;
            let point = Point::new(number as f64 + 1.0, grown.over).of_row(rows.len());
            match kind_of(row.recipe) {
                _ if row.recipe == AUTO => points[3].push(point.marked(Marker::Cross)),
                Kind::Preset => points[0].push(point.marked(Marker::Square)),
                Kind::Method => points[1].push(point),
                Kind::Pass => points[2].push(point.marked(Marker::Triangle)),
            }
            rows.push(vec![
                format!("{} {}", scene.id, scene.name),
                row.recipe.to_string(),
                format!("{:.2}", grown.over),
                format!("{:.2}", row.cost),
                (grown.small.wrong + row.wrong).to_string(),
                row.depth.to_string(),
                row.largest_leaf.to_string(),
                format!("{:.2}", row.references),
                format!("{:.2}", 1e3 * row.seconds),
                format!("{:.1}", grown.time_growth),
                format!("{:.0}", row.peak_bytes as f64 / row.triangles.max(1) as f64),
                format!("{:.1}", grown.memory_growth),
                grown.poor.unwrap_or_default().to_string(),
            ]);
        }
    }
    let title = "Ray cost over the cheapest recipe, scene by scene";
    let across = Axis::linear("scene, in the order of the table");
    let mut panel = Panel::new(title, across, Axis::logarithmic("ray cost over the cheapest").lower_is_better());
    let names = Kind::ALL.iter().map(|kind| kind.words()).chain([AUTO]);
    for (colour, (name, points)) in names.zip(points).enumerate().filter(|(_, (_, points))| !points.is_empty()) {
        panel = panel.with(Series::new(name, colour, points));
    }
    let chart = Chart { panels: vec![panel], columns: 1, ..Chart::default() };
    Section { title: title.into(), chart, table: table_of(&columns, rows), ..Section::default() }
}

fn motions(judged: &Judged) -> Section {
    let columns = [
        ("motion", Cell::Name),
        ("frames", Cell::Number),
        ("triangles", Cell::Number),
        ("wrong hits", Cell::Number),
        ("trees built", Cell::Number),
        ("rays over new trees, mean", Cell::Number),
        ("worst", Cell::Number),
        ("refitted always, worst", Cell::Number),
        ("verdict", Cell::Words),
    ];
    let mut rows = Vec::new();
    for motion in &judged.motions {
        let find = |refit: &str| motion.rows.iter().find(|row| row.refit == refit);
        let (Some(auto), Some(always)) = (find("auto"), find("always")) else { continue };
        rows.push(vec![
            format!("{} {}", motion.id, motion.name),
            motion.frames.to_string(),
            motion.triangles.to_string(),
            motion.rows.iter().map(|row| row.wrong).sum::<u64>().to_string(),
            auto.built.to_string(),
            format!("{:.2}", auto.mean_over),
            format!("{:.2}", auto.worst_over),
            format!("{:.2}", always.worst_over),
            motion.broken().map_or("kept", |_| "broken").to_string(),
        ]);
    }
    let mut notes = vec![
        "Trees are refitted until that is too dear (--refit auto); beside them what refitting always comes to."
            .to_string(),
    ];
    if let Some(splits) = &judged.splits {
        let [built, fitted, moved @ ..] = &splits.over[..] else { return Section::default() };
        let worst = moved.iter().copied().fold(0.0, f64::max);
        notes.push(format!(
            "F29, refitted spatial splits: {:.2} references a triangle on the turning rotor. Rays cost {built:.2} times what they cost without splits as the tree is built, \
             {fitted:.2} times once both are refitted to where they were, and up to {worst:.2} times in later frames: so trees that are refitted are built without splits.",
            splits.references
        ));
    }
    Section { title: "Motions".into(), table: table_of(&columns, rows), notes, ..Section::default() }
}

fn refused(judged: &Judged) -> Section {
    let columns = [("what", Cell::Name), ("refused by", Cell::Words), ("breaks", Cell::Words)];
    let rows = judged.refused.iter().map(|refusal| {
        vec![
            format!("{} {}", refusal.id, refusal.name),
            refusal.refusal.clone().unwrap_or_else(|| "taken by some: broken".into()),
            refusal.breaks.to_string(),
        ]
    });
    Section { title: "Refused".into(), table: table_of(&columns, rows.collect()), ..Section::default() }
}
