//! Animations that move joints and morph weights.

use super::animation::{add_animation, add_channel, at, on_axes, placed, posed, stands, target};
use super::skins::Builder;
use super::*;

const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// A quad from (-1, 0) to (1, 2), whose lower corners joint 0 holds, the last corner joint 1 and the third a quarter joint 0; nodes: 0 the upper
/// joint at y = 1, 1 the lower with the upper below it, 2 the skinned node. An animation bends the upper joint by ninety degrees in a second.
fn bent(lower: Value) -> Builder {
    let mut b = Builder::new();
    let positions = b.floats("VEC3", &[[-1., 0., 0.], [1., 0., 0.], [-1., 2., 0.], [1., 2., 0.]]);
    let joints = b.joints(&[0, 1, 0, 0].repeat(4));
    let weights = b.floats("VEC4", &[[1., 0., 0., 0.], [1., 0., 0., 0.], [0.25, 0.75, 0., 0.], [0., 1., 0., 0.]]);
    let identity = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    let mut lowered = identity;
    lowered[13] = -1.0;
    let binds = b.floats("MAT4", &[identity, lowered]);
    let indices = b.accessor(5121, "SCALAR", 6, &[0, 1, 2, 2, 1, 3]);
    let attributes = json!({ "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights });
    b.mesh(json!([{ "attributes": attributes, "indices": indices }]));
    b.node(json!({ "translation": [0, 1, 0] }));
    b.node(lower);
    b.0["nodes"][1]["children"] = json!([0]);
    b.node(json!({ "mesh": 0, "skin": 0 }));
    b.skin(&[1, 0], Some(binds));
    add_animation(&mut b, "Bend");
    bend(&mut b, 0, HALF);
    b
}

fn bend(b: &mut Builder, joint: usize, z: f32) {
    let turns = b.floats("VEC4", &[[0., 0., 0., 1.], [0., 0., z, HALF]]);
    add_channel(b, target(joint, "rotation"), "LINEAR", &[0., 1.], turns);
}

/// A linear channel from one vector to another in a second.
fn glide(b: &mut Builder, node: usize, path: &str, from: [f32; 3], to: [f32; 3]) {
    let values = b.floats("VEC3", &[from, to]);
    add_channel(b, target(node, path), "LINEAR", &[0., 1.], values);
}

#[test]
fn joints_bend_a_mesh_and_its_own_node_and_parents_do_not_move_it() {
    let b = bent(json!({}));
    stands(&b, 0.5, 2, [-1.3106602, 1.25, 0.0]);
    stands(&b, 1.0, 3, [-1.0, 2.0, 0.0]);

    let mut b = bent(json!({ "translation": [2, 0, 0] }));
    b.0["nodes"][2]["translation"] = json!([10, 0, 0]);
    b.node(json!({ "children": [2], "translation": [0, 5, 0] }));
    stands(&b, 1.0, 3, [1.0, 2.0, 0.0]);
    glide(&mut b, 3, "translation", [0., 0., 0.], [0., 0., 100.]);
    glide(&mut b, 2, "scale", [1., 1., 1.], [3., 3., 3.]);
    stands(&b, 1.0, 1, [3.0, 0.0, 0.0]);
    stands(&b, 1.0, 2, [1.0, 0.5, 0.0]);
}

#[test]
fn nodes_above_the_joints_move_them() {
    let mut b = bent(json!({ "translation": [2, 0, 0] }));
    b.node(json!({ "children": [1], "scale": [2, 1, 1] }));
    glide(&mut b, 3, "translation", [0., 0., 0.], [0., 0., 7.]);
    let turns = b.floats("VEC4", &[[0., 0., 0., 1.], [HALF, 0., 0., HALF]]);
    add_channel(&mut b, target(3, "rotation"), "LINEAR", &[0., 1.], turns);
    stands(&b, 0.5, 3, [4.0, 1.7071068, 5.2071068]);
    stands(&b, 1.0, 3, [2.0, 0.0, 9.0]);

    // A scale in the lower joint shears what the upper turns.
    let mut b = bent(json!({ "scale": [1, 3, 1] }));
    glide(&mut b, 1, "scale", [1., 3., 1.], [2., 1., 1.]);
    stands(&b, 0.5, 2, [-1.9659903, 2.5, 0.0]);
    stands(&b, 1.0, 3, [-2.0, 2.0, 0.0]);
}

#[test]
fn a_skinned_node_may_be_its_own_joint() {
    let mut b = bent(json!({}));
    b.0["nodes"] = json!([{ "mesh": 0, "skin": 0, "translation": [0, 1, 0] }]);
    b.0["skins"][0] = json!({ "joints": [0, 0] });
    stands(&b, 1.0, 1, [0.0, 2.0, 0.0]);
}

#[test]
fn inverse_bind_matrices_may_be_absent_and_weights_need_not_sum_to_one() {
    let mut b = bent(json!({ "translation": [2, 0, 0] }));
    b.0["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    stands(&b, 1.0, 2, [0.25, 0.5, 0.0]);

    let mut b = bent(json!({ "translation": [2, 0, 0] }));
    let halves = b.floats("VEC4", &[[0.5, 0., 0., 0.], [0.5, 0., 0., 0.], [0.25, 0.25, 0., 0.], [0., 0.5, 0., 0.]]);
    b.0["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = halves.into();
    stands(&b, 1.0, 1, [3.0, 0.0, 0.0]);
    stands(&b, 1.0, 2, [1.0, 1.0, 0.0]);

    let mut b = bent(json!({}));
    let bytes = b.accessor(5121, "VEC4", 4, &[255, 0, 0, 0, 255, 0, 0, 0, 51, 204, 0, 0, 0, 255, 0, 0]);
    b.0["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = bytes.into();
    stands(&b, 1.0, 2, [-1.0, 0.4, 0.0]);
}

#[test]
fn joints_of_the_second_set_move_too() {
    let mut b = bent(json!({}));
    let joints = b.joints(&[2, 0, 0, 0].repeat(4));
    let weights = b.floats("VEC4", &[[1., 0., 0., 0.], [1., 0., 0., 0.], [1., 0., 0., 0.], [0., 0., 0., 0.]]);
    b.0["meshes"][0]["primitives"][0]["attributes"]["JOINTS_1"] = joints.into();
    b.0["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_1"] = weights.into();
    b.node(json!({}));
    b.0["skins"][0] = json!({ "joints": [1, 0, 3] });
    glide(&mut b, 3, "translation", [0., 0., 0.], [8., 0., 0.]);
    stands(&b, 1.0, 0, [3.0, 0.0, 0.0]);
    stands(&b, 1.0, 1, [5.0, 0.0, 0.0]);
}

#[test]
fn each_node_has_the_pose_of_its_own_skin() {
    let mut b = bent(json!({}));
    b.node(json!({ "translation": [0, 1, 0] }));
    b.node(json!({ "children": [3], "translation": [5, 0, 0] }));
    b.node(json!({ "mesh": 0, "skin": 1 }));
    b.node(json!({ "mesh": 0, "skin": 0, "translation": [50, 0, 0] }));
    let binds = b.0["skins"][0]["inverseBindMatrices"].as_u64().map(|accessor| accessor as usize);
    b.skin(&[4, 3], binds);
    bend(&mut b, 3, -HALF);
    let got: Vec<[f64; 3]> = posed(&b, 1.0).iter().map(|mesh| mesh[3]).collect();
    for (got, want) in got.iter().zip([[-1., 2., 0.], [6., 0., 0.], [-1., 2., 0.]]) {
        assert!((0..3).all(|k| (got[k] - want[k]).abs() < 1e-6), "{got:?}, want {want:?}");
    }
    // The two nodes of one skin share a mesh.
    let scene = at(&b, 0, 1.0);
    assert_eq!(scene.instances.iter().map(|i| i.mesh).collect::<Vec<_>>(), [0, 1, 0]);
}

#[test]
fn a_skinned_mesh_with_instances_stands_once() {
    let mut b = bent(json!({}));
    let places = b.floats("VEC3", &[[0., 0., 0.], [10., 0., 0.]]);
    b.0["nodes"][2]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    let scene = at(&b, 0, 1.0);
    assert_eq!((scene.instances.len(), scene.report.uninstanced_skins), (1, 1));
    stands(&b, 1.0, 3, [-1.0, 2.0, 0.0]);
}

/// The triangle on the axes with two morph targets, which move it along z and outwards, and weights of the mesh.
fn morphed(node: Value) -> Builder {
    let mut b = on_axes(node);
    let along = b.floats("VEC3", &[[0., 0., 1.], [0., 0., 2.], [0., 0., 3.]]);
    let outwards = b.floats("VEC3", &[[10., 0., 0.], [0., 10., 0.], [0., 0., 10.]]);
    b.0["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": along }, { "POSITION": outwards }]);
    b.0["meshes"][0]["weights"] = json!([0.5, 0]);
    b
}

fn add_weights(b: &mut Builder, node: usize, interpolation: &str, times: &[f32], values: &[f32]) {
    let values: Vec<[f32; 1]> = values.iter().map(|v| [*v]).collect();
    let output = b.floats("SCALAR", &values);
    add_channel(b, target(node, "weights"), interpolation, times, output);
}

#[test]
fn weights_of_an_animation_are_those_of_its_node_alone() {
    let mut b = morphed(json!({ "mesh": 0 }));
    b.node(json!({ "mesh": 0, "translation": [20, 0, 0] }));
    add_weights(&mut b, 0, "LINEAR", &[0., 1.], &[0., 0., 1., 0.5]);
    assert_eq!(posed(&b, 1.0)[0][2], [0.0, 0.0, 11.0]);
    assert_eq!(posed(&b, 0.5)[0][0], [3.5, 0.0, 0.5]);
    assert_eq!(posed(&b, 1.0)[1][2], [20.0, 0.0, 4.5]);
    // An animation without weights leaves the node's, and else the mesh's; an animation before its first key has those of that key.
    let mut b = morphed(json!({ "mesh": 0, "weights": [0, 0.1] }));
    assert!((posed(&b, 0.0)[0][0][0] - 2.0).abs() < 1e-12);
    add_weights(&mut b, 0, "LINEAR", &[1., 2.], &[0., 1., 1., 0.]);
    assert_eq!(posed(&b, 0.0)[0][0], [11.0, 0.0, 0.0]);
    assert_eq!(posed(&b, 1.5)[0][2], [0.0, 0.0, 9.5]);
}

#[test]
fn instances_of_a_node_have_its_weights() {
    let mut b = morphed(json!({ "mesh": 0 }));
    let places = b.floats("VEC3", &[[0., 0., 0.], [100., 0., 0.]]);
    b.0["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    add_weights(&mut b, 0, "LINEAR", &[0., 1.], &[0., 0., 1., 1.]);
    let firsts: Vec<[f64; 3]> = posed(&b, 1.0).iter().map(|mesh| mesh[0]).collect();
    assert_eq!(firsts, [[11., 0., 1.], [111., 0., 1.]]);
}

#[test]
fn weights_step_and_follow_splines() {
    let mut b = morphed(json!({ "mesh": 0 }));
    add_weights(&mut b, 0, "STEP", &[0., 0.5], &[0., 1., 1., 0.]);
    assert_eq!(posed(&b, 0.49)[0][0], [11.0, 0.0, 0.0]);
    assert_eq!(posed(&b, 0.5)[0][0], [1.0, 0.0, 1.0]);

    // At each key all incoming tangents, all values, all outgoing tangents.
    let mut b = morphed(json!({ "mesh": 0 }));
    add_weights(&mut b, 0, "CUBICSPLINE", &[0., 2.], &[0., 0., 0., 0., 1., 0., 0., 2., 1., 0.5, 0., 0.]);
    assert_eq!(posed(&b, 1.0)[0][2], [0.0, 0.0, 2.75]);
    assert_eq!(posed(&b, 2.0)[0][2], [0.0, 0.0, 11.0]);

    // Integers are normalized.
    let mut b = morphed(json!({ "mesh": 0 }));
    let bytes = b.accessor(5120, "SCALAR", 4, &[0, 0, 0x80, 127]);
    add_channel(&mut b, target(0, "weights"), "LINEAR", &[0., 1.], bytes);
    assert_eq!(posed(&b, 1.0)[0][0], [11.0, 0.0, -1.0]);
}

#[test]
fn targets_may_lack_positions_be_sparse_or_stand_in_some_primitives_only() {
    let mut b = morphed(json!({ "mesh": 0 }));
    b.0["meshes"][0]["primitives"][0]["targets"][1] = json!({ "NORMAL": 0 });
    add_weights(&mut b, 0, "LINEAR", &[0., 1.], &[0., 0., 1., 1.]);
    assert_eq!(posed(&b, 1.0)[0][2], [0.0, 0.0, 6.0]);
    assert_eq!(at(&b, 0, 1.0).report.unapplied_morph_weights, 0);

    let mut b = morphed(json!({ "mesh": 0 }));
    let more = b.floats("VEC3", &[[5., 0., 0.], [6., 0., 0.], [5., 1., 0.]]);
    b.0["meshes"][0]["primitives"].as_array_mut().unwrap().push(json!({ "attributes": { "POSITION": more } }));
    add_weights(&mut b, 0, "LINEAR", &[0., 1.], &[0., 0., 1., 0.]);
    assert_eq!(posed(&b, 1.0)[0][2..5], [[0., 0., 6.], [5., 0., 0.], [6., 0., 0.]]);
    assert_eq!(at(&b, 0, 1.0).report.unapplied_morph_weights, 1);

    // A byte target, of which all but one displacement are absent.
    let mut b = morphed(json!({ "mesh": 0 }));
    let (places, values) = (b.joints(&[1, 0, 0, 0]), b.accessor(5120, "VEC3", 1, &[0, 0, 0x80]));
    let view = |accessor: usize| b.0["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": view(places), "componentType": 5121 },
        "values": { "bufferView": view(values) },
    });
    let accessor = json!({ "componentType": 5120, "normalized": true, "type": "VEC3", "count": 3, "sparse": sparse });
    let accessors = b.0["accessors"].as_array_mut().unwrap();
    accessors.push(accessor);
    let number = accessors.len() - 1;
    b.0["meshes"][0]["primitives"][0]["targets"][0] = json!({ "POSITION": number });
    add_weights(&mut b, 0, "LINEAR", &[0., 1.], &[0., 0., 1., 0.]);
    assert_eq!(posed(&b, 1.0)[0], [[1., 0., 0.], [0., 2., -1.], [0., 0., 3.]]);
}

#[test]
fn displacements_come_before_the_joints() {
    let mut b = bent(json!({}));
    let moves = b.floats("VEC3", &[[0., 0., 1.], [0., 0., 0.], [0., 0., 2.], [1., 0., 0.]]);
    b.0["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": moves }]);
    add_weights(&mut b, 2, "LINEAR", &[0., 1.], &[0., 1.]);
    stands(&b, 0.5, 3, [0.3535534, 2.767767, 0.0]);
    stands(&b, 1.0, 2, [-1.0, 0.5, 2.0]);
    stands(&b, 1.0, 3, [-1.0, 3.0, 0.0]);
}

#[test]
fn a_mesh_without_a_moved_shape_is_shared_by_its_nodes_at_any_time() {
    let mut b = morphed(json!({ "mesh": 0 }));
    b.node(json!({ "mesh": 0, "translation": [20, 0, 0] }));
    glide(&mut b, 1, "translation", [20., 0., 0.], [30., 0., 0.]);
    let scene = at(&b, 0, 1.0);
    assert_eq!((scene.meshes.len(), placed(&scene)[1][0]), (1, [31.0, 0.0, 0.5]));
}
