//! The league as a chart, as tables and as a page.

use crate::measure::{FORMS, Measured, OURS, Row};
use bvhc::report::chart::page::{Cell, Section, Table};
use bvhc::report::chart::{Axis, Chart, Marker, Panel, Point, Series};
use bvhc::size::bytes;

pub const LEAD: [&str; 3] = [
    "Trees of several builders over the same triangles, each traced by its builder's own traversal. Builds, loads and rays are of one thread.",
    "Fair rays: what four cameras see, and one diffuse bounce off it. Hard rays: at vertices and edges, within faces, along axes, planes and lattices, and from far \
     away. Lost is a hit that exact arithmetic is certain of where the traversal finds nothing, or only what lies farther away.",
    "Load is what a program pays at every start: for bvhc opening the file with its hashes checked, for the others the build. Ray cost is 1.2 × inner nodes + triangle \
     tests a ray, counted by one traversal in all binary trees.",
];

const PEERS: [&str; 5] = [OURS, "tinybvh", "obvhs", "embree", "bvh"];

/// A panel a scene: load against rays a second.
pub fn chart(scenes: &[Measured]) -> Chart {
    let markers = [(Marker::Disc, FORMS[0].to_string()), (Marker::Square, FORMS[1].to_string())].to_vec();
    Chart { panels: scenes.iter().map(panel).collect(), columns: 2, markers, ..Chart::default() }
}

fn panel(scene: &Measured) -> Panel {
    let load = Axis::logarithmic("load, ms").lower_is_better();
    let mut panel = Panel::new(scene.name.clone(), load, Axis::linear("Mrays/s")).with_front();
    for (colour, peer) in PEERS.into_iter().enumerate() {
        let rows = scene.rows.iter().enumerate().filter(|(_, row)| row.peer == peer);
        let points: Vec<Point> = rows.filter(|(_, row)| row.mrays_per_second.is_finite()).map(point).collect();
        if !points.is_empty() {
            panel = panel.with(Series::new(peer, colour, points));
        }
    }
    panel
}

fn point((number, row): (usize, &Row)) -> Point {
    let marker = if row.form == FORMS[0] { Marker::Disc } else { Marker::Square };
    Point::new(row.load_ms, row.mrays_per_second).named(row.setting.replace('_', " ")).marked(marker).of_row(number)
}

/// The scene's picture with its figures.
pub fn section(scene: &Measured) -> Section {
    let title = format!("{}, {} triangles", scene.name, scene.triangles);
    let chart = Chart { panels: vec![panel(scene)], columns: 1, ..chart(&[]) };
    let mut notes = vec![format!(
        "{} fair rays, of which {} hit, and {} hard ones, of which {} hit. Lost and false are of fair + hard rays.",
        scene.fair_rays, scene.hits[0], scene.hard_rays, scene.hits[1]
    )];
    notes.extend(scene.failed.iter().map(|why| format!("Left out: {why}.")));
    let command = "cargo bench --bench league".to_string();
    Section { title, chart, table: table(scene), notes, command, ..Section::default() }
}

fn table(scene: &Measured) -> Table {
    let columns = [
        ("tree", Cell::Name),
        ("form", Cell::Words),
        ("nodes", Cell::Number),
        ("ray cost", Cell::Number),
        ("build, ms", Cell::Number),
        ("load, ms", Cell::Number),
        ("size", Cell::Number),
        ("Mrays/s", Cell::Number),
        ("lost", Cell::Number),
        ("false", Cell::Number),
    ];
    let columns = columns.map(|(head, cell)| (head.to_string(), cell)).to_vec();
    Table { columns, rows: scene.rows.iter().map(cells).collect() }
}

fn cells(row: &Row) -> Vec<String> {
    let shown = |value: f64, digits: usize| if value.is_nan() { "-".into() } else { format!("{value:.digits$}") };
    let traced = |[fair, hard]: [u64; 2]| {
        if row.mrays_per_second.is_nan() { "-".to_string() } else { format!("{fair} + {hard}") }
    };
    vec![
        row.name(),
        row.form.to_string(),
        shown(row.nodes, 0),
        shown(row.ray_cost, 2),
        shown(row.build_ms, 1),
        shown(row.load_ms, 2),
        if row.bytes.is_nan() { "-".into() } else { bytes(row.bytes as u64).to_string() },
        shown(row.mrays_per_second, 2),
        traced([row.fair.lost(), row.hard.lost()]),
        traced([row.fair.false_hits, row.hard.false_hits]),
    ]
}

/// All scenes as Markdown.
pub fn markdown(scenes: &[Measured]) -> String {
    let one = |scene: &Measured| {
        let Section { title, table, notes, .. } = section(scene);
        format!("## {title}\n\n{}\n{}\n\n", table.markdown(), notes.join("\n\n"))
    };
    scenes.iter().map(one).collect()
}
