//! Parts and what they are called.

use super::{TRIANGLE, read};

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
