//! Statements of positions and faces.

use super::{TRIANGLE, corners, error, read, read_as};
use crate::scene::{Degenerate, ReadOptions};

#[test]
fn vertex_numbers_in_every_style() {
    let want = corners(&read(format!("{TRIANGLE}f 1 2 3\n")));
    for face in ["-3 -2 -1", "1/1 2/2 3/3", "1//1 2//1 3//1", "1/9/9 2/9/9 3/9/9", "01 +2 3/", "1 -2 3"] {
        assert_eq!(corners(&read(format!("{TRIANGLE}f {face}\n"))), want, "{face}");
    }
    assert_eq!(corners(&read(format!("{TRIANGLE}fo 1 2 3\nfo 1/1 2 3"))), [want[0], want[0]]);
    // A face may stand before its positions, as long as they come in the same group.
    assert_eq!(corners(&read(format!("f 1 2 3\n{TRIANGLE}"))), want);
}

#[test]
fn bad_vertex_numbers_are_named_with_their_line() {
    let line5 = |face: &str| error(format!("{TRIANGLE}# comment\nf {face}\n"));
    assert!(line5("1 2 0").starts_with("cannot read test.obj line 5: a face uses vertex 0;"));
    assert!(line5("1 2 4").contains("line 5: a face uses vertex 4, but there are 3"));
    assert!(line5("1 2 -4").contains("line 5: a face uses vertex -4, but there are only 3"));
    assert!(line5("1 2 x").contains("line 5: 'x' is not a vertex number"));
    assert!(line5("1 2 /3").contains("line 5: '' is not a vertex number"));
    for huge in ["9223372036854775807", "-9223372036854775808", "4294967297"] {
        assert!(line5(&format!("1 2 {huge}")).contains(&format!("vertex {huge}, but")), "{huge}");
    }
    assert!(line5("1 2 99999999999999999999").contains("not a vertex number"));
    let too_late = "g a\nf 1 2 3\nv 0 0 0\ng b\nf 1 1 1\nv 1 0 0\nv 0 1 0\n";
    assert!(error(too_late).contains("line 2: a face uses vertex 3"), "{}", error(too_late));
}

#[test]
fn bad_positions_are_named_with_their_line() {
    assert!(error("v 0 0\n").contains("line 1: a position has 2 coordinates; it needs 3"));
    assert!(error("\nv 0 zero 0\n").contains("line 2: 'zero' is not a number"));
    assert!(error("v 0 1,5 0\n").contains("'1,5' is not a number"));
    assert!(error(b"v 0 \xff 0\n").contains("is not a number"));
}

#[test]
fn weights_and_colours_are_ignored() {
    let scene = read("v 2 0 0 2\nv 1 0 0 0.5 0.25 nan\nv 0 1 0 1 1 1 1\nv 0 0 1 0\nf 1 2 3\nf 2 3 4");
    let [a, b, c, d] = [[2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(corners(&scene), [[a, b, c], [b, c, d]]);
}

#[test]
fn lines_points_and_short_faces_are_counted_not_read() {
    let scene = read(format!("{TRIANGLE}l 1 2 3\np 1 2\nf 1 2\nf 1\nf\nl 7 8 9\n"));
    assert_eq!((scene.meshes.len(), scene.instances.len()), (0, 0));
    let report = &scene.report;
    assert_eq!((report.skipped_primitives, report.short_faces, report.unreferenced_positions), (6, 3, 1));
}

#[test]
fn every_face_of_n_corners_is_n_minus_2_triangles_in_the_order_of_the_faces() {
    // Faces over random points and whole numbers: crossing, flat, with repeated corners, in every mixture.
    let mut state = 1u64;
    let mut next = |n: u64| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) % n
    };
    for round in 0..200u64 {
        let grid = [4, 1000][round as usize % 2];
        let mut text: String = (0..30)
            .map(|_| format!("v {} {} {}\n", next(grid), next(grid), next(if round % 3 == 0 { 1 } else { grid })))
            .collect();
        let (mut faces, mut first, mut all) = (Vec::new(), vec![0usize], Vec::new());
        for _ in 0..12 {
            let n = [3, 3, 4, 5, 7, 11, 2][next(7) as usize];
            let corners: Vec<u64> = (0..n).map(|_| next(30)).collect();
            text += &format!("g {}\nf", next(2));
            corners.iter().for_each(|c| text += &format!(" {}", c + 1));
            text += "\n";
            let start = all.len();
            all.extend_from_slice(&corners);
            if n > 2 {
                first.push(first[faces.len()] + corners.len() - 2);
                faces.push((start, corners));
            }
        }
        let points: Vec<[f32; 3]> = text
            .lines()
            .filter_map(|l| l.strip_prefix("v "))
            .map(|l| {
                let c: Vec<f32> = l.split(' ').map(|c| c.parse().unwrap()).collect();
                [c[0], c[1], c[2]]
            })
            .collect();
        for degenerate in [Degenerate::Keep, Degenerate::Drop] {
            let scene = read_as(&text, &ReadOptions { degenerate, vertices: true, ..ReadOptions::default() }).unwrap();
            let Some(mesh) = scene.meshes.first() else { continue };
            assert!(degenerate == Degenerate::Drop || mesh.triangles.len() == *first.last().unwrap(), "{text}");
            let bounds = mesh.parts.last().map(|p| (p.first_prim + p.prim_count) as usize);
            assert_eq!(bounds, first.last().copied(), "{text}");
            for i in 0..mesh.triangles.len() {
                let prim = mesh.source_prim(i) as usize;
                let (start, face) = &faces[first.partition_point(|f| *f <= prim) - 1];
                let of_face = |p: &[f32; 3]| face.iter().any(|c| points[*c as usize] == *p);
                assert!(mesh.corners(i).iter().all(of_face), "triangle {prim} is not of its face\n{text}");
                let numbers = mesh.vertices[i].map(|n| n as usize);
                assert!(numbers.iter().all(|n| (*start..start + face.len()).contains(n)), "{numbers:?}\n{text}");
                assert_eq!(numbers.map(|n| points[all[n] as usize]), mesh.corners(i), "{text}");
            }
        }
    }
}

#[test]
fn old_spellings_of_nan_are_nan() {
    for nan in ["nan", "NaN", "inf", "-Infinity", "1.#IND", "-1.#QNAN0", "1.#INF", "-nan(ind)"] {
        let scene = read(format!("{TRIANGLE}v 0 {nan} 0\nf 1 2 3\nf 1 2 4\n"));
        assert_eq!((scene.report.non_finite_triangles, scene.meshes[0].triangles.len()), (1, 1), "{nan}");
    }
    for none in ["5#foo", "0#", "(5", "abc(", "nan(", "1.#", "2.#INF"] {
        let text = format!("{TRIANGLE}v 0 {none} 0\nf 1 2 3\nf 1 2 4\n");
        let said = error(text);
        assert!(said.contains(&format!("'{none}' is not a number")), "{none}: {said}");
    }
}

#[test]
fn numbers_beyond_the_range_are_told_from_what_is_no_number() {
    let report = |corner: &str, policy| {
        let text = format!("{TRIANGLE}v {corner}\nf 1 2 3\nf 1 2 4\n");
        read_as(text, &ReadOptions { degenerate: policy, ..ReadOptions::default() }).map(|scene| scene.report)
    };
    for (corner, beyond, no_number, largest) in [
        ("1e39 0 1", 1, 0, 1e39),
        ("0 -3.5e38 1e38", 1, 0, 3.5e38),
        ("0 1e400 0", 1, 0, f64::INFINITY),
        ("0 inf 0", 0, 1, 0.0),
        ("0 -Infinity 0", 0, 1, 0.0),
        ("0 1.#INF 0", 0, 1, 0.0),
        ("1e39 nan 0", 0, 1, 0.0),
        ("0 3.4e38 0", 0, 0, 0.0),
    ] {
        let report = report(corner, Degenerate::Drop).unwrap();
        let found = (report.out_of_range_triangles, report.non_finite_triangles, report.largest_magnitude);
        assert_eq!(found, (beyond, no_number, largest), "{corner}");
    }
    let refused = report("1e39 0 1", Degenerate::Error).unwrap_err().to_string();
    assert!(refused.contains("0 with NaN or infinite positions and 1 with positions beyond the range"), "{refused}");
}
