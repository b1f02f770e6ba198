//! What is seen of a polygon before it is cut.

use super::*;
use crate::random::Random;
use std::f64::consts::TAU;

fn around(n: usize, turns: f64, radius: impl FnMut(f64) -> f64) -> Vec<[f64; 2]> {
    let shares = (0..n).map(|i| i as f64 / n as f64);
    let at = |(share, radius): (f64, f64)| [radius * (turns * TAU * share).cos(), radius * (turns * TAU * share).sin()];
    let radii: Vec<f64> = shares.clone().map(radius).collect();
    shares.zip(radii).map(at).collect()
}

#[test]
fn scattered_corners_wind_backwards_and_what_can_be_cut_does_not() {
    let mut random = Random::new(1);
    for n in [100, 2000, 16_384] {
        let scattered: Vec<[f64; 2]> = (0..n).map(|_| [random.unit(), random.unit()]).collect();
        assert!(winds_backwards(&scattered), "{n} corners");
        let ribbon: Vec<[f64; 2]> = {
            let out = around(n / 2, 20.0, |share| 1.0 + share);
            let back = around(n / 2, 20.0, |share| 1.01 + share);
            out.iter().chain(back.iter().rev()).map(|p| [p[0], -p[1]]).collect()
        };
        for whole in [
            around(n, 1.0, |_| 1.0),
            around(n, 1.0, |_| 0.1 + random.unit()),
            around(n, 3.0, |share| 1.0 + share),
            ribbon,
        ] {
            assert!(!winds_backwards(&whole), "{n} corners");
        }
    }
    assert!(
        !winds_backwards(&[[f64::NAN; 2]; 40])
            && !winds_backwards(&[[f64::INFINITY, 0.0]; 40])
            && !winds_backwards(&[])
    );
}

/// The answer must be the one that cutting would give, only sooner.
#[test]
fn what_winds_backwards_cannot_be_cut() {
    let (mut random, mut found) = (Random::new(2), 0);
    for round in 0..300 {
        let n = 33 + (random.unit() * 200.0) as usize;
        let flat: Vec<[f64; 2]> = match round % 3 {
            0 => (0..n).map(|_| [random.unit(), random.unit()]).collect(),
            1 => around(n, 1.0, |_| 1.0).iter().map(|p| p.map(|c| c + 0.7 * random.unit())).collect(),
            _ => around(n, 1.0, |_| 4.0).iter().map(|p| p.map(|c| (c + 5.0 * random.unit()).floor())).collect(),
        };
        if winds_backwards(&flat) {
            found += 1;
            let mut cut = Triangulator { flat, ..Triangulator::new() };
            assert!(!cut.clip_ears(&mut Vec::new()), "round {round}");
        }
    }
    assert!(found > 50, "{found}");
}
