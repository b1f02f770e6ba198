/// The rotation between two quaternions, `share` of the way along the shorter arc (glTF 2.0, appendix C.4). The result has unit length.
///
/// A quaternion and its negative are one rotation, so the sign of the dot product tells the shorter arc. At exactly 0, where both arcs are
/// equally long, the sign is taken as +, as renderers do; the product is computed in `f64`, where that of `f32` numbers keeps its sign.
///
/// The arc is halved, and the half that holds the result halved again, until a straight line is as good. Square roots are the same on every
/// machine; sines are not.
pub fn slerp(from: [f64; 4], to: [f64; 4], share: f64) -> [f64; 4] {
    let (mut low, mut high) = (unit(from), unit(to));
    if dot(low, high) < 0.0 {
        high = high.map(|c| -c);
    }
    let mut share = share;
    for _ in 0..HALVINGS {
        let middle = unit([0, 1, 2, 3].map(|i| low[i] + high[i]));
        share *= 2.0;
        if share < 1.0 {
            high = middle;
        } else {
            low = middle;
            share -= 1.0;
        }
    }
    unit([0, 1, 2, 3].map(|i| (1.0 - share) * low[i] + share * high[i]))
}

/// What is left of a quarter turn is then 10⁻⁶ long, and the error of a straight line in its place below 10⁻¹⁸.
const HALVINGS: u32 = 20;

fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// A quaternion brought to unit length; one without length stays.
fn unit(q: [f64; 4]) -> [f64; 4] {
    let length = dot(q, q).sqrt();
    if length > 0.0 { q.map(|c| c / length) } else { q }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about_x(half_angle: f64) -> [f64; 4] {
        [half_angle.sin(), 0.0, 0.0, half_angle.cos()]
    }

    #[test]
    fn the_arc_is_walked_at_an_even_pace() {
        for degrees in [1e-9, 1.0, 42.5, 90.0, 170.0, 179.999] {
            let angle = f64::to_radians(degrees) / 2.0;
            for share in [1e-12, 0.1, 0.25, 0.5, 0.77, 1.0 - 1e-12] {
                let got = slerp(about_x(0.3), about_x(0.3 + angle), share);
                let want = about_x(0.3 + angle * share);
                assert!((0..4).all(|i| (got[i] - want[i]).abs() < 4e-15), "{degrees} {share}: {got:?} {want:?}");
            }
        }
    }

    #[test]
    fn the_shorter_arc_is_taken_and_length_does_not_matter() {
        let (from, to) = (about_x(0.2), about_x(0.6));
        let want = slerp(from, to, 0.3);
        for (a, b) in [(2.0, -1.0), (-1.0, 1.0), (0.5, 3.0), (-4.0, -1.0)] {
            let got = slerp(from.map(|c| a * c), to.map(|c| b * c), 0.3);
            let sign = if a < 0.0 { -1.0 } else { 1.0 };
            assert!((0..4).all(|i| (sign * got[i] - want[i]).abs() < 1e-15), "{a} {b}: {got:?}");
        }
    }

    #[test]
    fn half_a_turn_goes_the_way_that_the_product_of_the_stored_numbers_tells() {
        // Their product as floats is 6e-17, as in a turn that a tool has thinned to three keys: only its sign tells the way.
        let (from, to) = ([0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 6e-17]);
        assert!(slerp(from, to, 0.5)[1] > 0.0);
        assert!(slerp(from, [0.0, 1.0, 0.0, -6e-17], 0.5)[1] < 0.0);
        assert!(slerp(from, [0.0, 1.0, 0.0, 0.0], 0.5)[1] > 0.0);
        assert!(slerp(from, [0.0, -1.0, 0.0, -0.0], 0.5)[1] < 0.0);
    }

    #[test]
    fn no_length_is_no_panic() {
        assert_eq!(slerp([0.0; 4], [0.0; 4], 0.5), [0.0; 4]);
        assert!(slerp([f64::NAN; 4], [1.0, 0.0, 0.0, 0.0], 0.5).iter().all(|c| c.is_nan()));
    }
}
