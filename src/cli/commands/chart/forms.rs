//! The picture of the forms of one tree.

use super::sections::table_of;
use super::{ChartArgs, command};
use crate::cli::figures;
use crate::cli::names;
use crate::report::chart::page::{Cell, Section};
use crate::report::chart::{Axis, Chart, Panel, Point, Series};
use crate::report::tradeoff::FormRow;
use std::path::Path;

/// Bytes against rays a second, a point a form.
pub fn section(path: &Path, tree: &str, rows: &[FormRow], args: &ChartArgs) -> Section {
    let columns = [
        ("form", Cell::Name),
        ("bits a plane", Cell::Number),
        ("bytes a triangle", Cell::Number),
        ("Mrays/s", Cell::Number),
        ("rays, ms", Cell::Number),
        ("middle half, ms", Cell::Number),
        ("lost hits", Cell::Number),
    ];
    let cells = |row: &FormRow| {
        let spread = [row.trace.lower_seconds, row.trace.upper_seconds].map(figures::milliseconds).join("–");
        vec![
            row.name.to_string(),
            row.bits.to_string(),
            format!("{:.1}", row.bytes_per_triangle),
            format!("{:.2}", row.mrays_per_second),
            figures::milliseconds(row.trace.median_seconds),
            if row.trace.has_spread() { spread } else { "-".into() },
            row.lost.to_string(),
        ]
    };
    let point = |(number, row): (usize, &FormRow)| {
        let name = format!("{}, {} bits", row.name, row.bits);
        Point::new(row.bytes_per_triangle, row.mrays_per_second).named(name).of_row(number)
    };
    let title = format!("Precision and width of nodes: {}", names::file(path));
    let bytes = Axis::linear("bytes of nodes a triangle").lower_is_better();
    let points = rows.iter().enumerate().map(point).collect();
    let panel = Panel::new(title.clone(), bytes, Axis::linear("Mrays/s on one thread")).with_front();
    let panel = panel.with(Series::new("forms of one tree", 0, points));
    let chart = Chart { panels: vec![panel], columns: 1, ..Chart::default() };
    let notes = vec![format!(
        "The trees of {tree}. {} rays, the same for all; lost are those that get another answer than in the binary trees, to the last bit. Bytes are those of nodes, and of \
         the order or the blocks of triangles that the form needs beside the file's triangles.",
        figures::count(rows.first().map_or(0, |row| row.rays)),
    )];
    let table = table_of(&columns, rows.iter().map(cells).collect());
    Section { title, chart, table, notes, command: command(args, path), ..Section::default() }
}
