use crate::scene::{Degenerate, ErrorKind, Format, ReadOptions, Scene, SceneError, read_bytes};

fn read_as(text: impl AsRef<[u8]>, options: &ReadOptions) -> Result<Scene, SceneError> {
    read_bytes(text.as_ref().to_vec(), "test.obj", Some(Format::Obj), None, options)
}

/// With degenerate triangles kept.
fn read(text: impl AsRef<[u8]>) -> Scene {
    read_as(text, &ReadOptions { degenerate: Degenerate::Keep, ..ReadOptions::default() }).unwrap()
}

fn error(text: impl AsRef<[u8]>) -> String {
    let error = read_as(text, &ReadOptions::default()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::BadModel);
    error.to_string()
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// The corners of all triangles.
fn corners(scene: &Scene) -> Vec<[[f32; 3]; 3]> {
    let mesh = &scene.meshes[0];
    (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect()
}

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

#[test]
fn a_triangle() {
    let scene = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3");
    assert_eq!(corners(&scene), [[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    assert_eq!((scene.instances.len(), scene.meshes[0].name.as_str()), (1, "test"));
    assert_eq!(scene.report, Default::default());
    assert_eq!((scene.inputs[0].name.as_str(), scene.inputs[0].len), ("test.obj", 31));
    assert_eq!(scene.inputs[0].blake3, *blake3::hash(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").as_bytes());
}

#[test]
fn line_ends_continuations_and_odd_spaces() {
    let want = corners(&read(format!("{TRIANGLE}f 1 2 3\n")));
    let crlf = format!("{TRIANGLE}f 1 2 3\n").replace('\n', "\r\n");
    let cr_only = crlf.replace("\r\n", "\r");
    let tabs = "\u{feff}  v\t0  0 0 \n\n v 1 0 0\nv 0 1 0\t\n\tf  1\t2 3  # the end";
    let joined = "v 0 \\\n0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\r\n2 \\\n 3\\";
    let comments = "# C:\\folder\\\nv 0 0 0 # first\nv 1 0 0\nv 0 1 0\ng a\\\nf 1 2 3";
    let latin1 = b"o caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\n# \xff\nf 1 2 3".as_slice();
    for text in [crlf.as_bytes(), cr_only.as_bytes(), tabs.as_bytes(), joined.as_bytes(), comments.as_bytes(), latin1] {
        assert_eq!(corners(&read(text)), want, "{}", String::from_utf8_lossy(text));
    }
}

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
    assert!(line5("1 2 0").starts_with("cannot read test.obj line 5\n  a face uses vertex 0;"));
    assert!(line5("1 2 4").contains("line 5\n  a face uses vertex 4, but there are 3"));
    assert!(line5("1 2 -4").contains("line 5\n  a face uses vertex -4, but there are only 3"));
    assert!(line5("1 2 x").contains("line 5\n  'x' is not a vertex number"));
    assert!(line5("1 2 /3").contains("line 5\n  '' is not a vertex number"));
    for huge in ["9223372036854775807", "-9223372036854775808", "4294967297"] {
        assert!(line5(&format!("1 2 {huge}")).contains(&format!("vertex {huge}, but")), "{huge}");
    }
    assert!(line5("1 2 99999999999999999999").contains("not a vertex number"));
    let too_late = "g a\nf 1 2 3\nv 0 0 0\ng b\nf 1 1 1\nv 1 0 0\nv 0 1 0\n";
    assert!(error(too_late).contains("line 2\n  a face uses vertex 3"), "{}", error(too_late));
}

#[test]
fn bad_positions_are_named_with_their_line() {
    assert!(error("v 0 0\n").contains("line 1\n  a position has 2 coordinates; it needs 3"));
    assert!(error("\nv 0 zero 0\n").contains("line 2\n  'zero' is not a number"));
    assert!(error("v 0 1,5 0\n").contains("'1,5' is not a number"));
    assert!(error("v 0 0 0 0\n").contains("line 1\n  the fourth coordinate"));
    assert!(error(b"v 0 \xff 0\n").contains("is not a number"));
    assert!(error("v 0 0 0\0").contains("binary"));
}

#[test]
fn a_fourth_number_divides_and_colours_are_ignored() {
    let scene = read("v 2 0 0 2\nv 1 0 0 0.5 0.25 nan\nv 0 1 0 1 1 1 1\nf 1 2 3");
    assert_eq!(corners(&scene)[0], [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn lines_points_and_short_faces_are_counted_not_read() {
    let scene = read(format!("{TRIANGLE}l 1 2 3\np 1 2\nf 1 2\nf 1\nf\nl 7 8 9\n"));
    assert_eq!((scene.meshes.len(), scene.instances.len()), (0, 0));
    assert_eq!((scene.report.skipped_primitives, scene.report.unreferenced_positions), (6, 1));
}

#[test]
fn empty_files_are_empty_scenes() {
    for text in ["", "\n\n", "# nothing\n", "mtllib missing.mtl\nusemtl nothing\n", "\\", "f", "g", "usemtl"] {
        assert!(read(text).meshes.is_empty(), "{text}");
    }
}

#[test]
fn parts_follow_groups_and_materials() {
    let faces = "f 1 2 3\nusemtl red\nf 1 2 3\nf 1 2 3\ng wall\ng  wall \nf 1 2 3\nusemtl red\nf 1 2 3\no unused\ng \nusemtl blue\nf 3 2 1\n";
    let scene = read(format!("{TRIANGLE}{faces}"));
    let parts: Vec<_> = scene.meshes[0].parts.iter().map(|p| (p.name.as_str(), p.first_prim, p.prim_count)).collect();
    assert_eq!(parts, [("", 0, 1), ("/red", 1, 2), ("wall/red", 3, 2), ("/blue", 5, 1)]);
    assert_eq!(scene.meshes[0].parts[3].source_part, 3);
}

#[test]
fn unreferenced_positions_are_counted_and_left_out() {
    let scene = read(format!("v 9 9 9\n{TRIANGLE}v 8 8 8\nf 2 3 4\n"));
    assert_eq!((scene.report.unreferenced_positions, scene.meshes[0].positions.len()), (2, 3));
}

#[test]
fn degenerate_triangles_follow_the_policy() {
    let text = format!("{TRIANGLE}v 2 0 0\nv nan 0 0\nf 1 2 3\nf 1 1 2\nf 1 2 4\nf 1 2 5\nf 3 2 1\n");
    let with = |degenerate| read_as(&text, &ReadOptions { degenerate, ..ReadOptions::default() });

    let dropped = with(Degenerate::Drop).unwrap();
    assert_eq!((dropped.report.degenerate_triangles, dropped.report.non_finite_triangles), (2, 1));
    assert_eq!((dropped.meshes[0].triangles.len(), dropped.meshes[0].source_prims.as_slice()), (2, [0, 4].as_slice()));
    assert_eq!((dropped.meshes[0].parts[0].triangle_count, dropped.meshes[0].parts[0].prim_count), (2, 5));
    assert_eq!(dropped.meshes[0].positions.len(), 3);

    let kept = with(Degenerate::Keep).unwrap();
    assert_eq!((kept.report.degenerate_triangles, kept.meshes[0].triangles.len()), (2, 4));
    assert_eq!(kept.meshes[0].source_prims, [0, 1, 2, 4]);

    let refused = with(Degenerate::Error).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::BadModel);
    assert!(refused.to_string().contains("2 triangles without area and 1 with NaN"), "{refused}");
    assert!(refused.to_string().contains("first is triangle 1 of mesh"), "{refused}");
}

#[test]
fn old_spellings_of_nan_are_nan() {
    for nan in ["nan", "NaN", "inf", "-Infinity", "1e999", "1.#IND", "-1.#QNAN0", "1.#INF", "-nan(ind)"] {
        let scene = read(format!("{TRIANGLE}v 0 {nan} 0\nf 1 2 3\nf 1 2 4\n"));
        assert_eq!((scene.report.non_finite_triangles, scene.meshes[0].triangles.len()), (1, 1), "{nan}");
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
fn memory_and_size_limits_hold() {
    let limited = ReadOptions { max_memory: 100, ..ReadOptions::default() };
    let failed = read_as(format!("{TRIANGLE}f 1 2 3"), &limited).unwrap_err();
    assert_eq!(failed.kind(), ErrorKind::Limit);
    assert!(failed.to_string().contains("the limit is 100 bytes\nhelp: raise it with --max-memory"), "{failed}");

    let mut face = String::from("v 0 0 0\nf");
    (0..20_000).for_each(|_| face += " 1");
    let failed = read_as(face, &ReadOptions::default()).unwrap_err();
    assert_eq!(failed.kind(), ErrorKind::Limit);
    assert!(failed.to_string().contains("a face has 20000 corners; the limit is 16384"), "{failed}");
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

#[test]
fn large_faces_share_an_allowance_and_small_ones_need_none() {
    let mut cut = super::Triangulator::default();
    assert!((0..1_000_000).all(|_| cut.afford(1000)));
    assert!((0..256).all(|_| cut.afford(1 << 14)));
    assert!(!cut.afford(2000));
}
