//! The accuracy report as a chart: speed to the right, errors upward, so that the best place is the lower right corner.

use super::chart::{Axis, Chart, Marker, Panel, Point, Series, short};
use crate::trace::arithmetic::{BoxArithmetic, TriangleArithmetic};
use crate::verify::accuracy::{Report, Row};

/// A panel for fair rays, one for hard ones and one for distances. `subject` says what was traced: a file, or how many.
pub fn chart(subject: &str, report: &Report) -> Chart {
    let errors = |title: String, value: &dyn Fn(&Row) -> f64| {
        let label = "wrong answers in a million rays";
        panel(title, Axis::logarithmic_or_zero(label), report, value)
    };
    let count = |n: u64| format!("{} judged", short(n as f64));
    let fair = errors(format!("Fair rays, {}", count(report.fair_rays)), &|r| r.fair.per_million());
    let hard = errors(format!("Hard rays, {}", count(report.hard_rays)), &|r| r.hard.per_million());
    let axis = Axis::logarithmic("largest error of a distance, ulps");
    let distance = panel("Fair rays, distances of right hits".into(), axis, report, &|r| r.distance.max());
    let marked = BoxArithmetic::ALL.iter().map(|b| (marker(*b), format!("{} boxes", b.name())));
    Chart {
        title: format!("Speed against accuracy: {subject}"),
        notes: vec![
            "To the right is faster, below is more accurate; all by the same traversal of the same trees.".into(),
        ],
        panels: vec![fair, hard, distance],
        columns: 3,
        markers: marked.collect(),
    }
}

fn panel(title: String, y: Axis, report: &Report, value: &dyn Fn(&Row) -> f64) -> Panel {
    let x = Axis::logarithmic("Mrays/s on one thread");
    TriangleArithmetic::ALL.iter().enumerate().fold(
        Panel::new(title, x, y.lower_is_better()).with_front(),
        |panel, (colour, triangles)| {
            let own = report.rows.iter().enumerate().filter(|(_, r)| r.arithmetic.triangles == *triangles);
            let point = |(number, r): (usize, &Row)| {
                Point::new(r.mrays_per_second, value(r)).marked(marker(r.arithmetic.boxes)).of_row(number)
            };
            let points = own.map(point);
            panel.with(Series::new(triangles.name(), colour, points.collect()))
        },
    )
}

fn marker(boxes: BoxArithmetic) -> Marker {
    match boxes {
        BoxArithmetic::Plain => Marker::Disc,
        BoxArithmetic::TwoUlps => Marker::Triangle,
        BoxArithmetic::Conservative => Marker::Square,
    }
}
