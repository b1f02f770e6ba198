//! Drawing, with plotters as the pen: it knows shapes and escapes text, the layout is ours.

use super::labels::{Places, width};
use super::raster::{Fine, Raster};
use super::scale::{Fit, short};
use super::{COLOURS, Chart, Marker, PALETTE, Panel, Point, Series, front};
use crate::report::picture;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The pen refused; never seen, since it writes into memory.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot draw the chart: {0}")]
pub struct ChartError(String);

type Canvas<B> = DrawingArea<B, Shift>;
type Drawn = Result<(), ChartError>;

const PLOT: [f64; 2] = [340.0, 240.0];
/// Room of a panel at left, top, right and bottom of its plot.
const AROUND: [f64; 4] = [62.0, 30.0, 16.0, 46.0];
const EDGE: f64 = 10.0;
const TITLE: f64 = 15.0;
const TEXT: f64 = 12.0;
const SMALL: f64 = 11.0;
const RADIUS: f64 = 4.0;
const INK: RGBColor = RGBColor(50, 50, 50);
const FAINT: RGBColor = RGBColor(222, 222, 222);
const FRONT: RGBColor = RGBColor(150, 150, 150);

/// Where things stand, in units of the chart.
struct Layout {
    columns: usize,
    cell: [f64; 2],
    /// Of the title, with the room below it.
    head: f64,
    legend: Vec<Vec<(Marker, RGBColor, String)>>,
    /// From one line of text to the next.
    line: f64,
    /// Where the legend begins.
    below: f64,
    size: (u32, u32),
}

impl Chart {
    /// The chart as an SVG document.
    ///
    /// # Errors
    /// Never so far: the pen writes into memory.
    pub fn svg(&self) -> Result<String, ChartError> {
        let mut out = String::new();
        let layout = self.layout();
        self.draw(SVGBackend::with_string(&mut out, layout.size), layout)?;
        Ok(out)
    }

    /// The chart in pixels, two for each of its units, for a PNG: the same marks at the same places.
    ///
    /// # Errors
    /// As [`svg`](Chart::svg).
    pub fn canvas(&self) -> Result<picture::Canvas, ChartError> {
        let layout = self.layout();
        let (size, mut fine) = (layout.size, Fine::new(layout.size));
        self.draw(Raster::new(size, &mut fine), layout)?;
        Ok(fine.smooth())
    }

    fn layout(&self) -> Layout {
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let rows = self.panels.len().div_ceil(columns);
        let cell = [PLOT[0] + AROUND[0] + AROUND[2], PLOT[1] + AROUND[1] + AROUND[3]];
        let head = if self.title.is_empty() { 0.0 } else { TITLE + 10.0 };
        let size = columns as f64 * cell[0] + 2.0 * EDGE;
        let legend = self.legend(size - 2.0 * EDGE);
        let line = TEXT + 7.0;
        let below = head + EDGE + rows as f64 * cell[1] + 4.0;
        let high = below + line * (legend.len() + self.notes.len()) as f64 + EDGE;
        Layout { columns, cell, head, legend, line, below, size: (size.ceil() as u32, high.ceil() as u32) }
    }

    fn draw<B: DrawingBackend>(&self, pen: B, layout: Layout) -> Drawn {
        let Layout { columns, cell, head, legend, line, below, size } = layout;
        let (canvas, size) = (pen.into_drawing_area(), f64::from(size.0));
        canvas.fill(&WHITE).map_err(refused)?;
        if !self.title.is_empty() {
            write(&canvas, &self.title, [0.5 * size, EDGE], TITLE, INK, HPos::Center, VPos::Top)?;
        }
        for (i, panel) in self.panels.iter().enumerate() {
            let (column, row) = ((i % columns) as f64, (i / columns) as f64);
            let left = EDGE + column * cell[0] + AROUND[0];
            let top = EDGE + head + row * cell[1] + AROUND[1];
            panel.draw(&canvas, [left, top])?;
        }

        // The legend, and what is said about the whole.
        let mut y = below + 0.5 * line;
        for entries in legend {
            let mut x = EDGE + 4.0;
            for (marker, colour, text) in entries {
                marker.draw(&canvas, [x + RADIUS, y], colour)?;
                write(&canvas, &text, [x + 3.0 * RADIUS, y], TEXT, INK, HPos::Left, VPos::Center)?;
                x += 3.0 * RADIUS + entry_width(&text);
            }
            y += line;
        }
        for note in &self.notes {
            write(&canvas, note, [EDGE + 4.0, y], SMALL, INK, HPos::Left, VPos::Center)?;
            y += line;
        }
        canvas.present().map_err(refused)?;
        Ok(())
    }

    /// Entries in lines of at most this width: colours first, then markers.
    fn legend(&self, most: f64) -> Vec<Vec<(Marker, RGBColor, String)>> {
        let mut entries: Vec<(Marker, RGBColor, String)> = Vec::new();
        for series in self.panels.iter().flat_map(|p| &p.series) {
            let marker = if self.markers.is_empty() { series.marker() } else { Marker::Disc };
            if !series.name.is_empty() && entries.iter().all(|e| e.2 != series.name) {
                entries.push((marker, colour(series.colour), series.name.clone()));
            }
        }
        let mut lines = vec![entries];
        lines.push(self.markers.iter().map(|(marker, name)| (*marker, INK, name.clone())).collect());

        // Break lines that are too long.
        let mut out = Vec::new();
        for line in lines {
            let mut x = 0.0;
            let mut part = Vec::new();
            for entry in line {
                let w = 3.0 * RADIUS + entry_width(&entry.2);
                if x + w > most && !part.is_empty() {
                    out.push(std::mem::take(&mut part));
                    x = 0.0;
                }
                x += w;
                part.push(entry);
            }
            if !part.is_empty() {
                out.push(part);
            }
        }
        out
    }
}

fn entry_width(text: &str) -> f64 {
    width(text, TEXT) + 22.0
}

impl Panel {
    /// The plot's upper left corner stands at `corner`.
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>, [left, top]: [f64; 2]) -> Drawn {
        let [w, h] = PLOT;
        let (right, bottom) = (left + w, top + h);
        let across = Fit::new(self.x.scale, self.xs());
        let up = Fit::new(self.y.scale, self.points().map(|p| p.y));
        let at = |p: &Point| [left + across.position(p.x) * w, bottom - up.position(p.y) * h];

        // Round numbers, with faint lines through the plot, and the frame over them.
        for tick in across.ticks() {
            let x = left + across.position(tick) * w;
            line(canvas, [[x, top], [x, bottom]], FAINT, 1)?;
            write(canvas, &short(tick), [x, bottom + 5.0], SMALL, INK, HPos::Center, VPos::Top)?;
        }
        for tick in up.ticks() {
            let y = bottom - up.position(tick) * h;
            line(canvas, [[left, y], [right, y]], FAINT, 1)?;
            write(canvas, &short(tick), [left - 6.0, y], SMALL, INK, HPos::Right, VPos::Center)?;
        }
        line(canvas, [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]], INK, 1)?;
        write(canvas, &self.title, [left, top - 8.0], TEXT + 1.0, INK, HPos::Left, VPos::Bottom)?;
        write(canvas, &self.x.label, [left + 0.5 * w, bottom + 22.0], TEXT, INK, HPos::Center, VPos::Top)?;
        let upright = style(TEXT, INK, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        let middle = pixel([left - AROUND[0] + 4.0, top + 0.5 * h]);
        canvas.draw(&Text::new(self.y.label.clone(), middle, upright)).map_err(refused)?;

        // Lines below markers, markers below names.
        if self.front {
            let front: Vec<[f64; 2]> = front::of(self).into_iter().map(at).collect();
            line(canvas, front, FRONT, 4)?;
        }
        for series in self.series.iter().filter(|s| s.connected) {
            line(canvas, self.drawable(series).iter().map(at), colour(series.colour), 1)?;
        }
        let mut places = Places::of(self, [left, top, right, bottom], &at, RADIUS);
        for series in &self.series {
            for point in self.drawable(series) {
                if let Some(ends) = self.ends(&point) {
                    line(canvas, ends.map(|end| at(&end)), colour(series.colour), 1)?;
                }
                point.marker.draw(canvas, at(&point), colour(series.colour))?;
            }
        }
        for series in &self.series {
            for point in self.drawable(series).iter().filter(|p| !p.label.is_empty()) {
                let place = places.find(at(point), &point.label, SMALL);
                write(canvas, &point.label, place, SMALL, colour(series.colour), HPos::Left, VPos::Center)?;
            }
        }
        Ok(())
    }
}

impl Series {
    /// What stands for it in a legend.
    pub(super) fn marker(&self) -> Marker {
        self.points.first().map_or(Marker::Disc, |p| if p.marker == Marker::None { Marker::Disc } else { p.marker })
    }
}

impl Marker {
    fn draw<B: DrawingBackend>(self, canvas: &Canvas<B>, at: [f64; 2], colour: RGBColor) -> Drawn {
        let (middle, radius) = (pixel(at), RADIUS as i32);
        let drawn = match self {
            Marker::None => Ok(()),
            Marker::Disc => canvas.draw(&Circle::new(middle, radius, colour.filled())),
            Marker::Triangle => canvas.draw(&TriangleMarker::new(middle, radius + 2, colour.filled())),
            Marker::Cross => canvas.draw(&plotters::element::Cross::new(middle, radius, colour.stroke_width(2))),
            Marker::Square => {
                let corners = [(middle.0 - radius, middle.1 - radius), (middle.0 + radius, middle.1 + radius)];
                canvas.draw(&Rectangle::new(corners, colour.filled()))
            }
        };
        drawn.map_err(refused)
    }
}

fn colour(place: usize) -> RGBColor {
    let (r, g, b) = PALETTE[place % COLOURS];
    RGBColor(r, g, b)
}

fn pixel([x, y]: [f64; 2]) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

fn line<B: DrawingBackend>(
    canvas: &Canvas<B>,
    points: impl IntoIterator<Item = [f64; 2]>,
    colour: RGBColor,
    thick: u32,
) -> Drawn {
    let points: Vec<(i32, i32)> = points.into_iter().map(pixel).collect();
    if points.len() < 2 {
        return Ok(());
    }
    canvas.draw(&PathElement::new(points, colour.stroke_width(thick))).map_err(refused)
}

fn style(size: f64, colour: RGBColor, across: HPos, up: VPos) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&colour).pos(Pos::new(across, up))
}

fn write<B: DrawingBackend>(
    canvas: &Canvas<B>,
    text: &str,
    at: [f64; 2],
    size: f64,
    colour: RGBColor,
    across: HPos,
    up: VPos,
) -> Drawn {
    canvas.draw(&Text::new(text.to_string(), pixel(at), style(size, colour, across, up))).map_err(refused)
}

fn refused<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> ChartError {
    ChartError(error.to_string())
}
