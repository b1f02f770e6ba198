//! From a triangle back to its mesh, primitive, number and corners in the file; names.

use super::*;

/// Eight corners, of which 3 repeats 2, so that some triangles have no area; indices with restart values.
fn strips() -> (Vec<[f32; 3]>, Vec<u8>) {
    let corners = [[0., 0.], [1., 0.], [0., 1.], [0., 1.], [1., 2.], [2., 2.], [3., 0.], [4., 1.]];
    let indices = vec![0, 1, 2, 3, 4, 5, 255, 6, 7, 255, 255, 4, 5, 6, 6, 7, 0, 1];
    (corners.map(|[x, y]: [f32; 2]| [x, y, x * y]).to_vec(), indices)
}

/// Triangle `number` of a run of indices by the specification's formulas, restart values dividing it (glTF 2.0, 3.7.2.1).
fn by_formula(mode: u32, indices: &[u8], number: usize) -> [u8; 3] {
    let mut before = 0;
    for run in indices.split(|i| *i == 255 && mode != 4) {
        let count = if mode == 4 { run.len() / 3 } else { run.len().saturating_sub(2) };
        if number >= before + count {
            before += count;
            continue;
        }
        let i = number - before;
        return match mode {
            4 => [run[3 * i], run[3 * i + 1], run[3 * i + 2]],
            5 => [run[i], run[i + (1 + i % 2)], run[i + (2 - i % 2)]],
            _ => [run[i + 1], run[i + 2], run[0]],
        };
    }
    panic!("there is no triangle {number}");
}

#[test]
fn every_triangle_that_is_kept_leads_back_to_its_corners_in_the_file() {
    let (corners, strip) = strips();
    let list: Vec<u8> = strip.iter().copied().filter(|i| *i != 255).collect();
    let mut bytes: Vec<u8> = corners.iter().flat_map(|c| le(c)).collect();
    let at = bytes.len();
    bytes.extend(&strip);
    bytes.extend(&list);
    let document = edited(|d| {
        d["buffers"][0] = json!({ "byteLength": bytes.len(), "uri": data_uri(&bytes) });
        d["bufferViews"] = json!([
            { "buffer": 0, "byteLength": at },
            { "buffer": 0, "byteOffset": at, "byteLength": strip.len() },
            { "buffer": 0, "byteOffset": at + strip.len(), "byteLength": list.len() },
        ]);
        d["accessors"] = json!([
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": corners.len() },
            { "bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": strip.len() },
            { "bufferView": 2, "componentType": 5121, "type": "SCALAR", "count": list.len() },
        ]);
        let primitive =
            |indices: u32, mode: u32| json!({ "attributes": { "POSITION": 0 }, "indices": indices, "mode": mode });
        let primitives = [primitive(1, 1), primitive(1, 5), primitive(2, 4), primitive(1, 6)];
        d["meshes"] = json!([{ "primitives": [] }, { "primitives": primitives }]);
        d["nodes"] = json!([{ "mesh": 1 }]);
    });
    let options = ReadOptions { degenerate: Degenerate::Drop, vertices: true, ..options() };
    let scene = read_bytes(document.to_string().into_bytes(), "test.gltf", None, None, &options).unwrap();
    let mesh = &scene.meshes[0];
    assert!(scene.report.degenerate_triangles >= 6 && mesh.triangles.len() >= 8, "{:?}", scene.report);
    let mut seen = 0;
    for part in &mesh.parts {
        let (indices, mode) = [(&strip, 1), (&strip, 5), (&list, 4), (&strip, 6)][part.source_part as usize];
        assert_eq!(part.source_mesh, 1);
        for triangle in part.first_triangle..part.first_triangle + part.triangle_count {
            let number = mesh.source_prim(triangle as usize) - part.first_prim;
            assert!(number < part.prim_count);
            let vertices = by_formula(mode, indices, number as usize);
            assert_eq!(mesh.vertices[triangle as usize], vertices.map(u32::from), "mode {mode}, triangle {number}");
            let in_file = vertices.map(|v| corners[v as usize]);
            assert_eq!(mesh.corners(triangle as usize), in_file, "mode {mode}, triangle {number}");
            seen += 1;
        }
    }
    assert_eq!(seen, mesh.triangles.len());
}

#[test]
fn parts_bear_the_names_of_mesh_and_material_letter_by_letter() {
    let names = [" roof\t", "a/b", "Dach\u{AD}ziegel \u{1f3e0}\r\n", "", "µ\u{0}x"];
    for name in names {
        let scene = read_json(&edited(|d| {
            d["meshes"][0]["name"] = name.into();
            d["materials"] = json!([{ "pbrMetallicRoughness": {} }, 7, { "name": name }]);
            let primitive = |material: u32| json!({ "attributes": { "POSITION": 0 }, "material": material });
            d["meshes"][0]["primitives"] = (0..4).map(primitive).collect();
        }));
        assert_eq!(scene.report.absent_materials, 1, "there are three");
        let parts: Vec<_> = scene.meshes[0].parts.iter().map(|p| (p.name.as_str(), p.material.as_str())).collect();
        assert_eq!(parts, [(name, ""), (name, ""), (name, name), (name, "")]);
    }
}

#[test]
fn broken_materials_and_animations_do_not_matter_and_clips_are_counted() {
    for broken in [json!(3), json!({ "a": [] }), json!([null, [], { "name": 3 }])] {
        read_json(&edited(|d| d["materials"] = broken.clone()));
        read_json(&edited(|d| d["animations"] = broken.clone()));
    }
    let scene = read_json(&edited(|d| d["animations"] = json!([{}, { "channels": 3 }])));
    assert_eq!(scene.report.unplayed_animations, 2);
}

#[test]
fn errors_of_json_cite_no_embedded_data() {
    let payload = "A".repeat(5000);
    let text = square().to_string();
    for broken in [
        text.replace("\"bufferViews\":[", &format!("\"bufferViews\":[\"data:;base64,{payload}\",")),
        text.replace("\"nodes\":[", &format!("\"nodes\":[\"{payload}\",")),
        text.replace("\"meshes\":[", "\"meshes\":[\"data:,AAAA\","),
    ] {
        assert_ne!(broken, text);
        let error = read_bytes(broken.into(), "test.gltf", None, None, &options()).unwrap_err().to_string();
        assert!(!error.contains("AAAA") && error.len() < 400 && error.contains("invalid type"), "{error}");
    }
}

#[test]
fn whole_numbers_may_be_decimals_and_the_last_of_equal_keys_counts() {
    let text = square().to_string();
    let decimal = text.replace("\"count\":4", "\"count\":4.0").replace("\"POSITION\":0", "\"POSITION\":0e0");
    let repeated = text.replace("{\"mesh\":0}", "{\"mesh\":9,\"name\":\"a\",\"mesh\":0,\"translation\":[0.1,0,0]}");
    for changed in [decimal, repeated.clone(), text.replacen('{', "{\"nodes\":3,\"asset\":null,", 1)] {
        assert_ne!(changed, text);
        let scene = read_bytes(changed.into(), "test.gltf", None, None, &options()).unwrap();
        assert_eq!(scene.instanced_triangles(), 1);
    }
    let scene = read_bytes(repeated.into(), "test.gltf", None, None, &options()).unwrap();
    assert_eq!(scene.instances[0].transform.rows[0][3], 0.1);

    // An extension's numbers too.
    let instanced = edited(|d| {
        let places = json!({ "attributes": { "TRANSLATION": 4.0 } });
        let positions = d["accessors"][0].clone();
        d["accessors"].as_array_mut().unwrap().push(positions);
        d["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": places });
    });
    assert!(instanced.to_string().contains("\"TRANSLATION\":4.0"));
    assert_eq!(read_json(&instanced).instances.len(), 4);
}

#[test]
fn the_only_place_that_is_left_of_several_is_named() {
    let nodes = |second: Value| {
        read_json(&edited(|d| d["nodes"] = json!([{ "mesh": 0, "scale": [0, 0, 0] }, second]))).meshes[0].parts[0]
            .baked_node
    };
    assert_eq!(nodes(json!({ "mesh": 0 })), Some(1));
    assert_eq!(nodes(json!({ "mesh": 0, "translation": [1, 0, 0] })), None, "baking names it");
    assert_eq!(read_json(&square()).meshes[0].parts[0].baked_node, None);
}
