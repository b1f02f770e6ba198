//! Faces of more than three corners.

use super::{corners, read, read_as};
use crate::scene::obj::polygon::LargeFaces;
use crate::scene::{ReadOptions, Scene, SceneError};

/// A polygon in the plane z = 0 as OBJ text.
fn polygon(points: &[[f32; 2]]) -> String {
    let mut text: String = points.iter().map(|p| format!("v {} {} 0\n", p[0], p[1])).collect();
    text += "f";
    (1..=points.len()).for_each(|i| text += &format!(" {i}"));
    text
}

/// Twice the signed area of each triangle in the plane z = 0.
fn areas(scene: &Scene) -> Vec<f64> {
    let area = |t: &[[f32; 3]; 3]| {
        let [a, b, c] = t.map(|p| p.map(f64::from));
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    corners(scene).iter().map(area).collect()
}

/// Every edge of a face is an edge of one of its triangles, in its direction, and every other edge is one of two triangles, once each way: also where
/// a triangle is seen from its edge in the plane in which the face was cut.
#[test]
fn triangles_wind_as_their_face_does() {
    let mut random = crate::random::Random::new(11);
    let mut grid = || [0; 3].map(|_| (random.unit() * 4.0).floor() as i32);
    let mut faces = vec![vec![[3, 0, 1], [2, 1, 3], [1, 1, 3], [0, 0, 0], [0, 2, 2]]];
    faces.extend((0..6000).map(|i| (0..5 + i % 3).map(|_| grid()).collect()));
    for face in faces {
        let mut text: String = face.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        text += "f";
        (1..=face.len()).for_each(|i| text += &format!(" {i}"));
        let points: Vec<[f32; 3]> = face.iter().map(|p| p.map(|c| c as f32)).collect();
        let distinct: std::collections::BTreeSet<_> = face.iter().collect();
        if distinct.len() < face.len() {
            continue; // edges between equal corners cannot be told apart
        }
        let scene = read(&text);
        let number = |p: [f32; 3]| points.iter().position(|q| *q == p).unwrap();
        let mut edges: Vec<(usize, usize)> = Vec::new();
        for t in corners(&scene) {
            let [a, b, c] = t.map(number);
            edges.extend([(a, b), (b, c), (c, a)]);
        }
        for i in 0..face.len() {
            let outer = (i, (i + 1) % face.len());
            assert!(edges.contains(&outer), "{text}: edge {outer:?} of {edges:?}");
        }
        let is_outer = |(a, b): (usize, usize)| b == (a + 1) % face.len();
        let lonely = edges.iter().find(|e| !is_outer(**e) && !edges.contains(&(e.1, e.0)));
        assert_eq!(lonely, None, "{text}: {edges:?}");
    }
}

#[test]
fn concave_quadrilaterals_are_cut_inside() {
    let arrow = [[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]];
    for turn in 0..4 {
        let mut points = arrow;
        points.rotate_left(turn);
        let areas = areas(&read(polygon(&points)));
        assert!(areas.len() == 2 && areas.iter().all(|a| *a > 0.0), "turned {turn}: {areas:?}");
        assert_eq!(areas.iter().sum::<f64>(), 1.0);
    }
}

#[test]
fn concave_polygons_are_cut_inside_and_keep_their_winding() {
    let comb: [[f32; 2]; 11] = [
        [0.0, 0.0],
        [10.0, 0.0],
        [10.0, 5.0],
        [8.0, 5.0],
        [8.0, 1.0],
        [6.0, 1.0],
        [6.0, 5.0],
        [4.0, 5.0],
        [4.0, 1.0],
        [2.0, 1.0],
        [0.0, 5.0],
    ];
    let area: f64 = 2.0 * (10.0 + 2.0 * 4.0 * 2.0 + 4.0);
    for reversed in [false, true] {
        let mut points = comb;
        if reversed {
            points.reverse();
        }
        let sign = if reversed { -1.0 } else { 1.0 };
        let areas = areas(&read(polygon(&points)));
        assert_eq!(areas.len(), 9);
        assert!(areas.iter().all(|a| a * sign > 0.0), "{areas:?}");
        assert!((areas.iter().sum::<f64>() * sign - area).abs() < 1e-9, "{areas:?}");
    }
}

#[test]
fn straight_corners_stay_corners() {
    // A square with three extra corners on its lower side and one on its upper: all six triangles have area.
    let points = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 4.0], [0.0, 4.0]];
    for turn in 0..8 {
        let mut points = points;
        points.rotate_left(turn);
        let scene = read(polygon(&points));
        let areas = areas(&scene);
        assert!(areas.len() == 6 && areas.iter().all(|a| *a > 0.0), "turned {turn}: {areas:?}");
        assert_eq!(areas.iter().sum::<f64>(), 32.0);
        assert_eq!(scene.report.degenerate_triangles, 0);
    }
}

#[test]
fn hopeless_polygons_become_fans() {
    let star = [[0.0, 3.0], [2.0, -3.0], [-3.0, 1.0], [3.0, 1.0], [-2.0, -3.0]]; // crosses itself
    let flat = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0], [0.5, 0.0], [0.25, 0.0]];
    assert_eq!(areas(&read(polygon(&star))).len(), 3);
    assert_eq!(areas(&read(polygon(&flat))).len(), 4);
    let with_nan = "v 0 0 0\nv 1 0 0\nv nan 1 0\nv 0 1 0\nv 0 .5 0\nf 1 2 3 4 5";
    assert_eq!(read(with_nan).report.non_finite_triangles, 2);
}

#[test]
fn polygons_are_cut_in_their_own_plane() {
    // An L standing on edge in a plane that no axis is square to.
    let l = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    let place = |p: &[f64; 2]| [p[0] * 0.6 + p[1] * 0.3, p[0] * 0.8 - p[1] * 0.2, p[1] * 0.9];
    let mut text: String =
        l.iter().map(|p| place(p).map(|c| c.to_string()).join(" ")).map(|p| format!("v {p}\n")).collect();
    text += "f 1 2 3 4 5 6";
    let area = |t: &[[f32; 3]; 3]| {
        let [a, b, c] = t.map(|p| p.map(f64::from));
        let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    };
    let normals: Vec<_> = corners(&read(text)).iter().map(area).collect();
    let sum = [0, 1, 2].map(|k| normals.iter().map(|n| n[k]).sum::<f64>());
    let length = |n: [f64; 3]| n.iter().map(|c| c * c).sum::<f64>().sqrt();
    let scattered: f64 = normals.iter().map(|n| length(*n)).sum();
    assert_eq!(normals.len(), 4);
    assert!((scattered - length(sum)).abs() < 1e-6, "a triangle is turned over: {normals:?}");
}

#[test]
fn hostile_polygons_end() {
    // Random zigzags cross themselves everywhere: the worst for ear clipping.
    let mut state = 7u32;
    let mut next = || {
        state = state.wrapping_mul(1664525).wrapping_add(1013904223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let points: Vec<[f32; 2]> = (0..2000).map(|_| [next(), next()]).collect();
    let started = std::time::Instant::now();
    assert_eq!(read(polygon(&points)).meshes[0].triangles.len(), 1998);
    println!("2,000 random corners: {:?}", started.elapsed());
}

/// Ear clipping takes cubic time on these: minutes for what is read at once as a fan.
#[test]
fn faces_that_wind_around_many_times_become_fans() {
    let wound = |points: usize, turns: usize, step: f64| {
        let mut text = String::new();
        let corners = points * turns;
        for i in 0..corners {
            // The same points over and over, or each a little further out.
            let (angle, radius) = ((i % points) as f64 / points as f64 * std::f64::consts::TAU, 1.0 + step * i as f64);
            text += &format!("v {} {} 0\n", radius * angle.cos(), radius * angle.sin());
        }
        let numbers: Vec<String> = (1..=corners).map(|n| n.to_string()).collect();
        text + "f " + &numbers.join(" ") + "\nf 1 2 3\n"
    };
    for text in [wound(3, 2000, 0.0), wound(7, 800, 0.0), wound(5, 1200, 1e-4)] {
        let mesh = &read(text).meshes[0];
        let corners: Vec<[u32; 3]> = mesh.triangles.iter().take(40).copied().collect();
        assert!(corners.iter().all(|t| t.contains(&corners[0][0])), "{corners:?}");
    }
}

#[test]
fn large_faces_share_an_allowance_and_small_ones_need_none() {
    let mut large = LargeFaces::default();
    assert!((0..1_000_000).all(|_| large.afford(1000)));
    assert!((0..256).all(|_| large.afford(1 << 14)));
    assert!(!large.afford(2000));
}

#[test]
fn faces_that_are_too_large_are_refused_with_their_line() {
    let line = |text: String| match read_as(text, &ReadOptions::default()) {
        Err(SceneError::TooMany { line, .. }) => line,
        other => panic!("{other:?}"),
    };
    let face = |corners: usize| format!("f{}\n", " 1".repeat(corners));
    assert_eq!(line(format!("v 0 0 0\n\n{}", face(16_385))), Some(3));
    assert_eq!(line(format!("v 0 0 0\nf 1 1 1\n{}", face(16_385))), Some(3), "where lines are read in one loop");
    // One face more than the allowance has room for.
    assert_eq!(line(format!("v 0 0 0\n{}", face(16_384).repeat(257))), Some(258));
}
