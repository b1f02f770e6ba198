//! The boxes of one level of a tree, drawn over the scene.

use super::canvas::{Canvas, Rgb};
use super::lens::Lens;
use super::shot::Shot;
use crate::cache::View;
use crate::geom::Affine;
use crate::trace::{Malformed, SceneVisit, Step};

/// The corners of a box in world space: corner `i` has the far side along axis `k` where bit `k` of `i` is set.
type Corners = [[f64; 3]; 8];

/// Boxes of the nodes on `level`, and of leaves above it. The root is on level 0; below the leaves of a top level its instances' trees go on.
///
/// # Errors
/// Where the records are no tree.
pub fn boxes(view: &View<'_>, level: u32) -> Result<Vec<Corners>, Malformed> {
    let (mut found, mut above, mut place) = (Vec::new(), 0, Affine::IDENTITY);
    view.visit(|at| match at {
        SceneVisit::Top { node, depth, .. } => {
            above = depth + 1;
            if depth < level {
                return Step::Descend;
            }
            found.push(corners(node, &Affine::IDENTITY));
            Step::Skip
        }
        SceneVisit::Instance { instance, .. } => {
            place = Affine::from_f32(&instance.object_to_world);
            Step::Descend
        }
        SceneVisit::Tree { at, .. } => {
            if above + at.depth < level && !at.node.is_leaf() {
                return Step::Descend;
            }
            found.push(corners(at.node, &place));
            Step::Skip
        }
        _ => Step::Descend,
    })?;
    Ok(found)
}

fn corners(node: &crate::tree::Node, place: &Affine) -> Corners {
    [0, 1, 2, 3, 4, 5, 6, 7].map(|i: usize| {
        let corner = [0, 1, 2].map(|k| f64::from(if i >> k & 1 == 0 { node.min[k] } else { node.max[k] }));
        place.transform_point(corner)
    })
}

/// Pairs of corners that differ along one axis.
fn edges() -> impl Iterator<Item = [usize; 2]> {
    (0..8usize).flat_map(|i| (0..3).filter(move |k| i >> k & 1 == 0).map(move |k| [i, i | 1 << k]))
}

const COLOURS: [Rgb; 6] =
    [[255, 220, 60], [90, 210, 255], [255, 120, 200], [140, 255, 130], [255, 160, 70], [190, 160, 255]];
/// How opaque lines are before what the shot sees, and behind it.
const BEFORE: f64 = 0.9;
const BEHIND: f64 = 0.22;

/// Draw the edges of boxes: clearly where nothing of the scene is before them, faintly elsewhere.
///
/// The canvas is the shot's film, or smaller by a whole number.
pub fn draw(canvas: &mut Canvas, shot: &Shot, boxes: &[Corners]) {
    let lens = &shot.lens;
    let by = (lens.width / canvas.width().max(1)).max(1);
    for (number, corners) in boxes.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let seen = corners.map(|corner| lens.seen_from_eye(corner));
        for [a, b] in edges() {
            line(canvas, shot, by, seen[a], seen[b], colour);
        }
    }
}

/// One edge, in the camera's own axes.
fn line(canvas: &mut Canvas, shot: &Shot, by: usize, a: [f64; 3], b: [f64; 3], colour: Rgb) {
    let lens = &shot.lens;
    let Some([a, b]) = visible(lens, a, b) else { return };
    let ([x0, y0], [x1, y1]) = (lens.on_film(a), lens.on_film(b));
    let steps = ((x1 - x0).abs().max((y1 - y0).abs()) / by as f64).ceil().max(1.0) as usize;
    let mut last = None;
    for i in 0..=steps {
        let share = i as f64 / steps as f64;
        let [x, y] = [x0 + share * (x1 - x0), y0 + share * (y1 - y0)].map(|c| c.floor() as i64);
        let place = [x.div_euclid(by as i64), y.div_euclid(by as i64)];
        if last.replace(place) == Some(place) {
            continue;
        }
        // What is straight on the film is the reciprocal of depth.
        let depth = 1.0 / (1.0 / a[2] + share * (1.0 / b[2] - 1.0 / a[2]));
        let on_film = x >= 0 && y >= 0 && (x as usize) < lens.width && (y as usize) < lens.height;
        let seen = if on_film { shot.pixels[y as usize * lens.width + x as usize].seen } else { None };
        let is_before = seen.is_none_or(|seen| depth <= f64::from(seen.depth) * 1.001);
        canvas.blend(place[0], place[1], colour, if is_before { BEFORE } else { BEHIND });
    }
}

/// The part of an edge before the eye and inside the film's pyramid, if there is one: a line of a huge box has no more pixels than the film.
fn visible(lens: &Lens, a: [f64; 3], b: [f64; 3]) -> Option<[[f64; 3]; 2]> {
    let way = [0, 1, 2].map(|k| b[k] - a[k]);
    let [wide, high] = lens.tangents();
    let size = a.iter().chain(&b).fold(0.0f64, |m, c| m.max(c.abs()));
    let near = 1e-9 * size;
    // Each plane keeps where this is at least 0; it is linear along the edge.
    let planes = [
        |p: [f64; 3], _: f64, _: f64, near: f64| p[2] - near,
        |p: [f64; 3], wide: f64, _: f64, _: f64| wide * p[2] - p[0],
        |p: [f64; 3], wide: f64, _: f64, _: f64| wide * p[2] + p[0],
        |p: [f64; 3], _: f64, high: f64, _: f64| high * p[2] - p[1],
        |p: [f64; 3], _: f64, high: f64, _: f64| high * p[2] + p[1],
    ];
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for plane in planes {
        let (at_a, at_b) = (plane(a, wide, high, near), plane(b, wide, high, near));
        match (at_a >= 0.0, at_b >= 0.0) {
            (true, true) => {}
            (false, false) => return None,
            (true, false) => to = to.min(at_a / (at_a - at_b)),
            (false, true) => from = from.max(at_a / (at_a - at_b)),
        }
    }
    let at = |share: f64| [0, 1, 2].map(|k| a[k] + share * way[k]);
    let ends = [at(from), at(to)];
    (from < to && near > 0.0 && ends.iter().all(|p| p[2] > 0.0)).then_some(ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Executor, NoProgress, Preset};
    use crate::cache::Image;
    use crate::compile::compile;
    use crate::scene::{ReadOptions, read};
    use crate::trace::probe::Camera;

    fn sample(name: &str) -> Image {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(name);
        let scene = read(&path, &ReadOptions::default()).unwrap();
        let exec = Executor::sequential();
        let accel = compile(scene, &BuildOptions::preset(Preset::Draft), &exec, &NoProgress).unwrap();
        Image::new(&accel, &exec).unwrap()
    }

    #[test]
    fn levels_halve_the_scene_until_there_are_leaves_alone() {
        let image = sample("colonnade.obj");
        let view = image.view();
        let counts: Vec<usize> = [0, 1, 2, 64].map(|level| boxes(&view, level).unwrap().len()).into();
        let leaves = view.nodes.iter().enumerate().filter(|(i, n)| *i != 1 && n.is_leaf()).count();
        assert_eq!(counts, [1, 2, 4, leaves]);
        let root = view.nodes[0];
        assert_eq!(boxes(&view, 0).unwrap()[0][7], root.max.map(f64::from));
    }

    #[test]
    fn instances_are_where_they_stand() {
        let image = sample("forest.gltf");
        let view = image.view();
        assert_eq!(boxes(&view, 0).unwrap().len(), 1);
        let all = boxes(&view, 64).unwrap();
        let (min, max) = (view.tlas_nodes[0].min, view.tlas_nodes[0].max);
        let inside =
            |p: &[f64; 3]| (0..3).all(|k| p[k] >= f64::from(min[k]) - 1e-3 && p[k] <= f64::from(max[k]) + 1e-3);
        // A leaf's box, turned with its instance, may stick out of the box around what is in it; its middle does not.
        let middle = |c: &Corners| [0, 1, 2].map(|k| 0.5 * (c[0][k] + c[7][k]));
        assert!(all.len() > view.instances.len() && all.iter().all(|c| inside(&middle(c))));
    }

    #[test]
    fn lines_are_cut_off_at_the_film_and_at_the_eye() {
        let camera = Camera { eye: [0.0; 3], look_at: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], tan_half: 1.0 };
        let lens = Lens::new(&camera, 100, 50);
        let through = visible(&lens, [0.0, 0.0, -5.0], [0.0, 0.0, 5.0]).unwrap();
        assert!(through[0][2] > 0.0 && through[0][2] < 1e-4 && through[1][2] == 5.0, "{through:?}");
        let [a, b] = visible(&lens, [-1e9, 0.0, 10.0], [1e9, 0.0, 10.0]).unwrap();
        assert!((a[0] + 10.0).abs() < 1e-3 && (b[0] - 10.0).abs() < 1e-3, "{a:?} {b:?}");
        assert!(visible(&lens, [0.0, 30.0, 10.0], [0.0, 6.0, 10.0]).is_none());
        assert!(visible(&lens, [0.0, 0.0, -1.0], [5.0, 0.0, -2.0]).is_none());
    }
}
