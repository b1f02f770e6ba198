use crate::scene::{Degenerate, ErrorKind, Format, ReadOptions, Scene, SceneError, read_bytes};

fn read_with(text: impl AsRef<[u8]>, options: &ReadOptions) -> Result<Scene, SceneError> {
    read_bytes(text.as_ref().to_vec(), "test.obj", Some(Format::Obj), None, options)
}

fn read(text: impl AsRef<[u8]>) -> Scene {
    read_with(text, &ReadOptions { degenerate: Degenerate::Keep, ..ReadOptions::default() }).unwrap()
}

fn error(text: &str) -> String {
    read_with(text, &ReadOptions::default()).unwrap_err().to_string()
}

#[test]
fn a_triangle() {
    let scene = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3");
    assert_eq!(scene.meshes.len(), 1);
    assert_eq!(scene.meshes[0].corners(0), [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(scene.instances.len(), 1);
    assert_eq!(scene.report, Default::default());
    assert_eq!((scene.inputs[0].name.as_str(), scene.inputs[0].len), ("test.obj", 31));
}

#[test]
fn errors_name_file_and_line() {
    assert!(error("v 0 0 0\nf 1 2 0").starts_with("cannot read test.obj line 2\n"));
    let limit = ReadOptions { max_memory: 100, ..ReadOptions::default() };
    let failed = read_with("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", &limit).unwrap_err();
    assert_eq!(failed.kind(), ErrorKind::Limit);
}
