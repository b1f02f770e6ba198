//! [`Shade`]: what the colours of a picture show.

use super::canvas::{Canvas, Rgb};
use super::scale::{BACKGROUND, Scale};
use super::shot::{Pixel, Seen, Shot};
use crate::tree::quality::{REPORT_INTERSECTION_COST, REPORT_TRAVERSAL_COST};

/// What a picture shows of each pixel's ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shade {
    /// The surface as a lamp above the eye lights it.
    Lit,
    /// The direction of the surface: red, green and blue for x, y and z.
    Normal,
    /// A colour for each part of the source.
    Part,
    /// A colour for each instance.
    Instance,
    /// How deep in the tree the leaf lies that was hit.
    Depth,
    /// Inner nodes that the ray entered.
    Visits,
    /// Triangles that it was tested with.
    Tests,
    /// Both, as the SAH counts them: 1.2 · visits + tests.
    Cost,
}

impl Shade {
    /// In the order in which help lists them.
    pub const ALL: [Shade; 8] = [
        Shade::Lit,
        Shade::Normal,
        Shade::Part,
        Shade::Instance,
        Shade::Depth,
        Shade::Visits,
        Shade::Tests,
        Shade::Cost,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Shade::Lit => "lit",
            Shade::Normal => "normal",
            Shade::Part => "part",
            Shade::Instance => "instance",
            Shade::Depth => "depth",
            Shade::Visits => "visits",
            Shade::Tests => "tests",
            Shade::Cost => "cost",
        }
    }

    /// What is counted, in words, where the colours stand for numbers.
    pub const fn counted(self) -> Option<&'static str> {
        match self {
            Shade::Lit | Shade::Normal | Shade::Part | Shade::Instance => None,
            Shade::Depth => Some("depth of the leaf that was hit"),
            Shade::Visits => Some("inner nodes visited by the ray"),
            Shade::Tests => Some("triangles tested by the ray"),
            Shade::Cost => Some("cost of the ray: 1.2 x nodes + triangles"),
        }
    }

    /// The number that a colour stands for; nothing where this shows none, or the ray hit nothing that has one.
    pub fn value(self, pixel: &Pixel) -> Option<f64> {
        let (visits, tests) = (f64::from(pixel.visits), f64::from(pixel.tests));
        match self {
            Shade::Lit | Shade::Normal | Shade::Part | Shade::Instance => None,
            Shade::Depth => pixel.seen.map(|seen| f64::from(seen.leaf_depth)),
            Shade::Visits => Some(visits),
            Shade::Tests => Some(tests),
            Shade::Cost => Some(REPORT_TRAVERSAL_COST * visits + REPORT_INTERSECTION_COST * tests),
        }
    }

    /// One scale for all these shots, where the colours stand for numbers. `most` is what the brightest colour stands for; without it the scale
    /// fits nearly all pixels.
    pub fn scale(self, shots: &[&Shot], most: Option<f64>) -> Option<Scale> {
        let title = self.counted()?;
        let values = || shots.iter().flat_map(|shot| &shot.pixels).filter_map(|pixel| self.value(pixel));
        Some(match most {
            Some(most) => Scale { title: title.to_string(), most, signed: false },
            None => Scale::over(title, values().collect(), false),
        })
    }

    /// The picture: with the scale's colours if there is one.
    pub fn paint(self, shot: &Shot, scale: Option<&Scale>) -> Canvas {
        let colour = |pixel: &Pixel| match (self.value(pixel), scale) {
            (Some(value), Some(scale)) => scale.colour(value),
            _ => pixel.seen.map_or(BACKGROUND, |seen| self.surface(&seen, shot)),
        };
        Canvas::of(shot.lens.width, shot.pixels.iter().map(colour).collect())
    }

    fn surface(self, seen: &Seen, shot: &Shot) -> Rgb {
        let light = lamp(seen, shot);
        match self {
            Shade::Normal => seen.normal.map(|c| (127.5 + 127.5 * c).round() as u8),
            Shade::Part => lit(distinct(seen.part), light),
            Shade::Instance => lit(distinct(seen.instance), light),
            _ => lit([250, 242, 225], light),
        }
    }
}

/// How bright a surface is, 0 to 1: a lamp above the eye, to the right, and some light from everywhere.
fn lamp(seen: &Seen, shot: &Shot) -> f64 {
    let back = shot.lens.forward().map(|c| -c);
    let to = [back[0] + 0.3, back[1] + 0.8, back[2] + 0.15];
    let length = (to[0] * to[0] + to[1] * to[1] + to[2] * to[2]).sqrt();
    let normal = seen.normal.map(f64::from);
    let cosine = (normal[0] * to[0] + normal[1] * to[1] + normal[2] * to[2]) / length;
    0.28 + 0.72 * (0.5 + 0.5 * cosine).powi(2)
}

fn lit(colour: Rgb, light: f64) -> Rgb {
    colour.map(|c| (f64::from(c) * light).round() as u8)
}

/// Colours that are far from each other for numbers that are near: hues a golden section of the circle apart, in three lightnesses.
fn distinct(number: u32) -> Rgb {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let hue = 6.0 * (f64::from(number) * GOLDEN + 0.08).fract();
    let (low, high) = [(70.0, 245.0), (120.0, 255.0), (40.0, 205.0)][number as usize % 3];
    let rise = |from: f64| ((hue - from).rem_euclid(6.0) - 3.0).abs() - 1.0;
    [0.0, 2.0, 4.0].map(|from| (low + (high - low) * rise(from).clamp(0.0, 1.0)).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_have_colours_that_differ() {
        for number in 0..200 {
            let near = (1..4).map(|step| {
                let (a, b) = (distinct(number), distinct(number + step));
                (0..3).map(|c| i32::from(a[c]) - i32::from(b[c])).map(i32::abs).sum::<i32>()
            });
            assert!(near.min().unwrap() > 60, "{number}");
        }
    }

    #[test]
    fn the_cost_is_the_sah_s() {
        let pixel = Pixel { seen: None, visits: 10, tests: 3 };
        let values = Shade::ALL.map(|shade| shade.value(&pixel));
        assert_eq!(values, [None, None, None, None, None, Some(10.0), Some(3.0), Some(15.0)]);
    }
}
