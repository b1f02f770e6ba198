//! Skinned meshes at rest.

use super::*;
use crate::geom::Affine;

/// A document that grows: each accessor has a buffer of its own.
pub(super) struct Builder(pub Value);

impl Builder {
    pub fn new() -> Builder {
        Builder(json!({
            "asset": { "version": "2.0" },
            "buffers": [], "bufferViews": [], "accessors": [], "meshes": [], "nodes": [], "skins": [],
        }))
    }

    fn push(&mut self, list: &str, item: Value) -> usize {
        let list = self.0[list].as_array_mut().unwrap();
        list.push(item);
        list.len() - 1
    }

    pub fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let buffer = self.push("buffers", json!({ "byteLength": bytes.len(), "uri": data_uri(bytes) }));
        let view = self.push("bufferViews", json!({ "buffer": buffer, "byteLength": bytes.len() }));
        let normalized = component != 5126 && kind != "SCALAR";
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "type": kind, "count": count, "normalized": normalized }),
        )
    }

    pub fn floats<const N: usize>(&mut self, kind: &str, elements: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = elements.iter().flat_map(|e| le(e)).collect();
        self.accessor(5126, kind, elements.len(), &bytes)
    }

    pub fn joints(&mut self, joints: &[u8]) -> usize {
        let accessor = self.accessor(5121, "VEC4", joints.len() / 4, joints);
        self.0["accessors"][accessor]["normalized"] = false.into();
        accessor
    }

    pub fn mesh(&mut self, primitives: Value) -> usize {
        self.push("meshes", json!({ "primitives": primitives }))
    }

    pub fn node(&mut self, node: Value) -> usize {
        self.push("nodes", node)
    }

    pub fn skin(&mut self, joints: &[usize], inverse_binds: Option<usize>) -> usize {
        self.push("skins", json!({ "joints": joints, "inverseBindMatrices": inverse_binds }))
    }

    pub fn triangle(&mut self) -> usize {
        self.floats("VEC3", &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]])
    }
}

/// A triangle with the bind matrix of a shift by −1 in x, each vertex held by joint 0 or joint 1; nodes: 0 and 1 the joints at
/// x = 10 and y = 20, 2 the skinned node under a parent, both of them somewhere else.
fn skinned() -> Builder {
    let mut b = Builder::new();
    let positions = b.triangle();
    let joints = b.joints(&[0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0]);
    let weights = b.floats("VEC4", &[[1., 0., 0., 0.], [0., 1., 0., 0.], [0.5, 0.5, 0., 0.]]);
    let shift = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., -1., 0., 0., 1.];
    let binds = b.floats("MAT4", &[shift, shift]);
    b.mesh(json!([{ "attributes": { "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights } }]));
    b.node(json!({ "translation": [10, 0, 0] }));
    b.node(json!({ "translation": [0, 20, 0] }));
    b.node(json!({ "mesh": 0, "skin": 0, "name": "Body", "scale": [3, 3, 3] }));
    b.node(json!({ "children": [2], "translation": [0, 0, 500] }));
    b.skin(&[0, 1], Some(binds));
    b
}

/// Vertex 0 of the first instance, in world space.
fn first(scene: &Scene) -> [f64; 3] {
    scene.instances[0].transform.transform_point(scene.meshes[0].exact_position(0))
}

const POSED: [[f32; 3]; 3] = [[9.0, 0.0, 0.0], [0.0, 20.0, 0.0], [4.0, 11.0, 0.0]];

#[test]
fn joints_place_a_skinned_mesh_and_its_own_node_does_not() {
    let scene = read_json(&skinned().0);
    assert_eq!(scene.meshes[0].positions, POSED);
    let instance = &scene.instances[0];
    assert_eq!((instance.transform, instance.node, instance.name.as_str()), (Affine::IDENTITY, 2, "Body"));
    assert_eq!(scene.report, Default::default());

    // A joint's ancestors count, and so does the place of the skinned node among them: it may be its own joint.
    let mut b = skinned();
    b.0["nodes"][3]["children"] = json!([2, 0]);
    assert_eq!(first(&read_json(&b.0)), [9.0, 0.0, 500.0]);
    b.0["skins"][0]["joints"] = json!([2, 2]);
    assert_eq!(first(&read_json(&b.0)), [-3.0, 0.0, 500.0]);
}

#[test]
fn each_skin_makes_a_mesh_of_its_own_and_plain_nodes_show_the_plain_mesh() {
    let mut b = skinned();
    b.node(json!({ "mesh": 0, "translation": [7, 0, 0] }));
    b.node(json!({ "mesh": 0, "skin": 1 }));
    b.node(json!({ "mesh": 0, "skin": 0 }));
    b.skin(&[1, 1], None);
    let scene = read_json(&b.0);
    assert_eq!(scene.instances.iter().map(|i| (i.node, i.mesh)).collect::<Vec<_>>(), [(2, 0), (4, 1), (5, 2), (6, 0)]);
    let first =
        |i: &crate::scene::Instance| i.transform.transform_point(scene.meshes[i.mesh as usize].exact_position(0));
    assert_eq!(
        scene.instances.iter().map(first).collect::<Vec<_>>(),
        [[9., 0., 0.], [7., 0., 0.], [0., 20., 0.], [9., 0., 0.]]
    );
    assert!(scene.meshes.iter().all(|m| m.parts[0].source_mesh == 0));
}

#[test]
fn weights_are_divided_by_their_sum_whatever_their_type() {
    let with = |component: u32, bytes: &[u8], joints: &[u8]| {
        let mut b = skinned();
        let weights = b.accessor(component, "VEC4", 3, bytes);
        b.0["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = weights.into();
        if !joints.is_empty() {
            let joints = b.accessor(5123, "VEC4", 3, joints);
            b.0["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = joints.into();
        }
        read_json(&b.0)
    };
    assert_eq!(with(5121, &[9, 0, 0, 0, 0, 7, 0, 0, 100, 100, 0, 0], &[]).meshes[0].positions, POSED);
    let shorts: Vec<u8> = [5u16, 0, 0, 0, 0, 65535, 0, 0, 3, 3, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let joints: Vec<u8> = [0u16, 1, 9, 9, 0, 1, 9, 9, 0, 1, 9, 9].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(with(5123, &shorts, &joints).meshes[0].positions, POSED);
    let halves = le(&[0.5, 0., 0., 0., 0., 0.25, 0., 0., 0.125, 0.125, 0., 0.]);
    assert_eq!(with(5126, &halves, &[]).meshes[0].positions, POSED);

    // A vertex without weights follows its first joint.
    let none = with(5126, &le(&[0., 0., 0., 0., 0., 1., 0., 0., 0.5, 0.5, 0., 0.]), &[]);
    assert_eq!((none.meshes[0].positions[0], none.report.unweighted_vertices), (POSED[0], 1));
}

#[test]
fn every_set_of_joints_counts() {
    let mut b = skinned();
    let joints = b.joints(&[1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    let weights = b.floats("VEC4", &[[3., 0., 0., 0.], [0.; 4], [0.; 4]]);
    let attributes = &mut b.0["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = joints.into();
    attributes["WEIGHTS_1"] = weights.into();
    // Vertex 0: a quarter of joint 0 at (9, 0, 0), three quarters of joint 1 at (-1, 20, 0).
    assert_eq!(read_json(&b.0).meshes[0].positions, [[1.5, 15.0, 0.0], POSED[1], POSED[2]]);
}

#[test]
fn inverse_bind_matrices_may_be_absent_and_must_suffice() {
    let mut b = skinned();
    b.0["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    assert_eq!(read_json(&b.0).meshes[0].positions, [[10.0, 0.0, 0.0], [1.0, 20.0, 0.0], [5.0, 11.0, 0.0]]);
    let mut b = skinned();
    let one = b.floats("MAT4", &[[0.0; 16]]);
    b.0["skins"][0]["inverseBindMatrices"] = one.into();
    assert!(error(&b.0).contains("skin 0 has 2 joints, but 1 inverse bind matrices"));
    let two = b.floats("MAT4", &[[0.0; 16], [0.0; 16]]);
    b.0["skins"][0]["inverseBindMatrices"] = two.into();
    assert!(error(&b.0).contains("inverse bind matrix 0 of skin 0 has the last row"));
}

#[test]
fn a_skin_whose_joints_all_mirror_is_counted() {
    let counted = |first: f32, second: f32| {
        let mut b = skinned();
        let mirror = |x: f32| [x, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let binds = b.floats("MAT4", &[mirror(first), mirror(second)]);
        b.0["skins"][0]["inverseBindMatrices"] = binds.into();
        read_json(&b.0).report.mirrored_skins
    };
    assert_eq!([counted(1.0, 1.0), counted(-1.0, 1.0), counted(-1.0, -1.0), counted(0.0, -1.0)], [0, 0, 1, 0]);
}

#[test]
fn what_no_joint_holds_is_placed_by_its_node_and_counted() {
    let by_node = |edit: &dyn Fn(&mut Value)| {
        let mut b = skinned();
        edit(&mut b.0);
        let scene = read_json(&b.0);
        assert_eq!(scene.report.unposed_skins, 1);
        assert_eq!(scene.instances[0].transform.transform_point([1.0, 0.0, 0.0]), [3.0, 0.0, 500.0]);
        assert_eq!(scene.meshes[0].positions[1], [1.0, 0.0, 0.0]);
    };
    by_node(&|d| d["skins"][0]["joints"] = json!([]));
    by_node(&|d| drop(d["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("JOINTS_0")));
    by_node(&|d| drop(d["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("WEIGHTS_0")));

    // One primitive with joints and one without: both in world space, each by its own rule.
    let mut b = skinned();
    b.0["meshes"][0]["primitives"].as_array_mut().unwrap().push(json!({ "attributes": { "POSITION": 0 } }));
    let scene = read_json(&b.0);
    assert_eq!((scene.report.unposed_skins, scene.instances[0].transform), (1, Affine::IDENTITY));
    assert_eq!(scene.meshes[0].positions[..3], POSED);
    assert_eq!(scene.meshes[0].positions[3..], [[0.0, 0.0, 500.0], [3.0, 0.0, 500.0], [0.0, 3.0, 500.0]]);
}

#[test]
fn joints_outside_of_the_scene_are_found_with_all_above_them() {
    let mut b = skinned();
    b.node(json!({ "children": [0], "translation": [0, 0, 1000] }));
    b.0["scenes"] = json!([{ "nodes": [3] }]);
    let scene = read_json(&b.0);
    assert_eq!((scene.instances.len(), first(&scene)), (1, [9.0, 0.0, 1000.0]));
}

#[test]
fn broken_skins_are_refused_where_they_are_used_and_only_there() {
    let reason = |edit: &dyn Fn(&mut Value)| {
        let mut b = skinned();
        edit(&mut b.0);
        let text = error(&b.0);
        b.0["nodes"][2].as_object_mut().unwrap().remove("skin");
        read_json(&b.0);
        text
    };
    assert!(reason(&|d| d["skins"] = json!([])).contains("uses skin 0, but there are 0"));
    assert!(reason(&|d| d["skins"] = json!([{ "joints": "all" }])).contains("skin 0 is not that of a glTF file"));
    assert!(reason(&|d| d["skins"][0]["joints"] = json!([0, 9])).contains("a skin names node 9, but there are 4"));
    assert!(
        reason(&|d| d["skins"][0]["joints"] = json!([0]))
            .contains("primitive 0 of mesh 0 uses joint 1, but its skin has 1")
    );
    assert!(reason(&|d| d["skins"][0]["inverseBindMatrices"] = 99.into()).contains("uses accessor 99"));
    let mut b = skinned();
    let short = b.joints(&[0; 8]);
    b.0["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = short.into();
    assert!(error(&b.0).contains("has 3 positions, but 2 elements in accessor"));
    let mut b = skinned();
    b.node(json!({ "children": [5] }));
    b.node(json!({ "children": [4] }));
    b.0["scenes"] = json!([{ "nodes": [3] }]);
    b.0["skins"][0]["joints"] = json!([0, 5]);
    assert!(error(&b.0).contains("node 5 is its own descendant"));
}

#[test]
fn a_skinned_mesh_is_not_instanced_but_told_of() {
    let mut b = skinned();
    b.0["nodes"][2]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } } });
    let scene = read_json(&b.0);
    assert_eq!((scene.instances.len(), scene.report.uninstanced_skins), (1, 1));
    assert_eq!(scene.meshes[0].positions, POSED);
}

#[test]
fn a_skin_far_off_keeps_its_shape() {
    let mut b = skinned();
    for joint in [0, 1] {
        b.0["nodes"][joint]["translation"] = json!([4649776.75, 0.001, 0]);
    }
    let scene = read_json(&b.0);
    let (mesh, instance) = (&scene.meshes[0], &scene.instances[0]);
    let place = |v: usize| instance.transform.transform_point(mesh.positions[v].map(f64::from));
    assert!((place(1)[0] - place(0)[0] - 1.0).abs() < 1e-7 && (place(0)[1] - 0.001).abs() < 1e-9);
    assert_eq!(
        Affine::from_f32(&instance.transform.to_f32()),
        instance.transform,
        "a file can state the origin exactly"
    );

    // Beyond what any file can state.
    for joint in [0, 1] {
        b.0["nodes"][joint]["translation"] = json!([1e39, 0, 0]);
    }
    let report = read_json(&b.0).report;
    assert_eq!((report.out_of_range_instances, report.non_finite_triangles), (1, 0));
}
