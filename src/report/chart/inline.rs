//! Panels as SVG within a page: its style gives the colours, so that they suit light, dark and paper, and its script finds the points.

use super::labels::{Places, width};
use super::scale::{Fit, short};
use super::{COLOURS, Marker, Panel, Point, front};
use crate::report::html::escaped;
use std::fmt::Write;

/// Room of a panel at left, top, right and bottom of its plot, in pixels of its own size.
const AROUND: [f64; 4] = [48.0, 26.0, 14.0, 42.0];
const TEXT: f64 = 12.0;
const RADIUS: f64 = 5.0;
/// What a finger meets around a marker.
const TOUCH: f64 = 13.0;

/// The panel as an `svg` element of this size. `name` says of a point what a screen reader reads.
pub fn svg(panel: &Panel, [w, h]: [f64; 2], class: &str, name: &dyn Fn(&Point) -> String) -> String {
    let (left, top, right, bottom) = (AROUND[0], AROUND[1], w - AROUND[2], h - AROUND[3]);
    let across = Fit::new(panel.x.scale, panel.xs());
    let up = Fit::new(panel.y.scale, panel.points().map(|p| p.y));
    let place = |value: f64| left + across.position(value) * (right - left);
    let at = |p: &Point| [place(p.x), bottom - up.position(p.y) * (bottom - top)];
    let mut out = Svg::default();
    let title = escaped(&panel.title);
    out.put(format_args!(
        "<svg class=\"{class}\" viewBox=\"0 0 {w} {h}\" role=\"group\" aria-label=\"{title}, {} against {}\">",
        escaped(&panel.y.label),
        escaped(&panel.x.label)
    ));

    // Round numbers that do not cover each other, with faint lines through the plot.
    let mut after = f64::NEG_INFINITY;
    for tick in across.ticks() {
        let (x, half) = (place(tick), 0.5 * width(&short(tick), TEXT));
        out.line("grid", &[[x, top], [x, bottom]]);
        if x - half > after {
            out.text("tick middle", [x, bottom + 16.0], &short(tick));
            after = x + half + 4.0;
        }
    }
    for tick in up.ticks() {
        let y = bottom - up.position(tick) * (bottom - top);
        out.line("grid", &[[left, y], [right, y]]);
        out.text("tick end", [left - 6.0, y + 4.0], &short(tick));
    }
    out.line("frame", &[[left, top], [right, top], [right, bottom], [left, bottom], [left, top]]);
    out.text("axis", [4.0, 15.0], &panel.y.label);
    out.text("axis middle", [0.5 * (left + right), h - 8.0], &panel.x.label);

    // Lines below markers, markers below names.
    if panel.front {
        out.line("front", &front::of(panel).into_iter().map(at).collect::<Vec<_>>());
    }
    for series in panel.series.iter().filter(|s| s.connected) {
        let points: Vec<[f64; 2]> = panel.drawable(series).iter().map(at).collect();
        out.line(&format!("joined c{}", series.colour % COLOURS), &points);
    }
    let mut places = Places::of(panel, [left, top, right, bottom], &at, RADIUS);
    for series in &panel.series {
        for point in panel.drawable(series) {
            out.point(&point, at(&point), point.spread.map(|ends| ends.map(place)), series.colour % COLOURS, name);
        }
    }
    for series in &panel.series {
        for point in panel.drawable(series).iter().filter(|p| !p.label.is_empty()) {
            let [x, y] = places.find(at(point), &point.label, TEXT);
            out.text(&format!("label c{}", series.colour % COLOURS), [x, y + 4.0], &point.label);
        }
    }
    out.0 + "</svg>"
}

/// A marker alone, for a legend; `None` stands for a colour.
pub fn sign(marker: Marker, colour: Option<usize>) -> String {
    let mut out = Svg::default();
    let class = colour.map_or_else(|| "ink".to_string(), |c| format!("c{}", c % COLOURS));
    out.put(format_args!("<svg class=\"sign {class}\" viewBox=\"0 0 14 14\" aria-hidden=\"true\">"));
    out.marker(marker, [7.0, 7.0]);
    out.0 + "</svg>"
}

#[derive(Default)]
struct Svg(String);

impl Svg {
    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        // A string takes everything.
        let _ = self.0.write_fmt(text);
    }

    fn line(&mut self, class: &str, points: &[[f64; 2]]) {
        if points.len() > 1 {
            let points: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
            self.put(format_args!("<polyline class=\"{class}\" points=\"{}\"/>", points.join(" ")));
        }
    }

    fn text(&mut self, class: &str, [x, y]: [f64; 2], text: &str) {
        self.put(format_args!("<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escaped(text)));
    }

    fn point(
        &mut self,
        point: &Point,
        [x, y]: [f64; 2],
        spread: Option<[f64; 2]>,
        colour: usize,
        name: &dyn Fn(&Point) -> String,
    ) {
        // A marker that says nothing of its own is not worth a stop of the keyboard.
        let (row, stop) = (point.row.map_or_else(String::new, |r| format!(" data-row=\"{r}\"")), point.row.is_some());
        let focus = if stop && point.marker != Marker::None { " tabindex=\"0\" role=\"img\"" } else { "" };
        let label = if focus.is_empty() { String::new() } else { format!(" aria-label=\"{}\"", escaped(&name(point))) };
        self.put(format_args!("<g class=\"point c{colour}\"{row}{focus}{label}>"));
        if let Some([from, to]) = spread {
            self.line("spread", &[[from, y], [to, y]]);
        }
        self.put(format_args!("<circle class=\"touch\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{TOUCH}\"/>"));
        self.marker(point.marker, [x, y]);
        self.put(format_args!("</g>"));
    }

    fn marker(&mut self, marker: Marker, [x, y]: [f64; 2]) {
        let r = RADIUS;
        match marker {
            Marker::None => {}
            Marker::Disc => self.put(format_args!("<circle class=\"mark\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\"/>")),
            Marker::Triangle => self.put(format_args!(
                "<path class=\"mark\" d=\"M{x:.1} {:.1}l{:.1} {:.1}h{:.1}z\"/>",
                y - r - 1.0,
                r + 1.0,
                2.0 * r,
                -2.0 * (r + 1.0)
            )),
            Marker::Square => self.put(format_args!(
                "<rect class=\"mark\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
                x - r + 0.5,
                y - r + 0.5,
                2.0 * r - 1.0,
                2.0 * r - 1.0
            )),
            Marker::Cross => self.put(format_args!(
                "<path class=\"stroke\" d=\"M{:.1} {:.1}l{side} {side}m0 -{side}l-{side} {side}\"/>",
                x - r,
                y - r,
                side = 2.0 * r,
            )),
        }
    }
}
