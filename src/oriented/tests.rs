use super::*;
use crate::geom::Aabb;
use crate::geom::vector::{cross, dot};
use crate::random::Random;
use proptest::prelude::*;

/// Whether `a·p ≥ d` by exact arithmetic (Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997).
fn reaches(axis: [f64; 3], p: [f64; 3], d: f64) -> bool {
    let mut sum: Vec<f64> = Vec::new();
    let mut add = |mut term: f64| {
        for part in &mut sum {
            let total = *part + term;
            let of_part = total - term;
            (term, *part) = (total, (*part - of_part) + (term - (total - of_part)));
        }
        sum.push(term);
    };
    for k in 0..3 {
        let product = axis[k] * p[k];
        add(axis[k].mul_add(p[k], -product));
        add(product);
    }
    add(-d);
    sum.iter().rev().find(|part| **part != 0.0).is_none_or(|part| *part > 0.0)
}

fn is_inside(b: &OrientedBox, p: [f64; 3]) -> bool {
    (0..3).all(|k| {
        let axis = b.basis.axes()[k];
        reaches(axis, p, b.low[k]) && reaches(axis.map(|c| -c), p, -b.high[k])
    })
}

/// Flat and slanted, far from the origin or around it, of any size; whole `f32`, as corners of triangles are.
fn cloud(seed: u64, count: usize, size: f64, offset: f64, flat: f64) -> Vec<[f64; 3]> {
    let mut random = Random::new(seed);
    let basis = Basis::along(random.direction(), random.direction());
    let at = random.direction().map(|c| c * offset);
    let mut point = || {
        let c = [1.0, 0.5, flat].map(|extent| (2.0 * random.unit() - 1.0) * extent * size);
        let p = basis.point(c);
        [0, 1, 2].map(|k| f64::from((p[k] + at[k]) as f32))
    };
    (0..count).map(|_| point()).collect()
}

fn is_rotation(basis: &Basis) -> bool {
    let axes = basis.axes();
    let product = |i: usize, j: usize| (dot(axes[i], axes[j]) - if i == j { 1.0 } else { 0.0 }).abs();
    let handed = dot(cross(axes[0], axes[1]), axes[2]);
    (0..9).all(|k| product(k / 3, k % 3) <= Basis::ERROR) && (handed - 1.0).abs() < 1e-14
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn bounds_hold_their_points_to_the_last_bit(
        seed in any::<u64>(),
        count in 1usize..40,
        size in prop::sample::select(vec![1e-44, 1e-20, 1e-3, 1.0, 1e12, 1e37]),
        offset in prop::sample::select(vec![0.0, 1.0, 1e6, 1e37]),
        flat in prop::sample::select(vec![0.0, 1e-6, 0.25]),
    ) {
        let points = cloud(seed, count, size, offset, flat);
        let fitted = OrientedBox::of_points(&points).unwrap();
        prop_assert!(points.iter().all(|p| is_inside(&fitted, *p)));
        prop_assert!(is_rotation(&fitted.basis));

        // Merged again and again, each time in the basis of one of both.
        let mut random = Random::new(seed ^ 1);
        let parts = points.chunks(3).map(|part| {
            OrientedBox::in_basis(Basis::along(random.direction(), random.direction()), part).unwrap()
        });
        let merged = parts.reduce(|a, b| a.merged(&b)).unwrap();
        prop_assert!(points.iter().all(|p| is_inside(&merged, *p)));
        let around = OrientedBox::around(Basis::along(random.direction(), random.direction()), [merged, fitted]).unwrap();
        prop_assert!(points.iter().all(|p| is_inside(&around, *p)));

        let dop = Dop14::of_points(&points).unwrap();
        let in_dop = |p: [f64; 3]| (0..7).all(|k| {
            let axis = DIRECTIONS[k];
            reaches(axis, p, dop.low[k]) && reaches(axis.map(|c| -c), p, -dop.high[k])
        });
        prop_assert!(points.iter().all(|p| in_dop(*p)));
        let aabb = Aabb::of_points(&points).unwrap();
        prop_assert!(points.iter().all(|p| aabb.contains(&Aabb::from_points(&[p.map(|c| c as f32)]))));
    }

    #[test]
    fn merged_bounds_are_those_of_all_points_where_directions_are_fixed(seed in any::<u64>(), count in 2usize..60) {
        let points = cloud(seed, count, 3.0, 1.0, 0.5);
        let (a, b) = points.split_at(count / 2);
        let whole = Aabb::of_points(&points).unwrap();
        prop_assert_eq!(Aabb::of_points(a).unwrap().merged(&Aabb::of_points(b).unwrap()), whole);
        let dop = Dop14::of_points(&points).unwrap();
        let merged = Dop14::of_points(a).unwrap().merged(&Dop14::of_points(b).unwrap());
        prop_assert!((0..7).all(|k| (merged.low[k] - dop.low[k]).abs() < 1e-12 && (merged.high[k] - dop.high[k]).abs() < 1e-12));
        // No convex shape has less surface than one inside of it, such as a triangle with both its sides.
        let inside = points.windows(3).map(|p| Moments::of_triangle(&[p[0], p[1], p[2]]).area()).fold(0.0, f64::max);
        let area = dop.area();
        prop_assert!((2.0 * inside..=1.00001 * whole.area()).contains(&area), "{} {} {}", inside, area, whole.area());
    }

    #[test]
    fn any_two_directions_give_a_rotation(x in prop::array::uniform3(-1.0f64..1.0), y in prop::array::uniform3(-1.0f64..1.0), near in 0usize..4) {
        let scale = [1.0, 1e-6, 1e-11, 0.0][near];
        let lean = [0, 1, 2].map(|k| x[k] + scale * y[k]);
        prop_assert!(is_rotation(&Basis::along(x, lean)));
        let basis = Basis::along(x, y);
        let back = basis.coordinates(basis.point(y));
        prop_assert!((0..3).all(|k| (back[k] - y[k]).abs() < 1e-14));
    }
}

#[test]
fn what_says_no_direction_still_gives_a_rotation() {
    let p = [3.0, -1.0, 2.0];
    for corners in [[p, p, p], [p, p, [4.0, -1.0, 2.0]], [[0.0; 3], [1e-45, 0.0, 0.0], [0.0, 1e-45, 0.0]]] {
        assert!(is_rotation(&Basis::of_triangle(&corners)));
    }
    assert_eq!(Basis::along([0.0; 3], p), Basis::AXES);
    assert_eq!(Basis::along([f64::NAN, 0.0, 0.0], p), Basis::AXES);
}

#[test]
fn a_triangle_lies_flat_in_its_basis() {
    let corners = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [0.0, 2.0, 2.0]];
    let basis = Basis::of_triangle(&corners);
    let along = basis.axes()[0];
    assert!((0..3).all(|k| (along[k] - [0.6, 0.8, 0.0][k]).abs() < 1e-15), "{along:?}");
    let b = OrientedBox::in_basis(basis, &corners).unwrap();
    assert!(b.high[2] - b.low[2] < 1e-13);
    // Twice the triangle, on either side.
    assert!((b.area() - 4.0 * Moments::of_triangle(&corners).area()).abs() < 1e-9, "{}", b.area());
}

#[test]
fn the_area_of_slabs_is_that_of_the_shape() {
    let cube: Vec<[f64; 3]> = (0..8).map(|i| [0, 1, 2].map(|k| f64::from(i >> k & 1))).collect();
    assert!((Dop14::of_points(&cube).unwrap().area() - 6.0).abs() < 1e-9);
    // An octahedron: eight equilateral triangles of edge √2.
    let octahedron: Vec<[f64; 3]> =
        (0..6).map(|i| std::array::from_fn(|k| if i / 2 == k { (2 * (i % 2)) as f64 - 1.0 } else { 0.0 })).collect();
    let area = Dop14::of_points(&octahedron).unwrap().area();
    assert!((area - 4.0 * 3f64.sqrt()).abs() < 1e-9, "{area}");
    assert_eq!(Dop14::of_points(&[[1.0, 2.0, 3.0]]).unwrap().area(), 0.0);
    // A square, in a plane along the axes and in none.
    let square = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [1.0, 1.0, 5.0], [0.0, 1.0, 5.0]];
    assert!((Dop14::of_points(&square).unwrap().area() - 2.0).abs() < 1e-9);
    assert!(Dop14::of_points(&[]).is_none() && OrientedBox::of_points(&[]).is_none() && Aabb::of_points(&[]).is_none());
}

#[test]
fn axes_of_spread_are_found_and_long_triangles_weigh_by_area() {
    let basis = Basis::along([1.0, 2.0, -0.5], [0.3, 0.1, 1.0]);
    let rectangle = [[-4.0, -1.0], [4.0, -1.0], [4.0, 1.0], [-4.0, 1.0]].map(|[x, y]| basis.point([x, y, 0.5]));
    let [a, b, c, d] = rectangle;
    let mut moments = Moments::of_triangle(&[a, b, c]).plus(&Moments::of_triangle(&[a, c, d]));
    let found = moments.basis().unwrap();
    for k in 0..3 {
        let along = dot(found.axes()[k], basis.axes()[k]).abs();
        assert!(along > 1.0 - 1e-12, "axis {k}: {along}");
    }
    // A thousand specks in a row weigh nothing beside it.
    for i in 0..1000 {
        let at = [0.0, 0.0, f64::from(i) * 0.01];
        moments = moments.plus(&Moments::of_triangle(&[at, [1e-6, 0.0, at[2]], [0.0, 1e-6, at[2]]]));
    }
    let found = moments.basis().unwrap();
    assert!(dot(found.axes()[0], basis.axes()[0]).abs() > 1.0 - 1e-6);
    assert!(Moments::default().basis().is_none());
}

/// The least box of very many rotations, then of smaller and smaller turns of the best.
fn by_brute_force(points: &[[f64; 3]]) -> f64 {
    let mut random = Random::new(3);
    let of = |basis: Basis| OrientedBox::in_basis(basis, points).unwrap();
    let mut best = of(Basis::AXES);
    let mut turn = |near: Option<(Basis, f64)>| {
        let free = Basis::along(random.direction(), random.direction());
        let Some((basis, step)) = near else { return free };
        let nudged = |k: usize| [0, 1, 2].map(|a| basis.axes()[k][a] + step * free.axes()[k][a]);
        Basis::along(nudged(0), nudged(1))
    };
    for i in 0..6000 {
        let near = (i >= 3000).then(|| (best.basis, 0.3 * 0.998f64.powi(i - 3000)));
        let found = of(turn(near));
        if found.half_area() < best.half_area() {
            best = found;
        }
    }
    best.area()
}

#[test]
fn fitted_boxes_are_near_the_least_of_thousands_of_rotations() {
    let (mut over, mut facets_over, mut axes_over) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..24 {
        let flat = [0.01, 0.1, 0.4][seed as usize % 3];
        let points = cloud(seed, 30, 1.0, 0.0, flat);
        let least_area = by_brute_force(&points);
        over.push(OrientedBox::of_points(&points).unwrap().area() / least_area);
        let facets = least(hull_facets(&Extremes::of_points(&points).unwrap().points()), |basis| {
            OrientedBox::in_basis(basis, &points)
        });
        facets_over.push(facets.unwrap().area() / least_area);
        axes_over.push(Aabb::of_points(&points).unwrap().area() / least_area);
    }
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let most = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
    println!("DiTO-14: {:.3}, at most {:.3}", mean(&over), most(&over));
    println!("facets: {:.3}, at most {:.3}", mean(&facets_over), most(&facets_over));
    println!("axes: {:.3}, at most {:.3}", mean(&axes_over), most(&axes_over));
    assert!(mean(&over) < 1.15 && most(&over) < 1.4);
    assert!(mean(&facets_over) < 1.15 && most(&facets_over) < 1.4);
    assert!(mean(&axes_over) > 1.3, "the clouds lie aslant");
    // Brute force has not missed much itself.
    assert!(over.iter().all(|o| *o > 0.97));
}

#[test]
fn a_slanted_brick_is_found_exactly_by_its_facets() {
    let basis = Basis::along([1.0, 2.0, 3.0], [-1.0, 0.5, 0.2]);
    let brick: Vec<[f64; 3]> =
        (0..8).map(|i| basis.point([0, 1, 2].map(|k| f64::from(i >> k & 1) * [3.0, 2.0, 1.0][k]))).collect();
    let found = least(hull_facets(&brick), |basis| OrientedBox::in_basis(basis, &brick)).unwrap();
    assert!((found.area() - 22.0).abs() < 1e-9, "{}", found.area());
    let corners = found.corners();
    assert!(brick.iter().all(|p| corners.iter().any(|c| (0..3).all(|k| (c[k] - p[k]).abs() < 1e-9))));
}

#[test]
fn of_two_boxes_the_lesser_basis_is_taken_and_its_area_foretold() {
    let plank = |basis: Basis, x: f64| {
        let points: Vec<[f64; 3]> =
            (0..8).map(|i| basis.point([0, 1, 2].map(|k| x + f64::from(i >> k & 1) * [4.0, 1.0, 0.1][k]))).collect();
        OrientedBox::in_basis(basis, &points).unwrap()
    };
    let (long, small) = (plank(Basis::along([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]), 0.0), plank(Basis::AXES, 0.5));
    for (a, b) in [(long, small), (small, long)] {
        let (half, in_b) = a.merged_half_area(&b);
        let merged = a.merged(&b);
        assert!((merged.half_area() - half).abs() < 1e-9);
        assert_eq!(merged.basis, if in_b { b.basis } else { a.basis });
        assert!(half <= OrientedBox::around(a.basis, [a, b]).unwrap().half_area() + 1e-9);
        assert!(half <= OrientedBox::around(b.basis, [a, b]).unwrap().half_area() + 1e-9);
    }
}

#[test]
fn a_box_costs_what_its_kind_costs() {
    let points = cloud(1, 30, 1.0, 0.0, 0.01);
    let (aabb, turned) = (Aabb::of_points(&points).unwrap(), OrientedBox::of_points(&points).unwrap());
    assert_eq!(aabb.cost(), 24.0 * aabb.area());
    assert_eq!(turned.cost(), 57.0 * turned.area());
}
