//! Charts that show one quantity against another: a point for each method, a panel for each scene, as SVG or in pixels.
//!
//! `scale` turns values into positions and finds round numbers for the axes, `front` finds what nothing else beats, `labels` keeps names from
//! covering one another, `draw` draws, as SVG or by `raster` in pixels; `page` and `inline` make a page of charts with their figures.
//!
//! ```
//! use bvhc::report::chart::{Axis, Chart, Marker, Panel, Point, Series};
//!
//! let cost = Axis::logarithmic("build time, ms").lower_is_better();
//! let work = Axis::linear("work a ray").lower_is_better();
//! let points = vec![Point::new(18.0, 47.3).named("draft"), Point::new(70.0, 34.1).named("best")];
//! let panel = Panel::new("sponza", cost, work).with(Series::new("bvhc", 0, points).connected());
//! let chart = Chart { panels: vec![panel], columns: 1, ..Chart::default() };
//! assert!(chart.svg()?.starts_with("<svg"));
//! # Ok::<(), bvhc::report::chart::ChartError>(())
//! ```

mod draw;
mod front;
mod inline;
mod labels;
pub mod page;
mod raster;
mod scale;

pub use draw::ChartError;
pub use scale::{Axis, Scale, short};

/// Panels in rows, with one legend.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// Above everything; may be empty.
    pub title: String,
    /// Below everything, a line each.
    pub notes: Vec<String>,
    /// From left to right, row by row.
    pub panels: Vec<Panel>,
    /// Panels in a row, at least 1.
    pub columns: usize,
    /// What markers stand for, where they mean something.
    pub markers: Vec<(Marker, String)>,
}

/// One scene.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Above the panel.
    pub title: String,
    /// Increases to the right.
    pub x: Axis,
    /// Increases upward.
    pub y: Axis,
    /// Drawn in this order, later ones on top.
    pub series: Vec<Series>,
    /// Join the points that no other point beats in both quantities.
    pub front: bool,
}

/// Points of one colour.
#[derive(Clone, Debug)]
pub struct Series {
    /// For the legend, in which equal names of several panels stand once.
    pub name: String,
    /// Place in the palette, which has [`COLOURS`] and then starts again.
    pub colour: usize,
    /// In any order; those that an axis cannot show are left out.
    pub points: Vec<Point>,
    /// Join the points in the order of their x.
    pub connected: bool,
}

/// A marker with its label.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// In the unit of the panel's [`Panel::x`].
    pub x: f64,
    /// In the unit of the panel's [`Panel::y`].
    pub y: f64,
    /// Its shape; the series gives the colour.
    pub marker: Marker,
    /// Beside the marker; may be empty.
    pub label: String,
    /// From where to where x is uncertain, drawn as a line through the marker.
    pub spread: Option<[f64; 2]>,
    /// The row of the table under the chart that tells of it, on a [page](page::Page).
    pub row: Option<usize>,
}

/// Shapes that are told apart in print, without colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Marker {
    /// Round and filled.
    #[default]
    Disc,
    /// Pointing upward.
    Triangle,
    /// Upright.
    Square,
    /// Two strokes.
    Cross,
    /// Nothing: the line of its series is enough.
    None,
}

/// Colours told apart by people who see few, and dark enough on white (after Okabe and Ito, "Color Universal Design", 2008).
const PALETTE: [(u8, u8, u8); 7] =
    [(0, 114, 178), (213, 94, 0), (0, 138, 100), (170, 68, 140), (120, 120, 120), (178, 130, 0), (60, 150, 200)];

/// How many colours there are.
pub const COLOURS: usize = PALETTE.len();

impl Panel {
    /// A panel without points.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Panel {
        Panel { title: title.into(), x, y, series: Vec::new(), front: false }
    }

    /// With another series on top of those that it has.
    #[must_use]
    pub fn with(mut self, series: Series) -> Panel {
        self.series.push(series);
        self
    }

    /// See [`Panel::front`].
    #[must_use]
    pub fn with_front(self) -> Panel {
        Panel { front: true, ..self }
    }

    /// The points than which no other is at least as good in both quantities and better in one, ascending in x.
    pub fn best(&self) -> Vec<&Point> {
        front::of(self)
    }

    /// All that stands along x: points and the ends of their spreads.
    fn xs(&self) -> impl Iterator<Item = f64> {
        self.points().flat_map(|p| std::iter::once(p.x).chain(p.spread.into_iter().flatten()))
    }

    /// Those of a series that can be drawn, in the order of their x.
    fn drawable(&self, series: &Series) -> Vec<Point> {
        let takes = |p: &&Point| self.x.scale.takes(p.x) && self.y.scale.takes(p.y);
        let mut points: Vec<Point> = series.points.iter().filter(takes).cloned().collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        points
    }

    /// The ends of a point's spread, where the axis can show them.
    fn ends(&self, point: &Point) -> Option<[Point; 2]> {
        let ends = point.spread.filter(|ends| ends.iter().all(|x| self.x.scale.takes(*x)))?;
        Some(ends.map(|x| Point { x, ..point.clone() }))
    }

    /// Points that can be drawn: finite, and positive where the axis is logarithmic.
    fn points(&self) -> impl Iterator<Item = &Point> {
        self.series.iter().flat_map(|s| &s.points).filter(|p| self.x.scale.takes(p.x) && self.y.scale.takes(p.y))
    }
}

impl Series {
    /// A series whose points are not joined; `colour` wraps around at [`COLOURS`].
    pub fn new(name: impl Into<String>, colour: usize, points: Vec<Point>) -> Series {
        Series { name: name.into(), colour, points, connected: false }
    }

    /// See [`Series::connected`](Series#structfield.connected).
    #[must_use]
    pub fn connected(self) -> Series {
        Series { connected: true, ..self }
    }
}

impl Point {
    /// A disc without a label.
    pub fn new(x: f64, y: f64) -> Point {
        Point { x, y, marker: Marker::Disc, label: String::new(), spread: None, row: None }
    }

    /// With a text beside the marker.
    #[must_use]
    pub fn named(self, label: impl Into<String>) -> Point {
        Point { label: label.into(), ..self }
    }

    /// See [`Point::spread`](Point#structfield.spread).
    #[must_use]
    pub fn spread(self, ends: [f64; 2]) -> Point {
        Point { spread: Some(ends), ..self }
    }

    /// See [`Point::row`](Point#structfield.row).
    #[must_use]
    pub fn of_row(self, row: usize) -> Point {
        Point { row: Some(row), ..self }
    }

    /// With another shape.
    #[must_use]
    pub fn marked(self, marker: Marker) -> Point {
        Point { marker, ..self }
    }
}

#[cfg(test)]
mod tests;
