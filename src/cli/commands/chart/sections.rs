//! Pictures and tables of what was measured.

use super::measure::{Arithmetic, Charted, Missing, Model, Sequence};
use super::{ChartArgs, command, preset};
use crate::cli::Context;
use crate::cli::advice;
use crate::cli::figures;
use crate::cli::names;
use crate::cli::table;
use crate::report::accuracy;
use crate::report::chart::page::{Cell, Section, Table};
use crate::report::chart::{Axis, Chart, Panel, Point, Series, short};
use crate::report::frames::FrameReport;
use crate::report::frames::chart as frames;
use crate::report::tradeoff::{Origin, Reason, Row, panel};
use crate::search::NAMED_RECIPE;
use crate::size::bytes;
use crate::verify::accuracy::Row as ArithmeticRow;

/// What is charted, in a line.
pub fn title(args: &ChartArgs) -> String {
    match &args.models[..] {
        [one] => format!("Speed and cost: {}", names::file(one)),
        several => format!("Speed and cost: {} models", several.len()),
    }
}

/// The pictures of one input.
pub fn of(charted: &Charted, args: &ChartArgs, context: &Context) -> Vec<Section> {
    match charted {
        Charted::Sequence(measured) => vec![sequence(measured, args)],
        Charted::Model(model) => {
            let mut sections = vec![recipes(model, args, context)];
            if let Ok(measured) = &model.arithmetic {
                sections.push(arithmetic(model, measured, args));
            }
            sections
        }
    }
}

/// What is missing of an input, in a sentence or two; nothing where all is there.
pub fn left_out(charted: &Charted) -> Option<String> {
    let Charted::Model(model) = charted else { return None };
    let of = |wanted: &dyn Fn(&Reason) -> bool| -> Vec<&str> {
        model.recipes.left_out.iter().filter(|l| wanted(&l.reason)).map(|l| l.name.as_str()).collect()
    };
    let mut sentences = Vec::new();
    let budget = of(&|reason| *reason == Reason::Budget);
    if !budget.is_empty() {
        sentences.push(format!("the budget left no time for {}", budget.join(", ")));
    }
    let interrupted = of(&|reason| *reason == Reason::Interrupted);
    if !interrupted.is_empty() {
        sentences.push(format!("the interruption came before {}", interrupted.join(", ")));
    }
    for left in &model.recipes.left_out {
        if let Reason::Failed(why) = &left.reason {
            sentences.push(format!("{} failed: {why}", left.name));
        }
    }
    match model.arithmetic {
        Err(Missing::Budget) => sentences.push("the budget left no time for other arithmetics".into()),
        Err(Missing::Interrupted) => {
            sentences.push("the interruption came before other arithmetics were judged".into())
        }
        _ => {}
    }
    (!sentences.is_empty()).then(|| format!("{}: {}.", names::path(&model.path), sentences.join("; ")))
}

/// What is said of too few rays, with the input before it.
pub fn few_rays(charted: &Charted, args: &ChartArgs) -> Option<String> {
    let Charted::Model(model) = charted else { return None };
    Some(format!("{}: {}", names::path(&model.path), preset::few_rays(model, args.rays)?))
}

/// Which preset to type.
pub fn advice(charted: &Charted, args: &ChartArgs) -> Option<String> {
    let Charted::Model(model) = charted else { return None };
    Some(preset::advice(model, args.rays)?.line(&model.path, &args.reading))
}

fn recipes(model: &Model, args: &ChartArgs, context: &Context) -> Section {
    let rows = &model.recipes.recipes;
    let triangles = figures::counted(model.instanced_triangles, "triangle", "triangles");
    let title = format!("Build time against ray cost: {}, {triangles}", names::file(&model.path));
    let columns = [
        ("recipe", Cell::Name),
        ("marks", Cell::Words),
        ("build, ms", Cell::Number),
        ("middle half, ms", Cell::Number),
        ("builds", Cell::Number),
        ("ray cost", Cell::Number),
        ("nodes a ray", Cell::Number),
        ("tests a ray", Cell::Number),
        ("references", Cell::Number),
        ("depth", Cell::Number),
        ("SAH", Cell::Number),
        ("flags", Cell::Code),
    ];
    let cells = |row: &Row| {
        let build = &row.build;
        let spread =
            format!("{}–{}", figures::milliseconds(build.lower_seconds), figures::milliseconds(build.upper_seconds));
        vec![
            row.name.clone(),
            marks(row),
            figures::milliseconds(build.median_seconds),
            if build.has_spread() { spread } else { "-".into() },
            build.rounds.to_string(),
            format!("{:.2}", row.rays.cost),
            format!("{:.2}", row.rays.mean(|set| set.visits)),
            format!("{:.2}", row.rays.mean(|set| set.tests)),
            figures::count(row.references),
            row.depth.to_string(),
            format!("{:.2}", row.sah),
            row.flags.clone(),
        ]
    };
    let table = table_of(&columns, rows.iter().map(cells).collect());
    let notes = vec!["To the left is built sooner, below is quicker to trace; the line through a point holds the middle half of its builds.".into()];
    let chart = Chart { notes, panels: vec![panel(title.clone(), rows)], columns: 1, ..Chart::default() };
    let details = ("How the searches chose".to_string(), choices(rows));
    Section { title, chart, table, notes: told(model, args, context), details, command: command(args, &model.path) }
}

/// What the figures alone do not say.
fn told(model: &Model, args: &ChartArgs, context: &Context) -> Vec<String> {
    let (measured, rows) = (&model.recipes, &model.recipes.recipes);
    let mut notes = Vec::new();
    let few: Vec<&str> = rows.iter().filter(|row| !row.build.has_spread()).map(|row| row.name.as_str()).collect();
    if few.len() == rows.len() {
        notes.push(
            "So few builds have no spread: their times tell nothing apart. A larger budget or more rounds would."
                .into(),
        );
    } else if !few.is_empty() {
        notes.push(format!("Too few builds for a spread: {}. Their times are not told from others.", few.join(", ")));
    }
    for group in &measured.indistinct {
        notes.push(format!(
            "Not told apart by build time on this machine, as the middle halves overlap: {}.",
            group.join(", ")
        ));
    }
    let mut same: Vec<Vec<&str>> = Vec::new();
    for row in rows {
        let alike =
            |a: &Row| a.rays == row.rays && (a.nodes, a.references, a.sah) == (row.nodes, row.references, row.sah);
        let names: Vec<&str> = rows.iter().filter(|a| alike(a)).map(|a| a.name.as_str()).collect();
        if names.len() > 1 && !same.contains(&names) {
            same.push(names);
        }
    }
    notes.extend(same.iter().map(|names| format!("The same figures of trees: {}.", names.join(", "))));
    notes.extend(chosen_otherwise(rows));
    let rays: u64 = rows.first().map_or(0, |row| row.rays.sets.iter().map(|set| set.rays).sum());
    let threads = figures::counted(context.exec.threads() as u64, "thread", "threads");
    notes.push(format!(
        "Ray cost over {} rays, the same for all recipes: what bvhc stats --rays {} says of a file built by the flags. Builds on {threads}, without reading and writing.",
        figures::count(rays),
        args.rays
    ));
    if let Some(advice) = preset::advice(model, args.rays) {
        let what = "The quickest preset suits whose rays cost at most 5 % more than by the cheapest recipe here.";
        notes.push(format!("{} {what}", advice.line(&model.path, &args.reading)));
    }
    notes
}

/// Where a search chose another recipe than the one that costs least here: by what each of them judges.
fn chosen_otherwise(rows: &[Row]) -> Option<String> {
    let least = rows.iter().min_by(|a, b| a.rays.cost.total_cmp(&b.rays.cost))?;
    let mut searches: Vec<&str> = rows.iter().flat_map(|row| &row.chosen_by).map(String::as_str).collect();
    searches.retain(|search| {
        let is_of = |row: &&Row| row.name == *search || row.chosen_by.iter().any(|by| by == search);
        !rows.iter().filter(is_of).any(|row| row.rays.cost <= least.rays.cost)
    });
    searches.sort_unstable();
    searches.dedup();
    (!searches.is_empty()).then(|| {
        format!(
            "By these rays {} costs least. {} chose otherwise: a search judges by families of rays, those of a renderer, of light that is stored at surfaces and of \
             queries from anywhere, and this chart by what four cameras around the scene see, one bounce off it and occlusion there.",
            least.name,
            searches.join(" and ")
        )
    })
}

/// What searches wrote down. A recipe that is among the rows is not told once more.
fn choices(rows: &[Row]) -> Vec<String> {
    let is_row = |search: &Row| rows.iter().any(|row| row.chosen_by.contains(&search.name));
    let notes = |row: &Row| {
        let is_new = |note: &&String| !(is_row(row) && note.contains(NAMED_RECIPE));
        row.notes.iter().filter(is_new).map(|note| names::escape(&advice::note(note))).collect::<Vec<_>>()
    };
    rows.iter().filter(|row| row.origin != Origin::Choice).flat_map(notes).collect()
}

fn marks(row: &Row) -> String {
    let mut marks: Vec<String> = Vec::new();
    if row.front {
        marks.push("front".into());
    }
    if !row.chosen_by.is_empty() {
        marks.push(format!("chosen by {}", row.chosen_by.join(" and ")));
    }
    marks.join(", ")
}

fn arithmetic(model: &Model, measured: &Arithmetic, args: &ChartArgs) -> Section {
    let (report, path) = (&measured.report, names::file(&model.path));
    let mut chart = accuracy::chart(&path, report);
    if args.models.len() > 1 {
        // In one file with others a panel says of which model it is.
        chart.panels.iter_mut().for_each(|panel| panel.title = format!("{}, {path}", panel.title));
    }
    let columns = [
        ("triangles, boxes", Cell::Name),
        ("Mrays/s", Cell::Number),
        ("fair rays: wrong in a million", Cell::Number),
        ("hard rays: wrong in a million", Cell::Number),
        ("largest error, ulps", Cell::Number),
        ("nodes a ray", Cell::Number),
        ("tests a ray", Cell::Number),
    ];
    let cells = |row: &ArithmeticRow| {
        vec![
            arithmetic_name(row),
            short(row.mrays_per_second),
            format!("{:.1}", row.fair.per_million()),
            format!("{:.1}", row.hard.per_million()),
            ulps(row.distance.max()),
            format!("{:.1}", row.inner_nodes_per_ray),
            format!("{:.1}", row.triangles_per_ray),
        ]
    };
    let table = table_of(&columns, report.rows.iter().map(cells).collect());
    let notes = vec![format!(
        "{} fair rays, which a renderer traces, and {} hard ones, which are aimed at vertices, edges and surfaces, judged by brute force in exact arithmetic; {} fair rays timed {} on one thread; in the trees of {}.",
        figures::count(report.fair_rays),
        figures::count(report.hard_rays),
        figures::count(report.timed_rays),
        figures::counted(report.rounds.into(), "time", "times"),
        measured.tree
    )];
    let title = format!("Speed against accuracy: {path}");
    Section { title, chart, table, notes, command: command(args, &model.path), ..Section::default() }
}

fn ulps(error: f64) -> String {
    if error >= 1e5 { format!("{error:.1e}") } else { format!("{error:.2}") }
}

/// As tables have it.
pub fn arithmetic_name(row: &ArithmeticRow) -> String {
    format!("{}, {} boxes", row.arithmetic.triangles.name(), row.arithmetic.boxes.name())
}

fn sequence(measured: &Sequence, args: &ChartArgs) -> Section {
    let Sequence { path, report, opened } = measured;
    let columns = [
        ("frame", Cell::Name),
        ("triangles", Cell::Number),
        ("trees", Cell::Number),
        ("built", Cell::Number),
        ("segment", Cell::Number),
        ("SAH", Cell::Number),
        ("ray cost", Cell::Number),
        ("bytes added", Cell::Number),
        ("opens in, µs", Cell::Number),
    ];
    let cells = |(frame, seconds): (&FrameReport, &f64)| {
        vec![
            frame.number.to_string(),
            figures::count(frame.instanced_triangles),
            figures::count(frame.trees),
            figures::count(frame.built),
            frame.segment.to_string(),
            format!("{:.2}", frame.sah),
            frame.ray_cost.map_or_else(|| "-".into(), |cost| format!("{cost:.2}")),
            figures::count(frame.bytes),
            format!("{:.1}", 1e6 * seconds),
        ]
    };
    let table = table_of(&columns, report.frames.iter().zip(opened).map(cells).collect());
    let name = names::file(path);
    let title = format!("Frames: {name}, {}", bytes(report.file_len));
    let mut chart = frames::chart(std::slice::from_ref(report));
    let heads = ["Ray cost", "Bytes added by each frame"];
    chart.panels.iter_mut().zip(heads).for_each(|(panel, head)| panel.title = format!("{head}: {name}"));
    let point = |(row, (frame, seconds)): (usize, (&FrameReport, &f64))| {
        Point::new(frame.bytes as f64, 1e6 * seconds).of_row(row)
    };
    let points = report.frames.iter().zip(opened).enumerate().map(point).collect();
    let added = Axis::logarithmic_or_zero("bytes added by the frame").lower_is_better();
    let opening = Axis::linear("time to open it, µs").lower_is_better();
    let panel = Panel::new(format!("Bytes against time to open: {name}"), added, opening);
    chart.panels.push(panel.with(Series::new("frames", 2, points)));
    let notes = vec!["A segment ends where a frame shows other trees than the one before it. Built: trees that were built for the frame, all others were refitted.".into()];
    Section { title, chart, table, notes, command: command(args, path), ..Section::default() }
}

pub(super) fn table_of(columns: &[(&str, Cell)], rows: Vec<Vec<String>>) -> Table {
    Table { columns: columns.iter().map(|(head, cell)| ((*head).to_string(), *cell)).collect(), rows }
}

/// The table of a picture as text, without what to type, which would make lines too long.
pub fn text(section: &Section) -> String {
    let shown: Vec<usize> =
        (0..section.table.columns.len()).filter(|c| section.table.columns[*c].1 != Cell::Code).collect();
    let mut text = table::Table::default();
    let cells = |row: &[String]| shown.iter().map(|c| row.get(*c).cloned().unwrap_or_default()).collect::<Vec<_>>();
    let heads: Vec<String> = section.table.columns.iter().map(|column| column.0.clone()).collect();
    for row in std::iter::once(&heads).chain(&section.table.rows) {
        let cells = cells(row);
        if let Some((first, rest)) = cells.split_first() {
            text.row(first.clone(), rest.to_vec());
        }
    }
    format!("{}\n\n{}\n", section.title, text.render())
}

/// A picture's figures as Markdown.
pub fn markdown(section: &Section) -> String {
    let notes: String = section.notes.iter().map(|note| format!("{note}\n\n")).collect();
    let command = format!("```sh\n{}\n```\n\n", section.command);
    format!("## {}\n\n{}\n{notes}{command}", section.title, section.table.markdown())
}
