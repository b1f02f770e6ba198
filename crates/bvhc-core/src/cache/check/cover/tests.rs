use super::*;
use crate::random::Random;

const TRIANGLE: [Point; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

fn look(corners: [Point; 3], boxes: &[Aabb]) -> Covered {
    Cover::default().look(corners, boxes)
}

fn flat(min: [f32; 2], max: [f32; 2]) -> Aabb {
    Aabb { min: [min[0], min[1], 0.0], max: [max[0], max[1], 0.0] }
}

/// The point of the hole that was found.
fn hole(corners: [Point; 3], boxes: &[Aabb]) -> [f64; 3] {
    match look(corners, boxes) {
        Covered::Hole(point) => point,
        other => panic!("{other:?}"),
    }
}

#[test]
fn two_halves_cover_and_a_hair_between_them_does_not() {
    let halves = |from| [flat([0.0, 0.0], [1.0, 4.0]), flat([from, 0.0], [4.0, 3.0])];
    assert_eq!(look(TRIANGLE, &halves(1.0)), Covered::Whole);
    let point = hole(TRIANGLE, &halves(1.0f32.next_up()));
    assert!(1.0 < point[0] && point[0] < 1.0f32.next_up().into(), "{point:?}");
}

#[test]
fn a_missing_corner_and_a_low_clip_are_found() {
    let boxes = |x, y| [flat([0.0, 0.0], [1.0, 4.0]), flat([1.0, 0.0], [x, y])];
    assert!(hole(TRIANGLE, &boxes(3.5, 3.0))[0] > 3.5);
    assert!(hole(TRIANGLE, &boxes(4.0f32.next_down(), 3.0))[0] > 3.9);
    // The upper edge leaves the left box at x = 1 with y = 3, but the right box ends a step below.
    assert!(hole(TRIANGLE, &boxes(4.0, 3.0f32.next_down()))[1] > 2.9);
}

/// Four boxes cover the triangle's edges, its corners and its middle, but not a square inside.
#[test]
fn a_square_inside_is_found_however_small() {
    for side in [0.5, 1e-3, f32::EPSILON] {
        let (low, high) = (0.5f32, 0.5 + side);
        let ring = [
            flat([0.0, 0.0], [low, 4.0]),
            flat([high, 0.0], [4.0, 3.5]),
            flat([low, 0.0], [high, low]),
            flat([low, high], [high, 4.0]),
        ];
        let point = hole(TRIANGLE, &ring);
        assert!((0..2).all(|k| f64::from(low) < point[k] && point[k] < f64::from(high)), "{point:?} for {side}");
        let closed = [ring[0], ring[1], ring[2], ring[3], flat([low, low], [high, high])];
        assert_eq!(look(TRIANGLE, &closed), Covered::Whole);
    }
}

/// Borders do not count: a box that only touches the triangle covers nothing of it, and none of its planes need be cut at.
#[test]
fn boxes_that_touch_are_left_out() {
    let beside = Aabb { min: [0.0, 0.0, -1.0], max: [4.0, 4.0, 0.0] };
    assert_eq!(look(TRIANGLE, &[beside]), Covered::Whole, "the triangle lies in this box's upper side");
    let left = Aabb { min: [-1.0, 0.0, -1.0], max: [0.0, 4.0, 1.0] };
    assert!(matches!(look(TRIANGLE, &[left]), Covered::Hole(_)));
    assert!(matches!(look(TRIANGLE, &[]), Covered::Hole(_)));
}

#[test]
fn triangles_without_area_are_covered_along_their_length() {
    let line = [[0.0, 0.0, 0.0], [3.0, 6.0, 1.5], [1.0, 2.0, 0.5]];
    let piece = |low: f32, high: f32| Aabb { min: [low, 2.0 * low, 0.5 * low], max: [high, 2.0 * high, 0.5 * high] };
    assert_eq!(look(line, &[piece(0.0, 1.25), piece(1.25, 3.0)]), Covered::Whole);
    assert!((hole(line, &[piece(0.0, 1.0), piece(1.25, 3.0)])[0] - 1.125).abs() < 0.2);
    assert!(hole(line, &[piece(0.0, 1.25), piece(1.25, 2.5)])[0] > 2.5);
    let point = [[1.0, 2.0, 3.0]; 3];
    let at = |v: Point| Aabb { min: v, max: v };
    assert_eq!(look(point, &[at([0.0; 3]), at([1.0, 2.0, 3.0])]), Covered::Whole);
    assert!(matches!(look(point, &[at([0.0; 3])]), Covered::Hole(_)));
}

/// Boxes of a triangle that was cut at random planes as a tree does it, each box the very bounds of its part rounded outward.
fn cut_at_random(corners: [Point; 3], leaves: usize, random: &mut Random) -> Vec<Aabb> {
    let mut boxes = vec![Aabb::from_points(&corners)];
    while boxes.len() < leaves {
        let i = (random.unit() * boxes.len() as f64) as usize;
        let b = boxes[i];
        let axis = (0..3).max_by(|a, c| b.extent()[*a].total_cmp(&b.extent()[*c])).unwrap_or(0);
        let plane = b.min[axis] + (b.max[axis] - b.min[axis]) * (0.2 + 0.6 * random.unit() as f32);
        let (below, above) = crate::geom::clip::split(&corners, axis, plane, &b);
        boxes[i] = below;
        boxes.push(above);
        boxes.retain(|b| !b.is_empty());
    }
    boxes
}

fn random_triangle(random: &mut Random, scale: f64) -> [Point; 3] {
    [0; 3].map(|_| [0; 3].map(|_| ((random.unit() - 0.5) * scale) as f32))
}

/// What the clipper makes covers the triangle, with nothing added; and without any one box, or with one a step smaller on a side that the
/// triangle crosses, it does not.
#[test]
fn clipped_parts_cover_and_each_is_needed() {
    let mut random = Random::new(5);
    let mut found = 0;
    for round in 0..600 {
        let scale = [1.0, 1e-20, 1e7, 1e20][round % 4];
        let mut corners = random_triangle(&mut random, scale);
        if round % 3 == 0 {
            corners[2] = [0, 1, 2].map(|k| corners[0][k] + (corners[1][k] - corners[0][k]) * 0.3 + scale as f32 * 1e-4);
        }
        let boxes = cut_at_random(corners, 2 + round % 30, &mut random);
        let mut cover = Cover::default();
        assert_eq!(cover.look(corners, &boxes), Covered::Whole, "{corners:?} {boxes:?}");
        assert!(cover.steps() < 40 * boxes.len() as u64, "{} steps for {} leaves", cover.steps(), boxes.len());
        let without = (round / 7) % boxes.len();
        let mut fewer = boxes.clone();
        fewer.remove(without);
        found += usize::from(matches!(cover.look(corners, &fewer), Covered::Hole(_)));
    }
    // A sliver's neighbours may cover a part of it by their rounding.
    assert!(found > 550, "{found}");
}

/// By a grid of points: where the answer is a hole its point lies in none of the boxes, and where it is none all points lie in one.
#[test]
fn random_boxes_agree_with_points() {
    let mut random = Random::new(9);
    let (mut covered, mut open) = (0, 0);
    for _ in 0..3000 {
        // Coarse numbers, so that planes, corners and borders often meet.
        let corners = [0; 3].map(|_| [0; 3].map(|_| (random.unit() * 5.0).floor() as f32));
        let count = 1 + (random.unit() * 9.0) as usize;
        let boxes: Vec<Aabb> = (0..count)
            .map(|_| {
                let [a, b] = [0; 2].map(|_| [0; 3].map(|_| (random.unit() * 9.0 - 2.0).floor() as f32));
                Aabb::from_points(&[a, b])
            })
            .collect();
        let inside = |p: [f64; 3]| {
            boxes.iter().any(|b| (0..3).all(|k| f64::from(b.min[k]) <= p[k] && p[k] <= f64::from(b.max[k])))
        };
        match look(corners, &boxes) {
            Covered::Whole => {
                covered += 1;
                let [a, b, c] = corners.map(|p| p.map(f64::from));
                for (i, j) in (0..=24).flat_map(|i| (0..=24 - i).map(move |j| (i, j))) {
                    // Multiples of 1/24 of differences up to 4 are not exact: stay on the side of boxes that are closed.
                    let p = [0, 1, 2].map(|k| {
                        let v = a[k] * 24.0 + (b[k] - a[k]) * f64::from(i) + (c[k] - a[k]) * f64::from(j);
                        v / 24.0
                    });
                    let near = |v: f64| if (v - v.round()).abs() < 1e-9 { v.round() } else { v };
                    assert!(inside(p.map(near)), "{corners:?} {boxes:?} {p:?}");
                }
            }
            Covered::Hole(p) => {
                open += 1;
                assert!(
                    !inside(p) || corners.iter().flatten().all(|c| *c == corners[0][0]),
                    "{corners:?} {boxes:?} {p:?}"
                );
            }
            Covered::Unknown => panic!("few boxes are always decided"),
        }
    }
    assert!(covered > 100 && open > 1000, "{covered} {open}");
}

/// A floor in a grid of leaves: work grows with the leaves, and with little more.
#[test]
fn many_leaves_take_few_steps_each() {
    let big = [[0.0, 0.0, 0.0], [1024.0, 0.0, 0.0], [0.0, 1024.0, 0.0]];
    for n in [16u16, 64] {
        let side = 1024.0 / f32::from(n);
        let cells = (0..n).flat_map(|x| (0..n).map(move |y| (f32::from(x) * side, f32::from(y) * side)));
        let boxes: Vec<Aabb> = cells.map(|(x, y)| flat([x, y], [x + side, y + side])).collect();
        let mut cover = Cover::default();
        assert_eq!(cover.look(big, &boxes), Covered::Whole);
        assert!(cover.steps() < 64 * boxes.len() as u64, "{} steps for {} leaves", cover.steps(), boxes.len());
        assert!(matches!(cover.look(big, &boxes[..boxes.len() / 3]), Covered::Hole(_)));
    }
}

/// In the plane x + y + z = n strips of three directions, n of each, with gaps that no point is in three times: they cover the triangle, but by
/// about n² crossings of two gaps, each of which the third direction must be looked at for.
fn strips(n: u16) -> ([Point; 3], Vec<Aabb>) {
    let side = f32::from(n);
    let corners = [[side, 0.0, 0.0], [0.0, side, 0.0], [0.0, 0.0, side]];
    let strip = |axis: usize, i: u16| {
        let mut b = Aabb { min: [0.0; 3], max: [side; 3] };
        (b.min[axis], b.max[axis]) = (f32::from(i) + 0.0625, f32::from(i) + 1.0);
        b
    };
    (corners, (0..3).flat_map(|axis| (0..n).map(move |i| strip(axis, i))).collect())
}

/// The kind of leaves for which no quick way is known: with few of them the answer is found, with many the bound comes first.
#[test]
fn hostile_leaves_end_at_the_bound() {
    let (corners, boxes) = strips(16);
    assert_eq!(look(corners, &boxes), Covered::Whole);
    let (corners, boxes) = strips(3000);
    let mut cover = Cover::default();
    assert_eq!(cover.look(corners, &boxes), Covered::Unknown);
    assert!(cover.steps() <= most_steps(boxes.len()) + boxes.len() as u64 + 1, "{}", cover.steps());
}
