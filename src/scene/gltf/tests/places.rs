//! Node numbers as doubles, and transforms without inverse or beyond `f32`.

use super::*;
use crate::geom::Affine;

#[test]
fn node_numbers_are_read_as_doubles() {
    let place = |node: Value| {
        read_json(&edited(|d| {
            d["nodes"] = json!([{ "children": [1], "translation": [4649776.7501, 0.1, 1e-9] }, node]);
            d["scenes"] = json!([{ "nodes": [0] }]);
        }))
        .instances[0]
            .transform
    };
    assert_eq!(place(json!({ "mesh": 0 })).rows.map(|r| r[3]), [4649776.7501, 0.1, 1e-9]);
    let child = json!({ "mesh": 0, "translation": [0.3, 0, 0], "scale": [0.7, 1, 1] });
    assert_eq!(place(child).rows[0], [0.7, 0.0, 0.0, 4649776.7501 + 0.3]);
    let matrix = [0.1, 0.2, 0.3, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.4, 0.0, 0.0, 1.0];
    let placed = place(json!({ "mesh": 0, "matrix": matrix })).rows;
    assert_eq!((placed[0][0], placed[1][0], placed[2][0], placed[0][3]), (0.1, 0.2, 0.3, 4649776.7501 + 0.4));

    // Digits that the nearest double needs all of, and which quick parsing gets wrong by a bit.
    for digits in ["0.3333333333333333148", "9007199254740993.0", "2.2250738585072011e-308", "123456789.12345678e-3"] {
        let text =
            square().to_string().replace("{\"mesh\":0}", &format!("{{\"mesh\":0,\"translation\":[0,{digits},0]}}"));
        let scene = read_bytes(text.into(), "test.gltf", None, None, &options()).unwrap();
        assert_eq!(scene.instances[0].transform.rows[1][3], digits.parse::<f64>().unwrap(), "{digits}");
    }
}

#[test]
fn a_scale_of_zero_along_one_axis_leaves_a_flat_image_and_along_all_nothing() {
    let scene = read_json(&edited(|d| {
        d["nodes"] = json!([
            { "mesh": 0, "scale": [2, 1, 0], "translation": [0, 0, 5] },
            { "mesh": 0 },
            { "mesh": 0, "scale": [0, 0, 0] },
            { "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 2, 2, 2, 1] },
        ]);
    }));
    assert_eq!(scene.report.singular_instances, 1);
    let shown: Vec<_> = scene.instances.iter().map(|i| (i.node, i.mesh, i.transform)).collect();
    assert_eq!(shown, [(0, 1, Affine::IDENTITY), (1, 0, Affine::IDENTITY), (3, 2, Affine::IDENTITY)]);
    assert_eq!(scene.meshes[1].corners(0), [[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [2.0, 1.0, 5.0]]);
    assert_eq!(scene.meshes[2].corners(0), [[2.0, 2.0, 2.0], [3.0, 2.0, 2.0], [3.0, 3.0, 2.0]]);
    let part = |mesh: usize| (scene.meshes[mesh].parts[0].source_mesh, scene.meshes[mesh].parts[0].baked_node);
    assert_eq!((part(0), part(1), part(2)), ((0, None), (0, Some(0)), (0, Some(3))));
}

/// Behind a rotation the zeros of a scale are sums that cancel, all but their rounding.
#[test]
fn what_a_turned_node_flattens_to_a_line_is_left_out_as_behind_a_node_that_is_not() {
    let turns = [[0.0, 0.0, 0.0, 1.0], [0.1, 0.2, 0.3, 0.927], [0.5, 0.5, -0.5, 0.5], [0.3, -0.6, 0.2, 0.714]];
    for turn in turns {
        let length = turn.iter().map(|c: &f64| c * c).sum::<f64>().sqrt();
        let turn = turn.map(|c| c / length);
        let placed = |scale: [f64; 3], inner: [f64; 4]| {
            edited(|d| {
                d["nodes"] = json!([
                    { "children": [1], "rotation": turn, "translation": [3, 4, 5] },
                    { "children": [2], "scale": scale },
                    { "mesh": 0, "rotation": inner },
                    { "mesh": 0 },
                ]);
                d["scenes"] = json!([{ "nodes": [0, 3] }]);
            })
        };
        let line = with(&placed([1.0, 0.0, 0.0], turn), Degenerate::Drop);
        assert_eq!((line.report.singular_instances, line.instances.len()), (1, 1), "{turn:?}");
        let kept = with(&placed([1.0, 0.0, 0.0], turn), Degenerate::Keep);
        assert_eq!((kept.report.singular_instances, kept.instances.len()), (0, 2), "{turn:?}");
        // What keeps an area stays.
        let flat = with(&placed([1.0, 1.0, 0.0], turns[0]), Degenerate::Drop);
        assert_eq!((flat.report.singular_instances, flat.report.degenerate_triangles), (0, 0), "{turn:?}");
    }
}

fn with(document: &Value, degenerate: Degenerate) -> Scene {
    let options = ReadOptions { degenerate, ..options() };
    read_bytes(document.to_string().into_bytes(), "test.gltf", None, None, &options).unwrap()
}

#[test]
fn a_matrix_goes_before_translation_rotation_and_scale_and_that_is_told() {
    let scene = read_json(&edited(|d| {
        d["nodes"] = json!([{ "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 0, 0, 1], "scale": [2, 2, 2] }, { "mesh": 0, "scale": [3, 3, 3] }]);
    }));
    assert_eq!(scene.report.twice_placed_nodes, 1);
    assert_eq!(scene.instances[0].transform.rows[0], [1.0, 0.0, 0.0, 7.0]);
}

/// Its rows differ in their last bits, so that no ray could be taken into the mesh: the determinant cancels away.
#[test]
fn a_transform_whose_inverse_cannot_be_told_leaves_a_flat_image() {
    let u = f64::from(1f32.next_down());
    let scene = read_json(&edited(|d| {
        d["nodes"] = json!([{ "mesh": 0, "matrix": [1, 1, 1, 0, 1, u, 1, 0, 1, 1, u, 0, 0, 0, 5, 1] }, { "mesh": 0 }]);
    }));
    let shown: Vec<_> = scene.instances.iter().map(|i| (i.node, i.mesh, i.transform)).collect();
    assert_eq!(shown, [(0, 1, Affine::IDENTITY), (1, 0, Affine::IDENTITY)]);
    assert_eq!(scene.meshes[1].corners(0), [[0.0, 0.0, 5.0], [1.0, 1.0, 6.0], [2.0, 1.0 + u as f32, 7.0]]);
    assert_eq!(scene.meshes[1].parts[0].baked_node, Some(0));
}

#[test]
fn the_policy_for_triangles_without_area_holds_for_what_is_flattened() {
    let document = edited(|d| {
        d["meshes"][0]["primitives"][0]["indices"] = 1.into();
        d["meshes"][0]["primitives"][0]["mode"] = 5.into();
        d["nodes"][0]["scale"] = json!([1, 0, 1]); // the square stands upright in x and y
    });
    let read = |degenerate| {
        let options = ReadOptions { degenerate, ..options() };
        read_bytes(document.to_string().into_bytes(), "test.gltf", None, None, &options)
    };
    let kept = read(Degenerate::Keep).unwrap();
    assert_eq!((kept.instanced_triangles(), kept.report.degenerate_triangles), (2, 2));
    let dropped = read(Degenerate::Drop).unwrap();
    assert_eq!((dropped.instances.len(), dropped.report.degenerate_triangles), (0, 2));
    assert!(read(Degenerate::Error).unwrap_err().to_string().contains("2 triangles without area"));
}

#[test]
fn what_is_beyond_single_precision_is_counted_apart_with_its_magnitude() {
    let magnitude = |node: Value| {
        let report = read_json(&edited(|d| d["nodes"][0] = node)).report;
        assert_eq!((report.out_of_range_instances, report.singular_instances), (1, 0));
        report.largest_magnitude
    };
    assert_eq!(magnitude(json!({ "mesh": 0, "translation": [-1e39, 0, 0] })), 1e39);
    assert_eq!(magnitude(json!({ "mesh": 0, "translation": [1e300, 0, 0] })), 1e300);
    assert_eq!(magnitude(json!({ "mesh": 0, "scale": [1, 1e40, 1] })), 1e40);
    let reach = magnitude(json!({ "mesh": 0, "scale": [1e38, 1e38, 1e38], "translation": [3.4e38, 0, 0] }));
    assert!((reach / 4.4e38 - 1.0).abs() < 1e-12, "{reach}");
}

#[test]
fn very_small_mirrored_and_unturned_instances_stay_as_they_are() {
    let scene = read_json(&edited(|d| {
        d["nodes"] = json!([
            { "mesh": 0, "scale": [1e-30, 1e-30, 1e-30] },
            { "mesh": 0, "scale": [-1, 1, 1] },
            { "mesh": 0, "rotation": [0, 0, 0, 0] },
        ]);
    }));
    assert_eq!((scene.instances.len(), scene.meshes.len(), scene.report.singular_instances), (3, 1, 0));
    assert_eq!(scene.instances[2].transform, Affine::IDENTITY);
}

#[test]
fn a_flat_image_far_off_keeps_its_shape() {
    let scene = read_json(&edited(|d| {
        d["nodes"][0]["translation"] = json!([4649776.75, 0, 0]);
        d["nodes"][0]["scale"] = json!([0.001, 0.001, 0]);
    }));
    let (mesh, instance) = (&scene.meshes[0], &scene.instances[0]);
    let place = |v: usize| instance.transform.transform_point(mesh.positions[v].map(f64::from));
    let side = place(1)[0] - place(0)[0];
    assert!((side - 0.001).abs() < 1e-8, "{side}");
    assert!((place(0)[0] - 4649776.75).abs() < 1e-9 && instance.transform.inverse().is_some());
}

#[test]
fn positions_that_were_rounded_before_are_told() {
    let rounded = |x: f32| {
        let bytes = le(&[x, 0.0, 0.0, x + 0.5, 0.0, 0.0, x + 0.5, 1.0, 0.0, x, 1.0, 0.0]);
        let scene = read_json(&edited(|d| {
            d["buffers"][0] = json!({ "byteLength": bytes.len(), "uri": data_uri(&bytes) });
            d["meshes"][0]["primitives"][0]["mode"] = 5.into();
        }));
        scene.rounding.rounded_before
    };
    assert_eq!((rounded(0.0), rounded(4_649_776.0)), (None, Some(0.5)));
}

#[test]
fn positions_that_were_rounded_before_are_told_of_what_is_posed() {
    let rounded = |x: f32, pose: fn(&mut Value)| {
        let bytes = le(&[x, 0.0, 0.0, x + 0.5, 0.0, 0.0, x + 0.5, 1.0, 0.0, x, 1.0, 0.0]);
        let scene = read_json(&edited(|d| {
            d["buffers"][0] = json!({ "byteLength": bytes.len(), "uri": data_uri(&bytes) });
            d["meshes"][0]["primitives"][0]["mode"] = 5.into();
            // Without a view, all of an accessor is 0.
            let zeros = |kind| json!({ "componentType": 5126, "type": kind, "count": 4 });
            d["accessors"].as_array_mut().unwrap().extend([zeros("VEC3"), zeros("VEC4")]);
            d["accessors"].as_array_mut().unwrap().push(json!({ "componentType": 5121, "type": "VEC4", "count": 4 }));
            pose(d);
        }));
        (scene.rounding.rounded_before, scene.meshes[0].triangles.len())
    };
    let morphed = |d: &mut Value| {
        d["meshes"][0]["weights"] = json!([0.25]);
        d["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 4 }]);
    };
    let skinned = |d: &mut Value| {
        d["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0, "WEIGHTS_0": 5, "JOINTS_0": 6 });
        d["nodes"] = json!([{ "mesh": 0, "skin": 0 }, { "translation": [0.1, 0, 0] }]);
        d["skins"] = json!([{ "joints": [1] }]);
    };
    for pose in [morphed, skinned] {
        assert_eq!((rounded(0.0, pose), rounded(4_649_776.0, pose)), ((None, 2), (Some(0.5), 2)));
    }
}
