//! Answers of a traversal that is not ours: a distance and a triangle a ray, in single precision, about a scene of one mesh.

use crate::trace::brute::{Answer, Order, Standing};
use crate::trace::compare::Verdict;

/// How much of a distance another traversal may be off, in single precision and with whatever triangle test, before a triangle counts as
/// another one: 2⁻¹⁴, a thousand times what rounding costs once.
pub const SLACK: f64 = 1.0 / 16_384.0;

/// Judge the nearest hit that was found, by its distance and the number of its triangle in the mesh.
///
/// What is asked is what a picture shows: whether a surface is there, and that no nearer one is passed over. So a triangle that the ray
/// misses by a hair counts as right where the distance is that of the true hit, as on an edge that two triangles share; and so does the
/// farther of two that lie nearer to each other than [`SLACK`].
pub fn judge(answer: &Answer, found: Option<(f32, u32)>) -> Verdict {
    let certain = answer.certain();
    let Some((t, triangle)) = found else {
        return match certain {
            Some(_) => Verdict::Missed,
            None if answer.has(Standing::BareHit) => Verdict::Grazing,
            None => Verdict::Agree,
        };
    };
    let candidate = answer.candidates.iter().find(|c| c.source.triangle == triangle);
    let t = f64::from(t);
    let slack = SLACK * t.abs();
    match (certain, candidate) {
        // Its own distance is not held against it where it names the nearest triangle.
        (_, Some(c)) if c.order == Order::First => Verdict::Agree,
        (_, Some(c)) if matches!(c.order, Order::Equal | Order::Rounded) => Verdict::Tie,
        (Some(nearest), Some(c)) if c.nearest > nearest.farthest + slack => Verdict::Farther,
        (Some(nearest), None) if t > nearest.farthest + slack => Verdict::Farther,
        (Some(nearest), None) if t < nearest.nearest - slack => Verdict::False,
        (None, None) => Verdict::False,
        _ => Verdict::Grazing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::Executor;
    use crate::geom::Ray;
    use crate::scene::{Mesh, Scene};
    use crate::trace::brute::Oracle;

    /// Two unit squares of two triangles each, at z = 0 and at z = -1.
    fn squares() -> Scene {
        let square = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
        let positions = [square(0.0), square(-1.0)].concat();
        let triangles = [0, 4].iter().flat_map(|i| [[*i, i + 1, i + 2], [*i, i + 2, i + 3]]).collect();
        Scene::of_mesh(Mesh::new("", positions, triangles).unwrap())
    }

    #[test]
    fn what_is_lost_passed_over_or_made_up_is_told() {
        let scene = squares();
        let oracle = Oracle::new(&scene, &Executor::sequential());
        let down = |x: f32, y: f32| oracle.trace(&Ray::new([x, y, 2.0], [0.0, 0.0, -1.0]));
        let inside = down(0.75, 0.25);
        assert_eq!(judge(&inside, Some((2.0, 0))), Verdict::Agree);
        assert_eq!(judge(&inside, Some((2.0001, 0))), Verdict::Agree);
        assert_eq!(judge(&inside, None), Verdict::Missed);
        assert_eq!(judge(&inside, Some((3.0, 2))), Verdict::Farther);
        // The neighbour, which the ray misses: at the surface's distance it is right, elsewhere it is none.
        assert_eq!(judge(&inside, Some((2.00001, 1))), Verdict::Grazing);
        assert_eq!(judge(&inside, Some((1.0, 1))), Verdict::False);
        assert_eq!(judge(&inside, Some((3.0, 3))), Verdict::Farther);

        let edge = down(0.5, 0.5);
        let verdicts = [0, 1].map(|triangle| judge(&edge, Some((2.0, triangle))));
        assert_eq!(verdicts, [Verdict::Agree, Verdict::Tie]);
        // Exactly on an edge no hit is certain, and losing both triangles is not held against anybody.
        assert_eq!(judge(&edge, None), Verdict::Grazing);

        let outside = down(1.5, 0.5);
        assert_eq!((judge(&outside, None), judge(&outside, Some((2.0, 0)))), (Verdict::Agree, Verdict::False));
    }
}
