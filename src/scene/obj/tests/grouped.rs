//! Parts that are joined in groups are the mesh that they are one after the other.

use super::super::joined::Joined;
use super::super::{grouped, ranges};
use super::plain::texts;
use crate::exec::Executor;
use crate::scene::ReadOptions;
use crate::scene::source::Source;
use std::path::Path;

/// Hold the groups of a text, of all sizes, against its parts one after the other. How many parts it has; `None` if it is not for this reader.
fn hold(text: &str, range: usize) -> Option<usize> {
    let (one, two) = (Executor::sequential(), Executor::new(2).unwrap());
    let (options, mut progress) = (ReadOptions::default(), |_, _| ());
    let mut source = Source::new(Path::new("test.obj"), None, &options, &one, &mut progress);
    let mut joined = Joined::new("test".into(), None, false);
    let unreferenced = joined.add_everyday(ranges::read(text.as_bytes(), range, &mut source)?);
    let (mesh, positions) = joined.finish();
    let expected = format!("{mesh:?} {positions:?} {unreferenced}");
    for faces in [1, 2, 5, usize::MAX] {
        for exec in [&one, &two] {
            let read = ranges::read(text.as_bytes(), range, &mut source).unwrap();
            let (mesh, positions, unreferenced) = grouped::join(read, faces, "test".into(), exec);
            assert_eq!(format!("{mesh:?} {positions:?} {unreferenced}"), expected, "groups of {faces} faces: {text:?}");
        }
    }
    Some(mesh.parts.len())
}

#[test]
fn any_text_is_joined_alike_in_groups_of_any_size() {
    let parts: Vec<usize> = texts(1000).iter().filter_map(|text| hold(text, 40)).collect();
    assert!(parts.len() > 100 && parts.iter().any(|parts| *parts > 2), "{parts:?}");
}

#[test]
fn groups_share_positions_and_leave_some_out() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 4 4 4\n";
    let concave = "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nv -1 -1 0\n";
    let faces =
        "o a\nf 1 2 3\nf 1 2 3 4\no b\nf 9 8 7\nf 6 7 8 9 10\ng c\nusemtl d\nf 3 2 1\no a\nf 4 3 2\nf -1 -2 -3 -4\n";
    for range in [0, 30, 1 << 19] {
        assert_eq!(hold(&format!("{square}{concave}{faces}{faces}"), range), Some(7));
        assert_eq!(hold(&format!("{square}f 1 2 3\n{concave}f 1 2 3 4\n"), range), Some(1));
    }
}
