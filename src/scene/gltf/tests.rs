mod animation;
mod animation_choice;
mod animation_poses;
mod extensions;
mod files;
mod identity;
mod morphs;
mod places;
mod skins;

use crate::scene::{Degenerate, ErrorKind, Format, ReadOptions, Scene, SceneError, read_bytes};
use base64::Engine;
use serde_json::{Value, json};

fn options() -> ReadOptions {
    ReadOptions { degenerate: Degenerate::Keep, ..ReadOptions::default() }
}

fn try_read(document: &Value) -> Result<Scene, SceneError> {
    let text = document.to_string().into_bytes();
    read_bytes(text, "test.gltf", Some(Format::Gltf), None, &options())
}

fn read_json(document: &Value) -> Scene {
    try_read(document).unwrap_or_else(|e| panic!("{e}\n{document}"))
}

fn error(document: &Value) -> String {
    let error = try_read(document).expect_err("it should be refused");
    assert_eq!(error.kind(), ErrorKind::BadModel, "{error}");
    error.to_string()
}

fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

fn le(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Four corners of a square, then the indices 0 1 2 3 as u8 (at 48), u16 (at 52) and u32 (at 60); 76 bytes.
fn square_bytes() -> Vec<u8> {
    let mut bytes = le(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    bytes.extend([0, 1, 2, 3]);
    bytes.extend([0u16, 1, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
    bytes.extend([0u32, 1, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// A square in one mesh on one node; views and accessors: 0 positions, 1 u8, 2 u16, 3 u32 indices.
fn square() -> Value {
    let bytes = square_bytes();
    json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": bytes.len(), "uri": data_uri(&bytes) }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 4 },
            { "buffer": 0, "byteOffset": 52, "byteLength": 8 },
            { "buffer": 0, "byteOffset": 60, "byteLength": 16 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4 },
            { "bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 4 },
            { "bufferView": 2, "componentType": 5123, "type": "SCALAR", "count": 4 },
            { "bufferView": 3, "componentType": 5125, "type": "SCALAR", "count": 4 },
        ],
        "meshes": [{ "name": "square", "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "nodes": [{ "mesh": 0 }],
    })
}

fn edited(edit: impl FnOnce(&mut Value)) -> Value {
    let mut document = square();
    edit(&mut document);
    document
}

#[test]
fn modes_and_index_types() {
    let want = |mode: u32| match mode {
        4 => vec![[0, 1, 2]],
        5 => vec![[0, 1, 2], [1, 3, 2]],
        6 => vec![[1, 2, 0], [2, 3, 0]],
        _ => vec![],
    };
    for mode in 0..7 {
        for indices in [None, Some(1), Some(2), Some(3)] {
            let scene = read_json(&edited(|d| {
                let primitive = &mut d["meshes"][0]["primitives"][0];
                primitive["mode"] = mode.into();
                indices.inspect(|i| primitive["indices"] = (*i).into());
            }));
            let triangles = scene.meshes.first().map(|m| m.triangles.clone()).unwrap_or_default();
            assert_eq!(triangles, want(mode), "mode {mode}, indices {indices:?}");
            assert_eq!(scene.report.skipped_primitives, u64::from(mode < 4));
        }
    }
    assert!(error(&edited(|d| d["meshes"][0]["primitives"][0]["mode"] = 7.into())).contains("mode"));
}

#[test]
fn restart_values_begin_a_new_strip_or_fan() {
    let mut bytes = square_bytes();
    bytes.extend([0, 1, 2, 255, 1, 2, 3]);
    let with = |mode: u32| {
        edited(|d| {
            d["buffers"][0] = json!({ "byteLength": bytes.len(), "uri": data_uri(&bytes) });
            d["bufferViews"][1] = json!({ "buffer": 0, "byteOffset": 76, "byteLength": 7 });
            d["accessors"][1]["count"] = 7.into();
            d["meshes"][0]["primitives"][0]["indices"] = 1.into();
            d["meshes"][0]["primitives"][0]["mode"] = mode.into();
        })
    };
    assert_eq!(read_json(&with(5)).meshes[0].triangles, [[0, 1, 2], [1, 2, 3]]);
    assert_eq!(read_json(&with(6)).meshes[0].triangles, [[1, 2, 0], [2, 3, 1]]);
    assert!(error(&with(4)).contains("uses vertex 255, but has 4"));
}

#[test]
fn strides_and_offsets() {
    let mut bytes = vec![0xff; 7];
    for p in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        bytes.extend(le(&p));
        bytes.extend([0xff; 4]);
    }
    bytes.truncate(bytes.len() - 4); // the last element ends the view
    let document = edited(|d| {
        d["buffers"][0] = json!({ "byteLength": bytes.len(), "uri": data_uri(&bytes) });
        d["bufferViews"][0] = json!({ "buffer": 0, "byteOffset": 4, "byteLength": bytes.len() - 4, "byteStride": 16 });
        d["accessors"][0] =
            json!({ "bufferView": 0, "byteOffset": 3, "componentType": 5126, "type": "VEC3", "count": 3 });
    });
    assert_eq!(read_json(&document).meshes[0].corners(0), [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let mut short = document.clone();
    short["accessors"][0]["byteOffset"] = 4.into();
    assert!(error(&short).contains("accessor 0 has 3 elements of 16 bytes from byte 4 on, but buffer view 0 has"));
    let mut narrow = document.clone();
    narrow["bufferViews"][0]["byteStride"] = 8.into();
    assert!(error(&narrow).contains("byteStride of buffer view 0 is 8"));
}

#[test]
fn quantized_positions() {
    let cases = [
        (5120, vec![0x81, 0x7f, 0x80, 0], [-1.0, 1.0, -1.0], [-127.0, 127.0, -128.0]),
        (5121, vec![0xff, 0, 51, 0], [1.0, 0.0, 0.2], [255.0, 0.0, 51.0]),
        (5122, vec![1, 0x80, 0xff, 0x7f, 0, 0x80, 0, 0], [-1.0, 1.0, -1.0], [-32767.0, 32767.0, -32768.0]),
        (5123, vec![0xff, 0xff, 0, 0, 0x33, 0x33, 0, 0], [1.0, 0.0, 0.2], [65535.0, 0.0, 13107.0]),
    ];
    for (component, first, normalized, plain) in cases {
        let stride = first.len();
        let mut bytes = first.clone();
        bytes.extend(first.iter().map(|b| b ^ 1));
        bytes.extend(first.iter().rev());
        for is_normalized in [false, true] {
            let scene = read_json(&edited(|d| {
                d["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
                d["buffers"][0] = json!({ "byteLength": bytes.len(), "uri": data_uri(&bytes) });
                d["bufferViews"][0] = json!({ "buffer": 0, "byteLength": bytes.len(), "byteStride": stride });
                d["accessors"][0] = json!({ "bufferView": 0, "componentType": component, "type": "VEC3", "count": 3,
                    "normalized": is_normalized });
            }));
            let want: [f32; 3] = if is_normalized { normalized } else { plain };
            assert_eq!(scene.meshes[0].corners(0)[0], want, "{component} {is_normalized}");
        }
    }
}

#[test]
fn sparse_accessors_with_and_without_a_base() {
    let mut bytes = square_bytes();
    bytes.extend([2, 0, 0, 0]);
    bytes.extend(le(&[5.0, 6.0, 7.0]));
    let sparse =
        json!({ "count": 1, "indices": { "bufferView": 4, "componentType": 5121 }, "values": { "bufferView": 5 } });
    let document = edited(|d| {
        d["buffers"][0] = json!({ "byteLength": bytes.len(), "uri": data_uri(&bytes) });
        let views = d["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": 76, "byteLength": 4 }));
        views.push(json!({ "buffer": 0, "byteOffset": 80, "byteLength": 12 }));
        d["accessors"][0]["sparse"] = sparse.clone();
    });
    assert_eq!(read_json(&document).meshes[0].corners(0), [[0.0; 3], [1.0, 0.0, 0.0], [5.0, 6.0, 7.0]]);

    let mut without = document.clone();
    without["accessors"][0] = json!({ "componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse });
    assert_eq!(read_json(&without).meshes[0].corners(0), [[0.0; 3], [0.0; 3], [5.0, 6.0, 7.0]]);

    without["accessors"][0]["count"] = 2.into();
    assert!(error(&without).contains("accessor 0 replaces element 2, but has 2"));
    without["accessors"][0]["count"] = 1_000_000_000_000u64.into();
    assert_eq!(try_read(&without).unwrap_err().kind(), ErrorKind::Limit);
    let mut many = document.clone();
    many["accessors"][0]["sparse"]["count"] = 2.into();
    assert!(error(&many).contains("the sparse values of accessor 0"));
    for count in [5, u64::MAX] {
        many["accessors"][0]["sparse"]["count"] = count.into();
        assert!(error(&many).contains(&format!("accessor 0 replaces {count} elements, but has 4")));
    }
}

#[test]
fn absurd_counts_and_offsets_are_refused_before_they_are_believed() {
    for count in [5u64, 1 << 32, 1 << 62, u64::MAX] {
        assert!(error(&edited(|d| d["accessors"][0]["count"] = count.into())).contains("accessor 0"), "{count}");
        assert!(error(&edited(|d| d["accessors"][0]["byteOffset"] = count.into())).contains("accessor 0"), "{count}");
        let offset = edited(|d| d["bufferViews"][0]["byteOffset"] = (count.saturating_add(24)).into());
        assert!(error(&offset).contains("buffer view 0 takes 48 bytes"), "{count}");
        let stride = edited(|d| d["bufferViews"][0]["byteStride"] = (count.max(17)).into());
        assert!(error(&stride).contains("accessor 0"), "{count}");
    }
    assert!(
        error(&edited(|d| d["buffers"][0]["byteLength"] = 77.into()))
            .contains("has 76 bytes, but its byteLength says 77")
    );
    assert!(error(&edited(|d| d["bufferViews"][0]["buffer"] = 9.into())).contains("uses buffer 9, but there are 1"));
    assert!(error(&edited(|d| d["accessors"][0]["bufferView"] = 9.into())).contains("uses buffer view 9, but has 4"));
    let positions = edited(|d| d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9.into());
    assert!(error(&positions).contains("uses accessor 9, but there are 4"));
    assert!(error(&edited(|d| d["nodes"][0]["mesh"] = 9.into())).contains("node 0 shows mesh 9, but there are 1"));
    let wrong_type = edited(|d| d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 1.into());
    assert!(error(&wrong_type).contains("accessor 1 holds SCALAR of UNSIGNED_BYTE; its use here needs VEC3 of FLOAT"));
}

#[test]
fn node_transforms_compose_from_root_to_leaf() {
    let scene = read_json(&edited(|d| {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        d["nodes"] = json!([
            { "children": [1], "translation": [10, 0, 0] },
            { "children": [2], "rotation": [0, 0, half, half], "scale": [2, 2, 2] },
            { "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1], "name": "leaf" },
        ]);
        d["scenes"] = json!([{ "nodes": [0] }]);
    }));
    assert_eq!((scene.instances.len(), scene.instances[0].node, scene.instances[0].name.as_str()), (1, 2, "leaf"));
    let moved = scene.instances[0].transform.transform_point([1.0, 0.0, 0.0]);
    for (got, want) in moved.iter().zip([10.0, 2.0, 10.0]) {
        assert!((got - want).abs() < 1e-6, "{moved:?}");
    }
}

#[test]
fn a_mesh_on_several_nodes_is_stored_once_and_unused_meshes_are_left_out() {
    let scene = read_json(&edited(|d| {
        let primitives = d["meshes"][0]["primitives"].clone();
        d["meshes"] = json!([{ "primitives": primitives }, { "primitives": [] }, { "primitives": primitives }]);
        d["nodes"] = json!([{ "mesh": 2 }, { "mesh": 1 }, { "mesh": 2, "translation": [1, 0, 0] }]);
    }));
    assert_eq!(scene.meshes.len(), 1);
    assert_eq!(scene.instances.iter().map(|i| (i.mesh, i.node)).collect::<Vec<_>>(), [(0, 0), (0, 2)]);
    assert_eq!(scene.meshes[0].parts[0].source_mesh, 2);
    assert_eq!(scene.instanced_triangles(), 2);
}

#[test]
fn primitives_share_positions_and_become_parts() {
    let scene = read_json(&edited(|d| {
        d["meshes"][0]["primitives"] = json!([
            { "attributes": { "POSITION": 0 }, "indices": 1, "mode": 5 },
            { "attributes": { "POSITION": 0 }, "mode": 1 },
            { "attributes": { "NORMAL": 0 } },
            { "attributes": { "POSITION": 0 }, "indices": 3 },
        ]);
    }));
    let mesh = &scene.meshes[0];
    assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.name.as_str()), (4, 3, "square"));
    assert_eq!(
        mesh.parts.iter().map(|p| (p.source_part, p.first_prim, p.prim_count)).collect::<Vec<_>>(),
        [(0, 0, 2), (3, 2, 1)]
    );
    assert_eq!(scene.report.skipped_primitives, 2);
}

#[test]
fn scenes_are_chosen_by_request_default_and_order() {
    let document = edited(|d| {
        d["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "children": [2] }, { "mesh": 0 }]);
        d["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }, {}]);
    });
    let instances = |document: &Value, scene: Option<u32>| {
        let options = ReadOptions { scene, ..options() };
        read_bytes(document.to_string().into_bytes(), "test.gltf", None, None, &options).map(|s| s.instances.len())
    };
    let mut with_default = document.clone();
    with_default["scene"] = 1.into();
    let mut none = document.clone();
    none["scenes"] = json!([]);
    assert_eq!(instances(&document, None).unwrap(), 1);
    assert_eq!(instances(&with_default, None).unwrap(), 2);
    assert_eq!(instances(&with_default, Some(0)).unwrap(), 1);
    assert_eq!(instances(&document, Some(2)).unwrap(), 0);
    assert_eq!(instances(&none, None).unwrap(), 3);
    assert!(
        instances(&document, Some(3))
            .unwrap_err()
            .to_string()
            .contains("it has no scene 3; its scenes are numbered from 0 to 2")
    );
    assert!(instances(&none, Some(0)).unwrap_err().to_string().contains("it has no scenes that could be chosen"));
    with_default["scene"] = 7.into();
    assert!(error(&with_default).contains("its default scene is 7"));
}

#[test]
fn broken_node_graphs_are_refused() {
    let nodes = |nodes: Value| {
        edited(|d| {
            d["nodes"] = nodes;
            d["scenes"] = json!([{ "nodes": [0] }]);
        })
    };
    assert!(error(&nodes(json!([{ "children": [0] }]))).contains("node 0 is reached twice"));
    assert!(error(&nodes(json!([{ "children": [1] }, { "children": [0] }]))).contains("node 0 is reached twice"));
    assert!(
        error(&nodes(json!([{ "children": [1, 2] }, { "children": [2] }, {}]))).contains("node 2 is reached twice")
    );
    assert!(error(&nodes(json!([{ "children": [5] }]))).contains("names node 5, but there are 1"));
    let projective = [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    assert!(error(&nodes(json!([{ "mesh": 0, "matrix": projective }]))).contains("last row"));
}

#[test]
fn a_hierarchy_of_any_depth_is_walked() {
    let depth = 200_000;
    let mut nodes: Vec<Value> = (1..=depth).map(|i| json!({ "children": [i] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    let scene = read_json(&edited(|d| d["nodes"] = nodes.into()));
    assert_eq!(scene.instances[0].node, depth);
}

#[test]
fn gpu_instancing_places_a_mesh_many_times() {
    let mut bytes = square_bytes();
    bytes.extend(le(&[1.0, 0.0, 0.0, 2.0, 0.0, 0.0])); // at 76: two translations
    bytes.extend([0, 0, 127, 0, 0, 0, 0, 127]); // at 100: half a turn about z, none
    let document = edited(|d| {
        d["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
        d["buffers"][0] = json!({ "byteLength": bytes.len(), "uri": data_uri(&bytes) });
        d["bufferViews"].as_array_mut().unwrap().extend([
            json!({ "buffer": 0, "byteOffset": 76, "byteLength": 24 }),
            json!({ "buffer": 0, "byteOffset": 100, "byteLength": 8 }),
        ]);
        d["accessors"].as_array_mut().unwrap().extend([
            json!({ "bufferView": 4, "componentType": 5126, "type": "VEC3", "count": 2 }),
            json!({ "bufferView": 5, "componentType": 5120, "type": "VEC4", "count": 2, "normalized": true }),
        ]);
        let attributes = json!({ "TRANSLATION": 4, "ROTATION": 5, "_ID": 1 });
        d["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
        d["nodes"][0]["translation"] = json!([0, 0, 3]);
    });
    let scene = read_json(&document);
    let image = |i: usize| scene.instances[i].transform.transform_point([1.0, 0.0, 0.0]);
    assert_eq!((scene.instances.len(), scene.meshes.len()), (2, 1));
    assert_eq!((image(0), image(1)), ([0.0, 0.0, 3.0], [3.0, 0.0, 3.0]));

    let mut unequal = document.clone();
    unequal["accessors"][5]["count"] = 1.into();
    assert!(error(&unequal).contains("attributes of 2 and of 1 elements"));
    let mut huge = document.clone();
    for accessor in [4, 5] {
        huge["accessors"][accessor]["count"] = 1_000_000_000_000u64.into();
    }
    assert!(error(&huge).contains("accessor 4"));
    let mut none = document.clone();
    none["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = json!({});
    assert!(error(&none).contains("has no attributes"));
}

#[test]
fn versions_and_broken_json() {
    let version =
        |asset: Value| try_read(&edited(|d| d["asset"] = asset)).map(drop).map_err(|e| (e.kind(), e.to_string()));
    assert!(version(json!({ "version": "2.1" })).is_ok());
    for asset in [json!({ "version": "1.0" }), json!({ "version": "2.0", "minVersion": "2.1" })] {
        assert_eq!(version(asset).unwrap_err().0, ErrorKind::Unsupported);
    }
    for text in ["", "{", "[]", "{}", "nonsense", "{\"asset\":{\"version\":\"2.0\"},\"nodes\":3}"] {
        let error = read_bytes(text.into(), "test.gltf", Some(Format::Gltf), None, &options()).unwrap_err();
        assert!(error.kind() == ErrorKind::BadModel && error.to_string().len() > 40, "{text}: {error}");
    }
    let with_bom = [b"\xef\xbb\xbf".to_vec(), square().to_string().into_bytes()].concat();
    assert!(read_bytes(with_bom, "test.gltf", None, None, &options()).is_ok());
    let deep =
        format!("{{\"asset\":{{\"version\":\"2.0\"}},\"extras\":{}{}}}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(read_bytes(deep.into(), "test.gltf", None, None, &options()).is_ok());
    let nested = format!("{}{}", "{\"x\":".repeat(100_000), "0".to_owned() + &"}".repeat(100_000));
    let deep = |name: &str| {
        format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{{\"extensions\":{{\"{name}\":{nested}}}}}]}}")
    };
    assert!(read_bytes(deep("EXT_mesh_gpu_instancing").into(), "test.gltf", None, None, &options()).is_err());
    assert!(read_bytes(deep("ACME_gizmo").into(), "test.gltf", None, None, &options()).is_ok());
}
