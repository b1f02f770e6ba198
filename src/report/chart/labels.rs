//! Places for names: beside their points, and off each other.

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

impl Places {
    /// Markers of `radius` stand at `points`.
    pub fn new(frame: Area, points: impl Iterator<Item = [f64; 2]>, radius: f64) -> Places {
        let taken = points.map(|[x, y]| [x - radius, y - radius, x + radius, y + radius]).collect();
        Places { frame, taken }
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
