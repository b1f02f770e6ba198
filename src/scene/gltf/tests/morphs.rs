//! Morph targets at rest.

use super::skins::Builder;
use super::*;

/// A triangle with two targets, which move x by 1 and y by 10; node 0 shows it.
fn morphed() -> Builder {
    let mut b = Builder::new();
    let positions = b.triangle();
    let first = b.floats("VEC3", &[[1., 0., 0.]; 3]);
    let second = b.floats("VEC3", &[[0., 10., 0.]; 3]);
    let targets = json!([{ "POSITION": first }, { "POSITION": second }]);
    b.mesh(json!([{ "attributes": { "POSITION": positions }, "targets": targets }]));
    b.node(json!({ "mesh": 0, "translation": [0, 0, 5] }));
    b
}

/// Vertex 0 of each instance, in world space.
fn firsts(b: &Builder) -> Vec<[f64; 3]> {
    let scene = read_json(&b.0);
    let first =
        |i: &crate::scene::Instance| i.transform.transform_point(scene.meshes[i.mesh as usize].exact_position(0));
    scene.instances.iter().map(first).collect()
}

#[test]
fn weights_of_the_node_go_before_those_of_the_mesh() {
    let mut b = morphed();
    assert_eq!(firsts(&b), [[0.0, 0.0, 5.0]]);
    b.0["meshes"][0]["weights"] = json!([1, 0.5]);
    assert_eq!(firsts(&b), [[1.0, 5.0, 5.0]]);
    b.node(json!({ "mesh": 0, "weights": [0, 0.1] }));
    b.node(json!({ "mesh": 0, "weights": [0, 0] }));
    b.node(json!({ "mesh": 0, "weights": [1.0, 0.5] }));
    b.node(json!({ "mesh": 0, "weights": [] }));
    assert_eq!(firsts(&b), [[1., 5., 5.], [0., 1., 0.], [0., 0., 0.], [1., 5., 0.], [1., 5., 0.]]);
    let scene = read_json(&b.0);
    assert_eq!(scene.instances.iter().map(|i| i.mesh).collect::<Vec<_>>(), [0, 1, 2, 0, 0]);
    assert_eq!(scene.report, Default::default());
}

#[test]
fn positions_are_known_better_than_single_precision() {
    let mut b = morphed();
    b.0["nodes"][0]["weights"] = json!([0.1]);
    let scene = read_json(&b.0);
    assert_eq!(scene.meshes[0].positions[0], [0.1f32, 0.0, 0.0]);
    assert!((scene.meshes[0].exact_position(0)[0] - 0.1).abs() < 1e-15);
    // Where a node moves them back to near 0, the rounding of 0.1 to f32 would be all that is left.
    let away = crate::geom::Affine { rows: [[1.0, 0.0, 0.0, -0.1], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
    assert!(scene.meshes[0].baked_position(0, &away)[0].abs() < 1e-15);
}

#[test]
fn targets_without_positions_keep_them_and_weights_without_a_target_are_counted() {
    let mut b = morphed();
    b.0["meshes"][0]["primitives"][0]["targets"] = json!([{ "NORMAL": 0 }, { "POSITION": 2 }]);
    b.0["nodes"][0]["weights"] = json!([1, 1, 1]);
    assert_eq!(firsts(&b), [[0.0, 10.0, 5.0]]);
    assert_eq!(read_json(&b.0).report.unapplied_morph_weights, 1);

    // A primitive without targets stays, and shares its positions with none that moves.
    let mut b = morphed();
    b.0["meshes"][0]["primitives"].as_array_mut().unwrap().push(json!({ "attributes": { "POSITION": 0 } }));
    b.0["nodes"][0]["weights"] = json!([1]);
    let scene = read_json(&b.0);
    assert_eq!((scene.meshes[0].positions[0], scene.meshes[0].positions[3]), ([1.0, 0.0, 0.0], [0.0; 3]));
    assert_eq!(scene.report.unapplied_morph_weights, 1);
}

#[test]
fn targets_may_be_sparse_or_quantized() {
    let mut b = morphed();
    let bytes = b.accessor(5120, "VEC3", 3, &[127, 0, 0, 0x81, 0, 0, 0x80, 0, 0]);
    b.0["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = bytes.into();
    b.0["nodes"][0]["weights"] = json!([2]);
    let scene = read_json(&b.0);
    assert_eq!(scene.meshes[0].positions, [[2.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [-2.0, 1.0, 0.0]]);

    let mut b = morphed();
    let (places, values) = (b.accessor(5121, "SCALAR", 1, &[2]), b.floats("VEC3", &[[0., 0., 3.]]));
    b.0["accessors"][1] = json!({ "componentType": 5126, "type": "VEC3", "count": 3, "sparse": {
        "count": 1, "indices": { "bufferView": places, "componentType": 5121 }, "values": { "bufferView": values },
    } });
    b.0["nodes"][0]["weights"] = json!([2]);
    assert_eq!(read_json(&b.0).meshes[0].positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 6.0]]);
}

#[test]
fn displacements_come_before_the_joints() {
    let mut b = morphed();
    let joints = b.joints(&[0; 12]);
    let weights = b.floats("VEC4", &[[1., 0., 0., 0.]; 3]);
    let attributes = &mut b.0["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = joints.into();
    attributes["WEIGHTS_0"] = weights.into();
    b.node(json!({ "rotation": [0, 0, 1, 0], "translation": [100, 0, 0] }));
    b.skin(&[1], None);
    b.0["nodes"][0]["skin"] = 0.into();
    b.0["nodes"][0]["weights"] = json!([1, 1]);
    assert_eq!(firsts(&b), [[99.0, -10.0, 0.0]]);
}

#[test]
fn instances_show_the_displaced_mesh() {
    let mut b = morphed();
    b.0["nodes"][0]["weights"] = json!([1]);
    b.0["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } } });
    assert_eq!(firsts(&b), [[1., 0., 5.], [2., 0., 5.], [1., 1., 5.]]);
}

#[test]
fn targets_of_another_length_are_refused() {
    let mut b = morphed();
    let short = b.floats("VEC3", &[[1., 0., 0.]]);
    b.0["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] = short.into();
    read_json(&b.0);
    b.0["nodes"][0]["weights"] = json!([0, 1]);
    assert!(error(&b.0).contains("primitive 0 of mesh 0 has 3 positions, but 1 elements in accessor"));
}

#[test]
fn normalized_positions_are_known_better_than_single_precision() {
    let mut b = Builder::new();
    let positions = b.accessor(5123, "VEC3", 3, &[0x33, 0x33, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0, 0]);
    b.mesh(
        json!([{ "attributes": { "POSITION": positions } }, { "attributes": { "POSITION": positions }, "mode": 6 }]),
    );
    b.node(json!({ "mesh": 0 }));
    let scene = read_json(&b.0);
    assert_eq!((scene.meshes[0].positions.len(), scene.meshes[0].remainders.len()), (3, 3));
    assert!((scene.meshes[0].exact_position(0)[0] - 0.2).abs() < 1e-15);
}
