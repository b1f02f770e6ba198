mod faces;
mod far;
mod grouped;
mod lines;
mod names;
mod pieces;
mod plain;
mod polygons;
mod ranges;

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
fn empty_files_are_empty_scenes() {
    for text in ["", "\n\n", "# nothing\n", "mtllib missing.mtl\nusemtl nothing\n", "\\", "f", "g", "usemtl"] {
        assert!(read(text).meshes.is_empty(), "{text}");
    }
}

#[test]
fn unreferenced_positions_are_counted_and_left_out() {
    let scene = read(format!("v 9 9 9\n{TRIANGLE}v 8 8 8\nf 2 3 4\n"));
    assert_eq!((scene.report.unreferenced_positions, scene.meshes[0].positions.len()), (2, 3));
}

/// One number behind the three is a weight, three are a colour; a comment is neither.
#[test]
fn weights_that_are_not_followed_are_counted() {
    let text = "v 0 0 0 2\nv 1 0 0 1.000\nv 0 1 0 .5 # half\nv 1 1 0 0.5 0.5 0.5\nv 2 1 0 # 3\nv 2 2 0 0.25 \\\n\nf 1 2 3\nf 3 4 5 6\n";
    assert_eq!(read(text).report.ignored_weights, 3);
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
    assert!(refused.to_string().contains("2 triangles without area, 1 with NaN"), "{refused}");
    assert!(refused.to_string().contains("first is triangle 1 of mesh"), "{refused}");
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
    assert!(failed.to_string().contains("test.obj line 2: a face has 20000 corners; the limit is 16384"), "{failed}");
}
