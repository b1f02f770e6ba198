//! Conservativeness is tested in exact arithmetic: the tests' coordinates are multiples of 2⁻⁵⁰ below 2¹⁹, so a point of a
//! triangle with dyadic barycentric coordinates is a triple of integers that fit an `i128`, in units of 2⁻⁷⁴.

use super::*;
use proptest::prelude::*;

/// `value · 2^scale`, rounded away from zero beyond the last bit.
fn fixed(value: f32, scale: i32) -> i128 {
    let bits = value.to_bits();
    let (exponent, fraction) = ((bits >> 23 & 0xff) as i32, i128::from(bits & 0x7f_ffff));
    let (mantissa, exponent) = if exponent == 0 { (fraction, -149) } else { (fraction | 0x80_0000, exponent - 150) };
    let magnitude = match exponent + scale {
        shift @ 0.. => mantissa << shift,
        shift => (mantissa >> -shift.max(-30)) + i128::from(mantissa & ((1 << -shift.max(-30)) - 1) != 0),
    };
    if value < 0.0 { -magnitude } else { magnitude }
}

/// A coordinate; exact.
fn exact(value: f32) -> i128 {
    fixed(value, UNIT)
}

/// Coordinates are held in units of 2^-UNIT.
const UNIT: i32 = 50;
/// Edges are cut at multiples of 2^-STEPS.
const STEPS: u32 = 24;

/// The point `a + (b - a)·t/2^STEPS`, times 2^STEPS.
fn along(a: i128, b: i128, t: i128) -> i128 {
    (a << STEPS) + (b - a) * t
}

/// The points' units next below and above a bound or plane, which has finer bits than coordinates and may have finer ones than points.
fn units(value: f32) -> (i128, i128) {
    let away = fixed(value, UNIT + STEPS as i32);
    let is_exact = away as f64 == f64::from(value) * 2f64.powi(UNIT + STEPS as i32);
    match value < 0.0 {
        _ if is_exact => (away, away),
        true => (away, away + 1),
        false => (away - 1, away),
    }
}

fn is_in(p: [i128; 3], b: &Aabb) -> bool {
    (0..3).all(|k| b.min[k] <= b.max[k] && units(b.min[k]).1 <= p[k] && p[k] <= units(b.max[k]).0)
}

/// Points on the edges next to a plane, from both sides, and points all over the triangle.
fn samples(triangle: &[Point; 3], axis: usize, planes: &[f32]) -> Vec<[i128; 3]> {
    let corners = triangle.map(|c| c.map(exact));
    let one = 1i128 << STEPS;
    let mut out = Vec::new();
    for e in 0..3 {
        let (a, b) = (corners[e], corners[(e + 1) % 3]);
        let at = |t: i128| [0, 1, 2].map(|k| along(a[k], b[k], t));
        out.extend([0, one / 3, one].map(at));
        for plane in planes {
            let plane = exact(*plane) << STEPS;
            let (mut low, mut high) = (0, one);
            if (at(low)[axis] < plane) == (at(high)[axis] < plane) {
                continue;
            }
            while high - low > 1 {
                let middle = (low + high) / 2;
                if (at(middle)[axis] < plane) == (at(low)[axis] < plane) { low = middle } else { high = middle }
            }
            out.extend([at(low), at(high)]);
        }
    }
    for i in 0..=16i128 {
        for j in 0..=16 - i {
            let k = 16 - i - j;
            out.push([0, 1, 2].map(|x| ((corners[0][x] * i + corners[1][x] * j + corners[2][x] * k) << STEPS) / 16));
        }
    }
    out
}

/// Both cutters against all samples, for a triangle whose reference is its part inside `within`.
fn check_cuts(triangle: &[Point; 3], within: &Aabb, axis: usize, count: usize) -> Result<(), TestCaseError> {
    let reference = Polygon::inside(triangle, within).bounds(&Aabb::from_points(triangle).intersection(*within));
    if reference.is_empty() {
        for p in samples(triangle, axis, &[]) {
            prop_assert!(!is_in(p, within), "the polygon is empty, but {p:?} lies inside {within:?}");
        }
        return Ok(());
    }
    for p in samples(triangle, axis, &[]).iter().filter(|p| is_in(**p, within)) {
        prop_assert!(is_in(*p, &reference), "{p:?} was lost by the box {within:?}");
    }
    let extent = reference.extent()[axis];
    let planes: Vec<f32> =
        (0..=count).map(|i| representable(reference.min[axis] + extent * (i as f32 / count as f32))).collect();
    let points: Vec<_> = samples(triangle, axis, &planes).into_iter().filter(|p| is_in(*p, &reference)).collect();

    // Slabs: a point between two planes lies in the slab's box, planes belonging to both sides.
    for pair in planes.windows(2) {
        let part = slab_bounds(triangle, axis, pair[0], pair[1], &reference);
        let slab = split_box(&split_box(&reference, axis, pair[1]).0, axis, pair[0]).1;
        prop_assert!(part.is_empty() || (slab.contains(&part) && reference.contains(&part)));
        for p in points.iter().filter(|p| is_in(**p, &slab)) {
            prop_assert!(is_in(*p, &part), "{p:?} in slab {slab:?} is not in {part:?}");
        }
    }

    // Split in two, at planes inside, at the ends and outside.
    let outside = [reference.min[axis], reference.max[axis], reference.max[axis] + 1.0, reference.min[axis] - 1.0];
    for plane in planes.into_iter().chain(outside) {
        let (below, above) = split(triangle, axis, plane, &reference);
        let (box_below, box_above) = split_box(&reference, axis, plane);
        for (part, whole) in [(&below, &box_below), (&above, &box_above)] {
            prop_assert!(part.is_empty() || (whole.contains(part) && reference.contains(part)));
        }
        let (floor, ceiling) = units(plane);
        for p in &points {
            prop_assert!(p[axis] > floor || is_in(*p, &below), "{p:?} below {plane} is not in {below:?}");
            prop_assert!(p[axis] < ceiling || is_in(*p, &above), "{p:?} above {plane} is not in {above:?}");
            prop_assert!(p[axis] > floor || is_in(*p, &box_below));
            prop_assert!(p[axis] < ceiling || is_in(*p, &box_above));
        }
    }
    Ok(())
}

/// Small integers (planes on corners), ordinary numbers, and numbers of very different size.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        (-4i32..=4).prop_map(|i| i as f32),
        -10.0f32..10.0,
        (-26i32..=18, -1.0f32..1.0).prop_map(|(e, m)| m * 2f32.powi(e)).prop_map(representable),
    ]
    .prop_map(representable)
}

/// Round to a multiple of 2^-UNIT.
fn representable(v: f32) -> f32 {
    let unit = 2f64.powi(UNIT);
    ((f64::from(v) * unit).round() / unit) as f32
}

fn point() -> impl Strategy<Value = Point> {
    [coordinate(), coordinate(), coordinate()]
}

/// Triangles as they come, slivers (a third corner next to an edge) and triangles without area.
fn triangle() -> impl Strategy<Value = [Point; 3]> {
    prop_oneof![
        3 => [point(), point(), point()],
        1 => (point(), point(), 0.0f32..1.0).prop_map(|(a, b, t)| {
            [a, b, [0, 1, 2].map(|k| representable(a[k] + t * (b[k] - a[k])))]
        }),
        1 => (point(), point()).prop_map(|(a, b)| [a, a, b]),
        1 => point().prop_map(|a| [a, a, a]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn no_point_of_a_triangle_is_lost(t in triangle(), axis in 0usize..3, count in 2usize..40) {
        check_cuts(&t, &Aabb { min: [-1e6; 3], max: [1e6; 3] }, axis, count)?;
    }

    #[test]
    fn no_point_of_a_fragment_is_lost(t in triangle(), a in point(), b in point(), axis in 0usize..3, count in 2usize..9) {
        check_cuts(&t, &Aabb::from_points(&[a, b]), axis, count)?;
    }

    #[test]
    fn cutting_again_and_again_loses_nothing(t in triangle(), cuts in prop::collection::vec((0usize..3, 0.0f32..1.0, any::<bool>()), 1..7)) {
        let mut reference = Aabb::from_points(&t);
        for (axis, share, upper) in cuts {
            let plane = representable(reference.min[axis] + share * reference.extent()[axis]);
            let parts = split(&t, axis, plane, &reference);
            let part = if upper { parts.1 } else { parts.0 };
            let (below, above) = split_box(&reference, axis, plane);
            let region = if upper { above } else { below };
            for p in samples(&t, axis, &[plane]).into_iter().filter(|p| is_in(*p, &region)) {
                prop_assert!(is_in(p, &part), "{p:?} of {region:?} is not in {part:?}");
            }
            if part.is_empty() {
                break;
            }
            reference = part;
        }
    }
}

/// A plane between two units of coordinates: what stands between the unit and the plane is on neither side that the unit suggests.
#[test]
fn a_plane_finer_than_coordinates_is_compared_as_it_is() {
    let t = [[-2.8777347, 0.0, 0.0], [3.0, -1.1450346e-8, -9.0133295], [-2.5286756, -6.799974e-10, -0.5352715]];
    let t = t.map(|p: Point| p.map(representable));
    let within = Aabb { min: [0.0, -1.0, representable(-6.541136)], max: [1.0, 0.0, 0.0] };
    check_cuts(&t, &within, 1, 2).unwrap();
}

#[test]
fn a_right_triangle_is_cut_tightly() {
    let t = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let whole = Aabb::from_points(&t);
    let (below, above) = split(&t, 0, 3.0, &whole);
    assert_eq!(below, Aabb { min: [0.0; 3], max: [3.0, 4.0, 0.0] });
    assert_eq!(above.min, [3.0, 0.0, 0.0]);
    assert!(above.max[1] >= 1.0 && above.max[1] < 1.0 + 2e-7, "{above:?}");
    let (below, above) = split_box(&whole, 0, 3.0);
    assert_eq!((below.max, above.min), ([3.0, 4.0, 0.0], [3.0, 0.0, 0.0]));
}

#[test]
fn a_plane_through_a_corner_leaves_the_other_side_its_tip() {
    let t = [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 5.0]];
    let whole = Aabb::from_points(&t);
    let (below, above) = split(&t, 0, 1.0, &whole);
    assert!(is_in(t[2].map(|v| exact(v) << STEPS), &below) && is_in(t[2].map(|v| exact(v) << STEPS), &above));
    // On the first plane nothing lies below but the corner itself; beyond the last plane nothing at all.
    assert_eq!(split(&t, 0, 0.0, &whole).0.max[0], 0.0);
    assert!(split(&t, 0, 9.0, &whole).1.is_empty());
    assert!(split(&t, 0, -9.0, &whole).0.is_empty());
}

#[test]
fn coordinates_at_the_ends_of_the_range_neither_vanish_nor_overflow() {
    for size in [f32::MAX, 1e30, 1e-30, 1e-40, f32::from_bits(16)] {
        let t = [[-size, -size, 0.0], [size, -size / 2.0, size], [0.0, size, -size]];
        let whole = Aabb::from_points(&t);
        let (below, above) = split(&t, 1, size / 4.0, &whole);
        assert!(whole.contains(&below) && whole.contains(&above) && !below.is_empty() && !above.is_empty());
        assert!(below.contains(&Aabb::from_points(&t[..2])) && above.contains(&Aabb::from_points(&t[2..])));
    }
}
