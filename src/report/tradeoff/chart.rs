//! Build time to the right, ray cost upward: the best place is the lower left corner.

use super::{Origin, Row};
use crate::report::chart::{Axis, Marker, Panel, Point, Series};

/// A panel with a point for each row, the spread of its rounds, and the front.
pub fn panel(title: impl Into<String>, rows: &[Row]) -> Panel {
    let time = Axis::logarithmic("build time, ms").lower_is_better();
    let cost = Axis::close("ray cost: 1.2 × nodes + triangle tests").lower_is_better();
    let milliseconds = |seconds: f64| 1e3 * seconds;
    let mut panel = Panel::new(title, time, cost).with_front();
    for (colour, origin) in Origin::ALL.into_iter().enumerate() {
        let own = rows.iter().enumerate().filter(|(_, row)| row.origin == origin);
        let point = |(number, row): (usize, &Row)| {
            let build = &row.build;
            let point = Point::new(milliseconds(build.median_seconds), row.rays.cost)
                .named(row.name.clone())
                .marked(marker(origin))
                .of_row(number);
            // Of too few builds the middle half says nothing.
            let spread = [build.lower_seconds, build.upper_seconds].map(milliseconds);
            if build.has_spread() { point.spread(spread) } else { point }
        };
        let points: Vec<Point> = own.map(point).collect();
        if !points.is_empty() {
            panel = panel.with(Series::new(words(origin), colour, points));
        }
    }
    panel
}

/// The rows on the front of a panel of theirs.
pub(super) fn mark_front(rows: &mut [Row]) {
    let panel = panel("", rows);
    let best: Vec<usize> = panel.best().into_iter().filter_map(|point| point.row).collect();
    rows.iter_mut().enumerate().for_each(|(number, row)| row.front = best.contains(&number));
}

fn marker(origin: Origin) -> Marker {
    match origin {
        Origin::Preset => Marker::Square,
        Origin::Method => Marker::Disc,
        Origin::Given => Marker::Triangle,
        Origin::Choice => Marker::Cross,
        Origin::Peer => Marker::Disc,
    }
}

fn words(origin: Origin) -> &'static str {
    match origin {
        Origin::Preset => "presets",
        Origin::Method => "methods alone",
        Origin::Given => "recipes that were given",
        Origin::Choice => "what a search chose, without the search",
        Origin::Peer => "builders of others",
    }
}
