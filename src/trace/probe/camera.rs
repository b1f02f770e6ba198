//! Views of a scene for which nobody chose one.

use super::world::World;
use crate::cache::View;
use crate::geom::vector::{dot, sub};
use crate::geom::{Aabb, Ray};
use crate::trace::any_hit;

/// Where the camera rays come from: a pinhole that sees `tan_half` to each side of its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where all its rays start.
    pub eye: [f64; 3],
    /// A point on the axis; not the eye.
    pub look_at: [f64; 3],
    /// What is up in the picture; of any length, not along the axis.
    pub up: [f64; 3],
    /// Tangent of half the angle of view, the same across and upward.
    pub tan_half: f64,
}

impl Camera {
    /// A camera for a scene that nobody chose one for, with y up: where the middle is walled in it stands inside and looks along the longer
    /// horizontal side, elsewhere it looks at the middle from outside. Where nearly all triangles crowd in a small part of the scene, as a
    /// teapot in a stadium, it frames that part.
    pub fn automatic(view: &View<'_>) -> Camera {
        Camera::from_side(view, &subject(view), 0)
    }

    /// Four cameras, so that no single view decides: along the four horizontal directions where the middle is walled in, elsewhere from outside,
    /// from four corners of a cube that are as far from each other as they can be.
    pub fn around(view: &View<'_>) -> [Camera; 4] {
        let subject = subject(view);
        [0, 1, 2, 3].map(|side| Camera::from_side(view, &subject, side))
    }

    fn from_side(view: &View<'_>, subject: &Aabb, side: usize) -> Camera {
        let (min, max) = (subject.min.map(f64::from), subject.max.map(f64::from));
        let extent = sub(max, min);
        let middle = [0, 1, 2].map(|k| (0.5 * (min[k] + max[k])) as f32);
        let walls = (0..6).filter(|i| {
            let mut direction = [0.0; 3];
            direction[i / 2] = if i % 2 == 0 { 1.0 } else { -1.0 };
            any_hit(view, &Ray::new(middle, direction)) == Ok(true)
        });
        if walls.count() < 5 {
            let diagonal = dot(extent, extent).sqrt();
            let center = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]));
            // An even number of signs turned around leads to a corner that is no neighbour.
            let turned = |k: usize| side > 0 && side - 1 != k;
            let offset = [0.5, 0.45, 0.7];
            let eye = [0, 1, 2].map(|k| center[k] + diagonal * if turned(k) { -offset[k] } else { offset[k] });
            Camera { eye, look_at: center, up: [0.0, 1.0, 0.0], tan_half: 0.6 }
        } else {
            // The longer side first and there and back; the first two sides are along one axis.
            let along_x = (extent[0] >= extent[2]) == (side < 2);
            let [start, end, aside, beyond] =
                if side.is_multiple_of(2) { [0.2, 0.9, 0.45, 0.55] } else { [0.8, 0.1, 0.55, 0.45] };
            match along_x {
                true => Camera::within(min, max, [start, 0.4, aside], [end, 0.4, beyond]),
                false => Camera::within(min, max, [aside, 0.4, start], [beyond, 0.4, end]),
            }
        }
    }

    /// With eye and aim as shares of a box's sides.
    pub fn within(min: [f64; 3], max: [f64; 3], eye: [f64; 3], aim: [f64; 3]) -> Camera {
        let at = |share: [f64; 3]| [0, 1, 2].map(|k| min[k] + share[k] * (max[k] - min[k]));
        Camera { eye: at(eye), look_at: at(aim), up: [0.0, 1.0, 0.0], tan_half: 0.6 }
    }
}

/// Triangles that are asked where they are.
const ASKED: usize = 4096;
/// Nearly all triangles: without this share of them at either end of each axis.
const TRIMMED: f64 = 0.02;
/// They crowd if they fill less than this share of the scene's diagonal.
const CROWDED: f64 = 0.125;

/// The box of the scene, or of what nearly all of its triangles are in, with a quarter of it around, if that is much smaller.
pub(crate) fn subject(view: &View<'_>) -> Aabb {
    let world = World::new(view);
    let Some(whole) = world.bounds() else { return Aabb { min: [0.0; 3], max: [1.0; 3] } };
    let asked = world.centres(ASKED);
    let mut core = whole;
    for axis in 0..3 {
        let mut centres: Vec<f32> = asked.iter().map(|p| p[axis]).collect();
        centres.sort_unstable_by(f32::total_cmp);
        let trimmed = (centres.len() as f64 * TRIMMED) as usize;
        if let (Some(low), Some(high)) = (centres.get(trimmed), centres.iter().rev().nth(trimmed)) {
            let around = 0.25 * (high - low);
            (core.min[axis], core.max[axis]) = (low - around, high + around);
        }
    }
    let diagonal = |b: &Aabb| {
        let extent = b.extent().map(f64::from);
        dot(extent, extent).sqrt()
    };
    if diagonal(&core) < CROWDED * diagonal(&whole) { core } else { whole }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Executor, NoProgress, Preset, initial_tree};
    use crate::cache::Image;
    use crate::scene::{Mesh, Part};

    #[test]
    fn cameras_frame_what_nearly_all_triangles_are_in() {
        // A thousand specks around (70, 0, 0), each a hundredth large, on a floor from -100 to 100.
        let specks = (0..1000).flat_map(|i| {
            let at = [70.0 + 0.1 * (i % 10) as f32, 0.1 * (i / 10 % 10) as f32, 0.1 * (i / 100) as f32];
            [at, [at[0] + 0.01, at[1], at[2]], [at[0], at[1] + 0.01, at[2]]]
        });
        let floor = [[-100.0, -1.0, -100.0], [100.0, -1.0, -100.0], [0.0, -1.0, 100.0]];
        let build = |positions: Vec<[f32; 3]>| {
            let triangles: Vec<[u32; 3]> =
                (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let count = triangles.len() as u32;
            let parts = vec![Part { triangle_count: count, prim_count: count, ..Part::default() }];
            let mesh = Mesh { positions, triangles, parts, ..Mesh::default() };
            let options = BuildOptions::preset(Preset::Draft);
            let tree = initial_tree(&mesh, &options, &Executor::sequential(), &NoProgress).unwrap();
            Image::of_tree(&mesh, &tree, &Executor::sequential()).unwrap()
        };
        let crowded = build(specks.clone().chain(floor).collect());
        let framed = subject(&crowded.view());
        assert!(framed.min[0] > 69.0 && framed.max[0] < 72.0 && framed.extent()[2] < 2.0, "{framed:?}");
        for camera in Camera::around(&crowded.view()) {
            assert!((camera.eye[0] - 70.5).abs() < 5.0 && camera.eye[2].abs() < 5.0, "{camera:?}");
        }

        // Without the floor, or with more of it, the whole scene.
        let alone = build(specks.clone().collect());
        assert_eq!(subject(&alone.view()), alone.nodes[0].bounds());
        let tiled =
            build(specks.chain((0..50).flat_map(|i| floor.map(|p| [p[0], p[1] - 0.01 * i as f32, p[2]]))).collect());
        assert_eq!(subject(&tiled.view()), tiled.nodes[0].bounds());
    }
}
