//! The exact test for triangles without area.

use crate::geom::Point;

/// Whether the three points lie on one line (two of them may be equal), decided without rounding. The points must be finite.
///
/// Three points are collinear in space when they are so in all three coordinate planes. In a plane the test is the sign of
/// a 2×2 determinant: computed in `f64` with a bound on its rounding error, and only where that does not decide, summed
/// exactly (Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997).
pub(crate) fn is_collinear([a, b, c]: [Point; 3]) -> bool {
    [(0, 1), (1, 2), (2, 0)].iter().all(|&(x, y)| {
        let pick = |p: Point| [f64::from(p[x]), f64::from(p[y])];
        is_collinear_2d(pick(a), pick(b), pick(c))
    })
}

fn is_collinear_2d(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> bool {
    let left = (a[0] - c[0]) * (b[1] - c[1]);
    let right = (a[1] - c[1]) * (b[0] - c[0]);
    // Seven roundings at most, each below 2⁻⁵³ of |left| + |right|; no product of f32 differences underflows in f64.
    if (left - right).abs() > (left.abs() + right.abs()) * 2f64.powi(-49) {
        return false;
    }

    // The determinant, multiplied out: a product of two f32 values is exact in f64.
    let products = [a[0] * b[1], -a[0] * c[1], -c[0] * b[1], -a[1] * b[0], a[1] * c[0], c[1] * b[0]];
    sums_to_zero(&products)
}

/// Whether the values add up to exactly zero: a nonoverlapping expansion of the running sum is kept, whose parts are all zero
/// only if the sum is.
fn sums_to_zero(values: &[f64; 6]) -> bool {
    let mut parts = [0.0f64; 6];
    for (i, &value) in values.iter().enumerate() {
        let mut carry = value;
        for part in &mut parts[..i] {
            let (sum, error) = two_sum(carry, *part);
            *part = error;
            carry = sum;
        }
        parts[i] = carry;
    }
    parts.iter().all(|&p| p == 0.0)
}

/// The rounded sum and its rounding error, exactly (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    (sum, (a - a_part) + (b - b_part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_corners_and_points_on_a_line_have_no_area() {
        let p = [1.5, -2.0, 3.25];
        assert!(is_collinear([p, p, [0.0; 3]]) && is_collinear([p, [7.0; 3], p]) && is_collinear([p, p, p]));
        assert!(is_collinear([[0.0; 3], [1.0, 2.0, 3.0], [3.0, 6.0, 9.0]]));
        assert!(!is_collinear([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
    }

    #[test]
    fn one_unit_in_the_last_place_is_area() {
        let third = 1.0f32 / 3.0;
        let line = [[0.0; 3], [third; 3], [2.0 * third; 3]];
        assert!(is_collinear(line));
        let mut bent = line;
        bent[1][2] = third.next_up();
        assert!(!is_collinear(bent));
    }

    #[test]
    fn extremes_of_the_range_are_decided_exactly() {
        let tiny = f32::from_bits(1);
        assert!(!is_collinear([[0.0; 3], [tiny, 0.0, 0.0], [0.0, tiny, 0.0]]));
        assert!(!is_collinear([[f32::MAX, 0.0, 0.0], [-f32::MAX, 0.0, 0.0], [0.0, tiny, 0.0]]));
        assert!(is_collinear([[f32::MAX; 3], [-f32::MAX; 3], [0.0; 3]]));
        // The middle point misses the line by the smallest number there is, far below the differences' own rounding.
        assert!(!is_collinear([[f32::MAX; 3], [-f32::MAX; 3], [tiny, 0.0, 0.0]]));
    }

    /// The same question in integers, on points whose coordinates are small multiples of powers of two.
    #[test]
    fn agrees_with_integer_arithmetic() {
        let mut state = 1u64;
        let mut next = |n: i64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as i64 % n
        };
        for _ in 0..20_000 {
            let p: [[i64; 3]; 3] = [(); 3].map(|()| [(); 3].map(|()| next(5) - 2 + (next(2) << 23)));
            let u: [i64; 3] = [0, 1, 2].map(|k| p[1][k] - p[0][k]);
            let v: [i64; 3] = [0, 1, 2].map(|k| p[2][k] - p[0][k]);
            let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            assert_eq!(is_collinear(p.map(|q| q.map(|c| c as f32))), cross == [0; 3], "{p:?}");
        }
    }
}
