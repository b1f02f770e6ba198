//! Extensions that a file requires: honoured, refused or passed, as the table says.

use super::*;
use crate::scene::gltf::extensions::extension as gltf_extension;
use crate::scene::{GLTF_EXTENSIONS, Treatment};

fn requiring(name: &str) -> Value {
    edited(|d| d["extensionsRequired"] = json!([name]))
}

fn ignoring(names: &[&str]) -> ReadOptions {
    ReadOptions { ignore_extensions: names.iter().map(|n| n.to_string()).collect(), ..options() }
}

fn try_with(document: &Value, options: &ReadOptions) -> Result<Scene, SceneError> {
    read_bytes(document.to_string().into_bytes(), "test.gltf", Some(Format::Gltf), None, options)
}

#[test]
fn every_row_of_the_table_is_what_reading_does() {
    for row in GLTF_EXTENSIONS {
        let name = row.name.replace('*', "x");
        assert_eq!(gltf_extension(&name).map(|r| r.name), Some(row.name), "another row comes first");
        match (row.treatment, try_read(&requiring(&name))) {
            (Treatment::Refused, Err(error)) => {
                let text = error.to_string();
                assert_eq!(error.kind(), ErrorKind::Unsupported, "{text}");
                assert!(text.contains(&name) && text.contains(row.why), "{text}");
                assert!(matches!(error, SceneError::UnsupportedExtension { ignorable: true, .. }), "{text}");
                let scene = try_with(&requiring(&name), &ignoring(&[&name])).unwrap();
                assert_eq!(scene.report.ignored_extensions, [name]);
            }
            (Treatment::Honoured | Treatment::Decoded | Treatment::Played | Treatment::Passed, Ok(scene)) => {
                assert_eq!(scene.report.ignored_extensions, [""; 0], "{name}");
            }
            (_, result) => panic!("{name}: {:?}", result.map(|s| s.report)),
        }
    }
}

/// Files that do not list what stands on their nodes are read as if they did, and so is what is ignored of it told.
#[test]
fn ignoring_what_stands_on_nodes_is_told_though_it_is_not_listed() {
    for (name, block) in
        [("EXT_mesh_gpu_instancing", json!({ "attributes": {} })), ("KHR_node_visibility", json!({ "visible": false }))]
    {
        let document = edited(|d| d["nodes"][0]["extensions"] = json!({ name: block }));
        let scene = try_with(&document, &ignoring(&[name])).unwrap();
        assert_eq!(scene.report.ignored_extensions, [name]);
        let plain = try_with(&edited(|_| ()), &ignoring(&[name])).unwrap();
        assert_eq!(plain.report.ignored_extensions, [""; 0], "{name} is not there");
    }
}

#[test]
fn an_unknown_extension_is_refused_where_it_is_required_and_not_ignored() {
    let error = try_read(&requiring("ACME_gizmo")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unsupported);
    assert!(
        matches!(&error, SceneError::UnsupportedExtension { extension, ignorable: true, .. } if extension == "ACME_gizmo"),
        "{error}"
    );
    assert!(try_with(&requiring("ACME_gizmo"), &ignoring(&["ACME_gizmos"])).is_err());
    let scene = try_with(&requiring("ACME_gizmo"), &ignoring(&["ACME_gizmo"])).unwrap();
    assert_eq!(scene.report.ignored_extensions, ["ACME_gizmo"]);

    // What the file only uses says itself that it may be ignored; what may place triangles is told all the same.
    let used = edited(|d| d["extensionsUsed"] = json!(["ACME_gizmo", "CESIUM_RTC", "KHR_materials_unlit"]));
    assert_eq!(read_json(&used).report.ignored_extensions, ["CESIUM_RTC"]);
    let there = |d: &mut Value| d["extensions"] = json!({ "CESIUM_RTC": { "center": [1, 2, 3] }, "ACME_gizmo": 3 });
    assert_eq!(read_json(&edited(there)).report.ignored_extensions, ["CESIUM_RTC"], "it need not be listed");
    assert!(try_read(&edited(|d| d["extensions"] = json!(["CESIUM_RTC"]))).is_ok());
    for place in
        ["/nodes/0", "/meshes/0/primitives/0", "/accessors/0", "/bufferViews/0", "/nodes/0/extensions/ACME_gizmo"]
    {
        let on = |d: &mut Value| {
            d["nodes"][0]["extensions"]["ACME_gizmo"] = json!({});
            d.pointer_mut(place).unwrap()["extensions"]["AGI_articulations"] =
                json!({ "stages": [1, null, "a", -2, 0.5, true] });
        };
        assert_eq!(read_json(&edited(on)).report.ignored_extensions, ["AGI_articulations"], "on {place}");
    }
    let own = |d: &mut Value| d["nodes"][0]["extras"] = json!({ "extensions": { "AGI_articulations": {} } });
    assert!(read_json(&edited(own)).report.ignored_extensions.is_empty(), "extras are the application's");
    assert!(try_read(&edited(|d| d["extensionsUsed"] = json!({ "a": 3 }))).is_ok());
}

#[test]
fn hidden_nodes_and_all_below_them_are_left_out_and_counted() {
    let hidden = |visible: bool| json!({ "KHR_node_visibility": { "visible": visible } });
    let document = edited(|d| {
        d["nodes"] = json!([
            { "children": [1, 2], "extensions": hidden(false) },
            { "mesh": 0, "extensions": hidden(true) },
            { "mesh": 0 },
            { "mesh": 0, "extensions": hidden(true) },
            { "mesh": 0, "extensions": { "KHR_node_visibility": {} } },
        ]);
        d["scenes"] = json!([{ "nodes": [0, 3, 4] }]);
    });
    let scene = read_json(&document);
    assert_eq!(scene.instances.iter().map(|i| i.node).collect::<Vec<_>>(), [3, 4]);
    assert_eq!(scene.report.hidden_nodes, 2);
    let all = try_with(&document, &ignoring(&["KHR_node_visibility"])).unwrap();
    assert_eq!((all.instances.len(), all.report.hidden_nodes), (4, 0));
}

#[test]
fn instancing_that_is_ignored_places_the_mesh_once() {
    let document = edited(|d| {
        d["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
        d["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = json!({ "TRANSLATION": 0 });
    });
    assert_eq!(read_json(&document).instances.len(), 4);
    let once = try_with(&document, &ignoring(&["EXT_mesh_gpu_instancing"])).unwrap();
    assert_eq!((once.instances.len(), once.report.ignored_extensions.len()), (1, 1));
}

#[test]
fn data_that_stand_only_in_a_compressed_form_cannot_be_ignored() {
    let mut document = edited(|d| {
        d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        d["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = json!({});
    });
    assert!(try_read(&document).is_err());
    assert!(try_with(&document, &ignoring(&["KHR_draco_mesh_compression"])).is_ok());
    document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let error = try_with(&document, &ignoring(&["KHR_draco_mesh_compression"])).unwrap_err();
    assert!(matches!(&error, SceneError::UnsupportedExtension { ignorable: false, .. }), "{error}");

    let meshopt = edited(|d| {
        d["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
        d["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = json!({ "buffer": 0 });
    });
    assert!(try_read(&meshopt).is_err());
    assert!(try_with(&meshopt, &ignoring(&["EXT_meshopt_compression"])).is_ok());
}

#[test]
fn compressed_geometry_is_refused_by_name_unless_plain_data_stand_beside_it() {
    let draco = |d: &mut Value| {
        d["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] =
            json!({ "bufferView": 0, "attributes": {} });
    };
    assert_eq!(read_json(&edited(draco)).meshes[0].triangles.len(), 1);
    let required = edited(|d| {
        draco(d);
        d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    });
    let no_data = edited(|d| {
        draco(d);
        d["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    });
    let meshopt = edited(|d| {
        d["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = json!({ "buffer": 0 });
        d["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    });
    let meshopt_fallback = edited(|d| {
        d["buffers"][0] =
            json!({ "byteLength": 76, "extensions": { "KHR_meshopt_compression": { "fallback": true } } });
    });
    // The surest way out is to decode the model, so no other is offered.
    for (document, name) in [
        (required, "KHR_draco_mesh_compression"),
        (no_data, "KHR_draco_mesh_compression"),
        (meshopt, "EXT_meshopt_compression"),
        (meshopt_fallback, "KHR_meshopt_compression"),
    ] {
        let error = try_read(&document).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Unsupported);
        let SceneError::UnsupportedExtension { extension, ignorable, .. } = &error else { panic!("{error}") };
        assert_eq!((extension.as_str(), *ignorable), (name, false), "{error}");
    }
}
