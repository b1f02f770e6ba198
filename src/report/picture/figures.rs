//! [`Figures`]: a shot in numbers.

use super::shade::Shade;
use super::shot::Shot;
use serde::Serialize;

/// What the rays of a shot found and did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// One a pixel.
    pub rays: u64,
    /// Of them, how many hit something.
    pub hits: u64,
    /// Inner nodes visited by a ray.
    pub visits: Spread,
    /// Triangles tested by a ray.
    pub tests: Spread,
    /// 1.2 · visits + tests.
    pub cost: Spread,
}

/// How a count spreads over rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// The arithmetic mean.
    pub mean: f64,
    /// What 99 of 100 rays do not exceed.
    pub p99: f64,
    /// The greatest.
    pub most: f64,
}

impl Figures {
    /// Of all pixels.
    pub fn of(shot: &Shot) -> Figures {
        let spread = |shade: Shade| Spread::of(shot.pixels.iter().filter_map(|p| shade.value(p)).collect());
        Figures {
            rays: shot.pixels.len() as u64,
            hits: shot.pixels.iter().filter(|p| p.seen.is_some()).count() as u64,
            visits: spread(Shade::Visits),
            tests: spread(Shade::Tests),
            cost: spread(Shade::Cost),
        }
    }
}

impl Spread {
    fn of(mut values: Vec<f64>) -> Spread {
        if values.is_empty() {
            return Spread::default();
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.sort_unstable_by(f64::total_cmp);
        let rank = (values.len() * 99).div_ceil(100).max(1) - 1;
        Spread { mean, p99: values[rank], most: values[values.len() - 1] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_have_closed_forms() {
        let spread = Spread::of((1..=100).rev().map(f64::from).collect());
        assert_eq!(spread, Spread { mean: 50.5, p99: 99.0, most: 100.0 });
        assert_eq!(Spread::of(vec![3.0]), Spread { mean: 3.0, p99: 3.0, most: 3.0 });
        assert_eq!(Spread::of(vec![]), Spread::default());
    }
}
