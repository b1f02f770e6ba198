use super::*;
use crate::random::Random;
use std::cmp::Ordering;

/// Every number as a whole multiple of 2⁻¹⁴⁹.
fn big(v: f32) -> BigInt {
    let (m, e) = parts(v);
    if m == 0 { BigInt::ZERO } else { BigInt::from(m) << (e + 149) }
}

/// Whether the line meets the triangle and at which fractions `(t, u, v)` over a common positive denominator, by Cramer's rule for
/// `o + t·d = p + u·(q − p) + v·(r − p)`: another formula than the one under test.
fn by_cramer(ray: &Ray, corners: [Point; 3]) -> Option<([BigInt; 3], BigInt)> {
    let (o, d) = (ray.origin.map(big), ray.direction.map(big));
    let [p, q, r] = corners.map(|c| c.map(big));
    let minus = |a: &[BigInt; 3], b: &[BigInt; 3]| [0, 1, 2].map(|k| &a[k] - &b[k]);
    let determinant = |a: &[BigInt; 3], b: &[BigInt; 3], c: &[BigInt; 3]| -> BigInt {
        let term = |i: usize, j: usize, k: usize| &a[i] * &b[j] * &c[k];
        term(0, 1, 2) + term(1, 2, 0) + term(2, 0, 1) - term(0, 2, 1) - term(1, 0, 2) - term(2, 1, 0)
    };
    let (e, f, s) = (minus(&q, &p), minus(&r, &p), minus(&o, &p));
    let back = d.map(|v| -v);
    let mut bottom = determinant(&back, &e, &f);
    let mut tops = [determinant(&s, &e, &f), determinant(&back, &s, &f), determinant(&back, &e, &s)];
    if bottom == BigInt::ZERO {
        return None;
    }
    if bottom < BigInt::ZERO {
        bottom = -bottom;
        tops = tops.map(|v| -v);
    }
    let zero = BigInt::ZERO;
    (tops[1] >= zero && tops[2] >= zero && &tops[1] + &tops[2] <= bottom).then_some((tops, bottom))
}

fn check(ray: &Ray, corners: [Point; 3]) -> bool {
    let (got, expected) = (meet(ray, corners), by_cramer(ray, corners));
    assert_eq!(got.is_some(), expected.is_some(), "{ray:?} {corners:?}");
    if let (Some(got), Some(([t, u, v], bottom))) = (&got, expected) {
        for (ratio, top) in [(&got.t, t), (&got.u, u), (&got.v, v)] {
            assert_eq!(*ratio, Ratio::new(top, bottom.clone(), 0), "{ray:?} {corners:?}");
        }
    }

    // Big integers come to the same end as 128 bits, and a map that changes nothing changes nothing.
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mapped = Line::mapped(ray, &identity).meet(corners);
    assert_eq!(mapped.as_ref().map(|m| [&m.t, &m.u, &m.v]), got.as_ref().map(|m| [&m.t, &m.u, &m.v]));
    got.is_some()
}

fn nudged(v: f32, random: &mut Random) -> f32 {
    match random.below(4) {
        0 => v.next_up(),
        1 => v.next_down(),
        _ => v,
    }
}

#[test]
fn rays_aimed_at_edges_and_corners_are_decided_as_cramers_rule_does() {
    let mut random = Random::new(1);
    let mut met = 0;
    for round in 0..6000 {
        // Whole numbers give exact aims, ordinary ones near misses.
        let number = |random: &mut Random| match round % 3 {
            0 => random.whole(6),
            1 => (2.0 * random.unit() - 1.0) as f32,
            _ => (1e6 + 8.0 * random.unit()) as f32,
        };
        let point = |random: &mut Random| -> Point { [0; 3].map(|_| number(random)) };
        let (corners, origin) = ([0; 3].map(|_| point(&mut random)), point(&mut random));
        let [p, q, r] = corners;
        let direction = match random.below(4) {
            0 => [0, 1, 2].map(|a| p[a] - origin[a]),
            1 => [0, 1, 2].map(|a| p[a] + q[a] - 2.0 * origin[a]),
            2 => [0, 1, 2].map(|a| p[a] + q[a] + r[a] - 3.0 * origin[a]),
            _ => point(&mut random),
        };
        let direction = direction.map(|d| nudged(d, &mut random));
        met += u32::from(check(&Ray::new(origin, direction), corners));
    }
    assert!((1500..5000).contains(&met), "{met}");
}

#[test]
fn huge_and_denormal_numbers_are_decided_as_cramers_rule_does() {
    let mut random = Random::new(2);
    let special = [0.0, -0.0, 1.0, -1.0, 3e38, -3e38, 1e-45, -1e-45, 1e-38, 1e20, -1e-20, 0.5];
    let pick = |random: &mut Random| special[random.below(special.len() as u64) as usize];
    let mut met = 0;
    for _ in 0..4000 {
        let [p, q, r, origin, direction] = [0; 5].map(|_| [0; 3].map(|_| pick(&mut random)));
        met += u32::from(check(&Ray::new(origin, direction), [p, q, r]));
    }
    assert!(met > 20, "{met}");
}

#[test]
fn a_triangle_without_area_and_one_seen_edge_on_are_missed() {
    let line = [[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]];
    assert!(meet(&Ray::new([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]), line).is_none());
    assert!(meet(&Ray::new([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]), [[1.0, 1.0, 3.0]; 3]).is_none());
    let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert!(meet(&Ray::new([-1.0, 0.25, 0.0], [1.0, 0.0, -0.0]), flat).is_none());
    assert!(meet(&Ray::new([-1.0, 0.25, 1e-45], [1.0, 0.0, -1e-45]), flat).is_some());
}

#[test]
fn a_line_through_a_shared_edge_meets_both_sides() {
    let mut random = Random::new(3);
    for _ in 0..500 {
        let point = |random: &mut Random| -> Point { [0; 3].map(|_| random.whole(100)) };
        let [a, b, c, d] = [0; 4].map(|_| point(&mut random));
        let origin = point(&mut random);
        let ray = Ray::new(origin, [0, 1, 2].map(|k| a[k] + b[k] - 2.0 * origin[k]));
        for corners in [[a, b, c], [b, a, d]] {
            let seen = by_cramer(&ray, corners).is_some();
            assert_eq!(meet(&ray, corners).is_some(), seen);
            // Only edge-on, or without area, does the line not meet it.
            let (e, f) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| corners[2][k] - a[k]));
            let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]].map(f64::from);
            let facing: f64 = (0..3).map(|k| n[k] * f64::from(ray.direction[k])).sum();
            assert_eq!(seen, facing != 0.0, "{ray:?} {corners:?}");
        }
    }
}

#[test]
fn a_mapped_line_is_that_of_the_mapped_numbers() {
    // Quarters and powers of two keep the mapped ray in f32, so that it can be asked directly.
    let matrix = [0.0, 2.0, 0.0, 5.0, -2.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.5, -1.0];
    let mut random = Random::new(4);
    for _ in 0..500 {
        let point = |random: &mut Random| -> Point { [0; 3].map(|_| random.whole(16)) };
        let (origin, direction, corners) = (point(&mut random), point(&mut random), [0; 3].map(|_| point(&mut random)));
        let row = |v: Point, r: usize| matrix[4 * r] * v[0] + matrix[4 * r + 1] * v[1] + matrix[4 * r + 2] * v[2];
        let ray = Ray::new([0, 1, 2].map(|r| row(origin, r) + matrix[4 * r + 3]), [0, 1, 2].map(|r| row(direction, r)));
        let (plain, mapped) = (meet(&ray, corners), Line::mapped(&Ray::new(origin, direction), &matrix).meet(corners));
        assert_eq!(plain.map(|m| m.t), mapped.map(|m| m.t));
    }
}

#[test]
fn ratios_compare_and_round_as_their_values() {
    let mut random = Random::new(5);
    for _ in 0..4000 {
        let (top, bottom) = (random.whole(1 << 22) as i64, 1 + random.below(1 << 22) as i64);
        let shift = random.whole(60) as i32;
        let ratio = Ratio::new((-top).into(), (-bottom).into(), shift);
        let value = top as f64 / bottom as f64 * 2f64.powi(shift);
        assert_eq!(ratio.to_f32(), value as f32, "{top} / {bottom} · 2^{shift}");
        assert!((ratio.to_f64() - value).abs() <= value.abs() * 2f64.powi(-52));

        // The nearest float's neighbours are no nearer.
        let float = value as f32;
        let exactly = |v: f32| ratio.compare(v).expect("a number");
        assert!(exactly(float.next_up()) == Ordering::Less && exactly(float.next_down()) == Ordering::Greater);
    }
    let third = Ratio::new(1.into(), 3.into(), 0);
    assert_eq!(third, Ratio::new((-4).into(), (-3).into(), -2));
    assert_eq!(third.compare(f32::INFINITY), Some(Ordering::Less));
    assert_eq!(third.compare(f32::NEG_INFINITY), Some(Ordering::Greater));
    assert_eq!(third.compare(f32::NAN), None);
    assert_eq!(third.compare(-0.0), Some(Ordering::Greater));
    assert_eq!(Ratio::new(1.into(), 1.into(), 2000).to_f32(), f32::INFINITY);
    assert_eq!(Ratio::new(1.into(), 1.into(), -2000).to_f64(), 0.0);
    assert_eq!(Ratio::new(3.into(), 1.into(), -150).to_f32(), f32::from_bits(2)); // halfway: to even
}
