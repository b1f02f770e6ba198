//! Places for names: beside their points, off each other and off the lines.

use super::{Panel, Point, front};

/// Left, top, right, bottom in pixels.
pub type Area = [f64; 4];

/// How much two areas share, in square pixels.
fn shared(a: &Area, b: &Area) -> f64 {
    let (w, h) = (a[2].min(b[2]) - a[0].max(b[0]), a[3].min(b[3]) - a[1].max(b[1]));
    if w > 0.0 && h > 0.0 { w * h } else { 0.0 }
}

/// The width of a text, roughly: sans-serif letters are a little over half as wide as high.
pub fn width(text: &str, size: f64) -> f64 {
    0.56 * size * text.chars().count() as f64
}

/// What names must not cover, and where they must stay.
pub struct Places {
    frame: Area,
    taken: Vec<Area>,
}

/// From a marker's middle to the middle of the nearest letter, about.
const GAP: f64 = 7.0;
/// How thick a line is for names, which would be struck through: pieces of it are squares of this side.
const STROKE: f64 = 4.0;

impl Places {
    /// Of a panel whose points stand where `at` says, as markers of `radius`: with its front, its joined points and the spreads of points as lines.
    pub fn of(panel: &Panel, frame: Area, at: &dyn Fn(&Point) -> [f64; 2], radius: f64) -> Places {
        let mut places = Places::new(frame, panel.points().map(at), radius);
        if panel.front {
            places.line(&front::of(panel).into_iter().map(at).collect::<Vec<_>>());
        }
        for series in &panel.series {
            let points = panel.drawable(series);
            if series.connected {
                places.line(&points.iter().map(at).collect::<Vec<_>>());
            }
            for point in &points {
                if let Some(ends) = panel.ends(point) {
                    places.line(&ends.map(|end| at(&end)));
                }
            }
        }
        places
    }

    /// Markers of `radius` stand at `points`.
    pub fn new(frame: Area, points: impl Iterator<Item = [f64; 2]>, radius: f64) -> Places {
        let taken = points.map(|[x, y]| [x - radius, y - radius, x + radius, y + radius]).collect();
        Places { frame, taken }
    }

    /// A line stands from each point to the next.
    pub fn line(&mut self, points: &[[f64; 2]]) {
        for pair in points.windows(2) {
            let [[ax, ay], [bx, by]] = [pair[0], pair[1]];
            let pieces = ((bx - ax).hypot(by - ay) / STROKE).ceil().max(1.0) as usize;
            let half = 0.5 * STROKE;
            self.taken.extend((0..=pieces).map(|i| {
                let share = i as f64 / pieces as f64;
                let (x, y) = (ax + share * (bx - ax), ay + share * (by - ay));
                [x - half, y - half, x + half, y + half]
            }));
        }
    }

    /// Where the text begins at its left, vertically centred, so that it covers least; of equally good places the first of right, left, above,
    /// below and the corners.
    pub fn find(&mut self, [x, y]: [f64; 2], text: &str, size: f64) -> [f64; 2] {
        let (w, h) = (width(text, size), size);
        let (side, rise) = (GAP, 0.5 * h + GAP);
        let centred = x - 0.5 * w;
        let choices = [
            [x + side, y],
            [x - side - w, y],
            [centred, y - rise],
            [centred, y + rise],
            [x + side, y - 0.8 * rise],
            [x + side, y + 0.8 * rise],
            [x - side - w, y - 0.8 * rise],
            [x - side - w, y + 0.8 * rise],
            [centred, y - 2.0 * rise],
            [centred, y + 2.0 * rise],
            [x + side, y - 1.6 * rise],
            [x + side, y + 1.6 * rise],
            [x - side - w, y - 1.6 * rise],
            [x - side - w, y + 1.6 * rise],
        ];
        let area = |[left, middle]: [f64; 2]| [left, middle - 0.5 * h, left + w, middle + 0.5 * h];
        let cost = |at: [f64; 2]| {
            let own = area(at);
            let outside = w * h - shared(&own, &self.frame);
            self.taken.iter().map(|t| shared(&own, t)).sum::<f64>() + 10.0 * outside
        };
        let mut best = (f64::INFINITY, choices[0]);
        for choice in choices {
            let cost = cost(choice);
            if cost < best.0 - 1e-9 {
                best = (cost, choice);
            }
        }
        self.taken.push(area(best.1));
        best.1
    }
}
