use crate::scene::{Degenerate, ErrorKind, Format, ReadOptions, Resemblance, Scene, SceneError, read_bytes};

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
    assert_eq!((scene.report.skipped_primitives, scene.report.unreferenced_positions), (6, 1));
}

#[test]
fn empty_files_are_empty_scenes() {
    for text in ["", "\n\n", "# nothing\n", "mtllib missing.mtl\nusemtl nothing\n", "\\", "f", "g", "usemtl"] {
        assert!(read(text).meshes.is_empty(), "{text}");
    }
}

/// Name, material and number of triangles of each part.
fn parts(faces: impl AsRef<[u8]>) -> Vec<(String, String, u32)> {
    let scene = read([TRIANGLE.as_bytes(), faces.as_ref()].concat());
    let parts = &scene.meshes[0].parts;
    assert!(parts.iter().enumerate().all(|(i, p)| p.source_part == i as u32 && p.source_mesh == 0));
    assert!(parts.windows(2).all(|w| w[0].first_prim + w[0].prim_count == w[1].first_prim));
    parts.iter().map(|p| (p.name.clone(), p.material.clone(), p.prim_count)).collect()
}

fn named(name: &str, material: &str, count: u32) -> (String, String, u32) {
    (name.into(), material.into(), count)
}

#[test]
fn parts_are_runs_of_one_object_group_and_material() {
    let faces = "f 1 2 3\nusemtl red\nf 1 2 3\nf 1 2 3\ng wall\ng  wall \nf 1 2 3\nusemtl red\nf 1 2 3\no top\ng \nusemtl blue\nf 3 2 1\n";
    let want = [named("", "", 1), named("", "red", 2), named("/wall", "red", 2), named("top", "blue", 1)];
    assert_eq!(parts(faces), want);
    // Objects that share a group's name, that share their own, and names that only their divider tells apart.
    let lamps = "o Lamp\ng off\nf 1 2 3\no Chair\ng off\nf 3 2 1\n";
    assert_eq!(parts(lamps), [named("Lamp/off", "", 1), named("Chair/off", "", 1)]);
    assert_eq!(parts("o Cube\nf 1 2 3\no Cube\nf 3 2 1\n"), [named("Cube", "", 1), named("Cube", "", 1)]);
    let slashes = "g a/b\nusemtl c\nf 1 2 3\ng a\nusemtl b/c\nf 3 2 1\n";
    assert_eq!(parts(slashes), [named("/a/b", "c", 1), named("/a", "b/c", 1)]);
    assert_eq!(parts("o a\nf 1 2 3\no a/\nf 1 2 3\no\ng a\nf 1 2 3\n").len(), 3);
    // A face that comes back to a part opens another run of it.
    assert_eq!(parts("g a\nf 1 2 3\ng b\nf 1 2 3\ng a\nf 1 2 3\n").len(), 3);
}

#[test]
fn names_are_bytes() {
    let faces = b"g caf\xe9\nf 1 2 3\ng caf\xe8\nf 1 2 3\nusemtl \xff 50%\nf 1 2 3\ng caf\xc3\xa9\nf 1 2 3\n";
    let want = [
        named("/caf%E9", "", 1),
        named("/caf%E8", "", 1),
        named("/caf%E8", "%FF 50%25", 1),
        named("/café", "%FF 50%25", 1),
    ];
    assert_eq!(parts(faces), want);
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
fn nul_bytes_are_read_over_at_the_end_and_nowhere_else() {
    let want = corners(&read(format!("{TRIANGLE}f 1 2 3\n")));
    for comment in [0, 5000] {
        for end in ["\0", "\n\0\0\0\0", "\0\0\n\0\r\n", "\n\x1a", "\n\x1a\0\0"] {
            let text = format!("#{}\n{TRIANGLE}f 1 2 3{end}", "-".repeat(comment));
            assert_eq!(corners(&read(&text)), want, "{text:?}");
        }
        for inside in ["v 0 0 0\0\n", "# a\0b\n", "\0\n"] {
            let text = format!("#{}\n{inside}{TRIANGLE}f 1 2 3\n", "-".repeat(comment));
            assert!(error(&text).contains("line 2\n  it has a NUL byte"), "{}", error(&text));
        }
    }
    assert!(read("\0\0\0").meshes.is_empty());
}

#[test]
fn a_text_without_any_statement_is_no_obj() {
    let is_refused = |text: &str, begins: &str, like: Resemblance| match read_as(text, &ReadOptions::default()) {
        Err(SceneError::NotObj { found, resembles, .. }) => {
            assert!(found.contains(begins) && resembles == like, "{found} {resembles:?}")
        }
        other => panic!("{other:?}"),
    };
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0123\nsize 2380763\n";
    is_refused(pointer, "version", Resemblance::LfsPointer);
    is_refused("\n <!DOCTYPE html><html><body>Not Found</body></html>\n", "<!DOCTYPE", Resemblance::WebPage);
    is_refused("# shouting\nV 0 0 0\nV 1 0 0\nV 0 1 0\nF 1 2 3\n", "V 0 0 0", Resemblance::Capitals);
    is_refused("{\"asset\":{\"version\":\"2.0\"}}", "{", Resemblance::Json);
    is_refused("solid cube\nfacet normal 0 0 1\nendsolid\n", "'solid cube'", Resemblance::Nothing);
    is_refused("Access denied \\\n to this file", "'Access denied", Resemblance::Nothing);
    // One statement is enough, wherever it stands and whatever else there is.
    assert_eq!(read(format!("exported by hand\n{TRIANGLE}f 1 2 3\n")).meshes.len(), 1);
    assert!(read("\\\nv 0 0 0\n").meshes.is_empty());
}

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
    assert!(failed.to_string().contains("the limit is 100 bytes"), "{failed}");

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
