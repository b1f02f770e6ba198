//! Coordinates that `f32` cannot hold.

use super::{read, read_as};
use crate::scene::ReadOptions;

#[test]
fn map_coordinates_keep_their_shape() {
    // A patch of 2 m in metres of UTM, with digits that f32 has not.
    let at = |i: u32, j: u32| {
        [500_123.26 + 0.1 * f64::from(i), 102.5 + 0.01 * f64::from(i * j % 7), -4_649_776.77 + 0.1 * f64::from(j)]
    };
    let mut text = String::new();
    for (i, j) in (0..=20).flat_map(|i| (0..=20).map(move |j| (i, j))) {
        let [x, y, z] = at(i, j);
        text += &format!("v {x:.4} {y:.4} {z:.4}\n");
    }
    for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
        let a = 1 + i * 21 + j;
        text += &format!("f {a} {} {} {}\n", a + 1, a + 22, a + 21);
    }
    let scene = read_as(&text, &ReadOptions::default()).unwrap();
    let (mesh, place) = (&scene.meshes[0], &scene.instances[0].transform);
    assert_eq!((mesh.triangles.len(), scene.report.degenerate_triangles), (800, 0));
    assert_eq!(*place, crate::geom::Affine::translation([500_124.0, 102.0, -4_649_776.0]));
    for p in &mesh.positions {
        let got = place.transform_point(p.map(f64::from));
        let cell = |v: f64, from: f64| ((v - from) / 0.1).round() as u32;
        let want = at(cell(got[0], 500_123.26), cell(got[2], -4_649_776.77));
        assert!((0..3).all(|a| (want[a] - got[a]).abs() < 6e-5), "{want:?} {got:?}");
    }
    assert!(scene.rounding.loss.is_tolerable() && scene.rounding.rounded_before.is_none(), "{:?}", scene.rounding);

    // The same after it went through f32: nothing brings the shape back, and the reader knows.
    let rounded: String = text
        .lines()
        .map(|l| match l.strip_prefix("v ") {
            Some(v) => format!(
                "v {}\n",
                v.split(' ').map(|c| format!("{:.4}", c.parse::<f32>().unwrap())).collect::<Vec<_>>().join(" ")
            ),
            None => format!("{l}\n"),
        })
        .collect();
    assert_eq!(read(&rounded).rounding.rounded_before, Some(0.5));

    // Whole numbers are as exact far away as near: nothing is lost, and nothing is done.
    let scene = read("v 4649776 0 0\nv 4649777 0 0\nv 4649776 1 0\nf 1 2 3\n");
    assert_eq!(scene.instances[0].transform, crate::geom::Affine::IDENTITY);
    assert_eq!(scene.rounding.loss.farthest, 0.0);
}

#[test]
fn what_no_origin_helps_is_told() {
    // Two patches a thousand kilometres apart, of triangles of a centimetre.
    let mut text = String::new();
    for x in [0.0, 1e6] {
        (0..30).for_each(|i| text += &format!("v {:.4} 0 0\nv {0:.4} 0.01 0\n", x + 0.0103 * f64::from(i)));
    }
    for first in [1, 61] {
        (0..29).map(|i| first + 2 * i).for_each(|a| text += &format!("f {a} {} {}\n", a + 1, a + 2));
    }
    let scene = read(&text);
    assert!(!scene.rounding.loss.is_tolerable(), "{:?}", scene.rounding);
    assert!((0.01..0.04).contains(&scene.rounding.loss.farthest));
}
