//! [`Difference`]: one scene seen in two trees, pixel by pixel.

use super::canvas::Canvas;
use super::scale::Scale;
use super::shade::Shade;
use super::shot::{Pixel, Shot};
use serde::Serialize;

/// What the second of two shots counts more than the first.
#[derive(Clone, Debug)]
pub struct Difference {
    width: usize,
    /// By pixel, the second's count without the first's.
    values: Vec<f64>,
    /// In numbers.
    pub figures: DifferenceFigures,
}

/// A [`Difference`] in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DifferenceFigures {
    /// The second's mean over the first's; nothing where the first's is 0.
    pub ratio: Option<f64>,
    /// Pixels where the second counts less.
    pub fewer: u64,
    /// Where both count the same.
    pub equal: u64,
    /// Where the second counts more.
    pub more: u64,
    /// The most that the second counts less, as a number from 0 down.
    pub least: f64,
    /// The most that the second counts more.
    pub most: f64,
    /// Pixels that show another surface: two trees of the same triangles have none.
    pub other_hits: u64,
}

/// Distances that differ by more than this share are those of other surfaces: an instance's triangles are rounded where a tree holds them baked.
const ELSEWHERE: f64 = 1e-5;

impl Difference {
    /// Of shots through the same lens. What [`Shade`] counts nothing of is compared by its cost.
    pub fn of(first: &Shot, second: &Shot, shade: Shade) -> Difference {
        let shade = if shade.counted().is_some() { shade } else { Shade::Cost };
        let pairs = || first.pixels.iter().zip(&second.pixels);
        let value = |pixel: &Pixel| shade.value(pixel).unwrap_or(0.0);
        let values: Vec<f64> = pairs().map(|(a, b)| value(b) - value(a)).collect();
        let sum = |shot: &Shot| shot.pixels.iter().map(value).sum::<f64>();
        let (before, after) = (sum(first), sum(second));
        let count = |is: fn(f64) -> bool| values.iter().filter(|v| is(**v)).count() as u64;
        let figures = DifferenceFigures {
            ratio: (before > 0.0).then(|| after / before),
            fewer: count(|v| v < 0.0),
            equal: count(|v| v == 0.0),
            more: count(|v| v > 0.0),
            least: values.iter().copied().fold(0.0, f64::min),
            most: values.iter().copied().fold(0.0, f64::max),
            other_hits: pairs().filter(|(a, b)| !is_same(a, b)).count() as u64,
        };
        Difference { width: first.lens.width, values, figures }
    }

    /// The scale of the map: `most`, or what fits nearly all pixels.
    pub fn scale(&self, most: Option<f64>) -> Scale {
        const TITLE: &str = "difference, right - left";
        match most {
            Some(most) => Scale { title: TITLE.into(), most, signed: true },
            None => Scale::over(TITLE, self.values.clone(), true),
        }
    }

    /// The map.
    pub fn paint(&self, scale: &Scale) -> Canvas {
        Canvas::of(self.width, self.values.iter().map(|v| scale.colour(*v)).collect())
    }
}

fn is_same(a: &Pixel, b: &Pixel) -> bool {
    match (a.seen, b.seen) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let (near, far) = (f64::from(a.depth), f64::from(b.depth));
            (near - far).abs() <= ELSEWHERE * near.abs().max(far.abs())
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::picture::lens::Lens;
    use crate::trace::probe::Camera;

    #[test]
    fn differences_are_counted_by_hand() {
        let camera = Camera { eye: [0.0; 3], look_at: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0], tan_half: 1.0 };
        let shot = |visits: [u32; 4]| Shot {
            lens: Lens::new(&camera, 2, 2),
            pixels: visits.map(|visits| Pixel { seen: None, visits, tests: 2 }).to_vec(),
        };
        let (a, b) = (shot([1, 2, 3, 4]), shot([1, 1, 9, 4]));
        let difference = Difference::of(&a, &b, Shade::Visits);
        let expected =
            DifferenceFigures { ratio: Some(1.5), fewer: 1, equal: 2, more: 1, least: -1.0, most: 6.0, other_hits: 0 };
        assert_eq!(difference.figures, expected);
        assert_eq!(Difference::of(&a, &b, Shade::Tests).figures.equal, 4);
        // Colours that stand for no numbers are compared by what the rays cost.
        assert!((Difference::of(&a, &b, Shade::Lit).figures.most - 7.2).abs() < 1e-9);
        let scale = difference.scale(None);
        assert_eq!((scale.most, difference.paint(&scale).get(0, 0)), (10.0, scale.colour(0.0)));
    }
}
