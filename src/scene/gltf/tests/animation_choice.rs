//! Which animation is meant, what is told of animations, and which animations are refused.

use super::animation::{add_animation, add_channel, at, moment, on_axes, posed, stands, target, try_with};
use super::skins::Builder;
use super::*;
use crate::scene::{Animation, AnimationChoice, KeyTimes, Moment, Seconds};

/// Animations `Walk`, `Run`, `Walk` and one without a name; the first two move the triangle.
fn several() -> Builder {
    let mut b = on_axes(json!({ "mesh": 0 }));
    b.0["animations"] = json!([]);
    for (name, times) in [("Walk", &[0.25, 0.5, 1.0][..]), ("Run", &[0.0, 0.1]), ("Walk", &[]), ("", &[])] {
        add_animation(&mut b, name);
        if !times.is_empty() {
            let values: Vec<[f32; 3]> = times.iter().map(|t| [10.0 * t, 0., 0.]).collect();
            let values = b.floats("VEC3", &values);
            add_channel(&mut b, target(0, "translation"), "LINEAR", times, values);
        }
    }
    b
}

fn choosing(animation: AnimationChoice, time: Option<f64>) -> ReadOptions {
    let time = time.and_then(Seconds::new);
    ReadOptions { moment: Some(Moment { animation, time }), ..options() }
}

fn name(text: &str) -> AnimationChoice {
    AnimationChoice::Name(text.to_owned())
}

#[test]
fn an_animation_is_chosen_by_number_or_name_and_begins_with_its_first_key() {
    let b = several();
    for (choice, time, animation, seconds, x) in [
        (AnimationChoice::Number(0), None, 0, 0.25, 3.5),
        (AnimationChoice::Number(0), Some(0.75), 0, 0.75, 8.5),
        (name("Run"), Some(0.05), 1, 0.05, 1.5),
        (AnimationChoice::Number(3), None, 3, 0.0, 1.0),
    ] {
        let scene = try_with(&b.0, &choosing(choice, time)).unwrap();
        let posed = scene.posed.as_ref().unwrap();
        assert_eq!((posed.animation.number, posed.time.get()), (animation, seconds));
        assert!((super::animation::placed(&scene)[0][0][0] - x).abs() < 1e-6);
        assert_eq!(scene.report.unplayed_animations, 0, "one is played");
    }
    let rest = read_json(&b.0);
    assert_eq!((rest.posed, rest.report.unplayed_animations), (None, 4));

    // The only animation need not be named.
    let mut b = several();
    b.0["animations"].as_array_mut().unwrap().truncate(1);
    let scene = try_with(&b.0, &choosing(AnimationChoice::Only, None)).unwrap();
    assert_eq!(scene.posed.unwrap().time.get(), 0.25);
}

#[test]
fn a_choice_that_is_none_lists_the_animations() {
    let b = several();
    for (choice, says) in [
        (AnimationChoice::Only, "it has 4 animations, and which is meant is not said"),
        (AnimationChoice::Number(4), "it has no animation 4; the last is animation 3"),
        (name("walk"), "it has no animation named 'walk'"),
        (name(""), "it has no animation named ''"),
        (name("Walk"), "it has 2 animations named 'Walk'; their numbers tell them apart"),
    ] {
        let error = try_with(&b.0, &choosing(choice, None)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::BadModel);
        let facts = [
            says,
            "animation 0 'Walk': 3 keys from 0.25 to 1 s, 4 a second",
            "animation 1 'Run': 2 keys from 0 to 0.1 s, 10 a second",
            "animation 2 'Walk': nothing of the scene moves",
            "animation 3: nothing of the scene moves",
        ];
        assert_eq!(error.facts(), facts);
        assert_eq!(error.to_string(), format!("{}: {}", error.action(), facts.join("; ")));
    }
    let none = try_with(&square(), &choosing(AnimationChoice::Only, None)).unwrap_err().to_string();
    assert!(none.ends_with("it has no animations"), "{none}");

    // Of very many the first are told, and one that cannot be read has no times.
    let mut many = several();
    many.0["animations"] = json!(vec![json!({ "channels": "none" }); 100]);
    let facts = try_with(&many.0, &choosing(AnimationChoice::Number(100), None)).unwrap_err().facts();
    assert_eq!((facts.len(), facts.last().map(String::as_str)), (1 + 32 + 1, Some("and 68 more")), "{facts:?}");
}

#[test]
fn animations_are_listed_with_the_times_of_what_they_move() {
    let folder = tempfile::tempdir().unwrap();
    let listed = |b: &Builder, options: &ReadOptions| {
        let path = folder.path().join("m.gltf");
        std::fs::write(&path, b.0.to_string()).unwrap();
        crate::scene::animations(&path, options)
    };
    let mut b = several();
    let keys = |first, last, count, rate| Some(KeyTimes { first, last, count, rate });
    let animation = |number, name: &str, keys| Animation { number, name: name.to_owned(), keys };
    let want = [
        animation(0, "Walk", keys(0.25, 1.0, 3, Some(4.0))),
        animation(1, "Run", keys(0.0, 0.1, 2, Some(10.0))),
        animation(2, "Walk", None),
        animation(3, "", None),
    ];
    assert_eq!(listed(&b, &options()).unwrap(), want);

    // Keys of a node outside of the scene, or of one that carries nothing, are none of the scene's.
    b.node(json!({}));
    b.node(json!({ "mesh": 0 }));
    b.0["scenes"] = json!([{ "nodes": [0, 1] }, { "nodes": [2] }]);
    add_animation(&mut b, "Elsewhere");
    for node in [1, 2] {
        add_channel(&mut b, target(node, "translation"), "LINEAR", &[5.0], 99);
    }
    assert_eq!(listed(&b, &options()).unwrap()[4].keys, None);
    let other = ReadOptions { scene: Some(1), ..options() };
    assert_eq!(listed(&b, &other).unwrap()[4].keys, keys(5.0, 5.0, 1, None));
    assert_eq!(listed(&b, &other).unwrap()[0].keys, None);

    let obj = folder.path().join("m.obj");
    std::fs::write(&obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(crate::scene::animations(&obj, &options()).unwrap(), []);
    let text = crate::scene::read(&obj, &moment(0, 0.0)).unwrap_err().to_string();
    assert!(text.ends_with("it has no animations"), "{text}");
}

#[test]
fn channels_that_move_nothing_of_the_scene_may_be_broken() {
    let mut b = on_axes(json!({ "mesh": 0 }));
    let values = b.floats("VEC3", &[[0., 0., 0.], [1., 0., 0.]]);
    // Without a node, as the specification allows; of an unknown path; of a node that carries nothing; weights of a node without a mesh.
    b.node(json!({ "children": [0] }));
    b.node(json!({ "camera": 0 }));
    add_channel(&mut b, json!({ "path": "translation" }), "LINEAR", &[0., 1.], 99);
    add_channel(&mut b, json!({ "path": "roundness", "node": 0 }), "LINEAR", &[0., 1.], 99);
    add_channel(&mut b, target(2, "translation"), "LINEAR", &[0., 1.], 99);
    add_channel(&mut b, target(1, "weights"), "LINEAR", &[0., 1.], 99);
    add_channel(&mut b, target(0, "translation"), "LINEAR", &[0., 1.], values);
    stands(&b, 0.5, 0, [1.5, 0.0, 0.0]);
    let report = at(&b, 0, 0.5).report;
    assert_eq!((report.unknown_channels, report.ignored_extensions.len()), (1, 0));
    // So may a whole animation that is not played.
    add_animation(&mut b, "broken");
    b.0["animations"][1] = json!({ "name": 7, "channels": [{}] });
    stands(&b, 0.5, 0, [1.5, 0.0, 0.0]);
}

#[test]
fn pointers_to_what_moves_triangles_are_refused_by_name_unless_ignored() {
    let pointed = |pointer: &str| {
        let mut b = on_axes(json!({ "mesh": 0 }));
        let values = b.floats("VEC3", &[[0., 0., 0.], [1., 0., 0.]]);
        add_channel(&mut b, target(0, "translation"), "LINEAR", &[0., 1.], values);
        let extensions = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        add_channel(&mut b, json!({ "path": "pointer", "extensions": extensions }), "LINEAR", &[0., 1.], 99);
        b.0["extensionsUsed"] = json!(["KHR_animation_pointer"]);
        b
    };
    for pointer in ["/nodes/0/scale", "/nodes/0/extensions/KHR_node_visibility/visible", "/meshes/0/weights/0"] {
        let b = pointed(pointer);
        let error = try_with(&b.0, &moment(0, 1.0)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Unsupported, "{error}");
        assert!(
            matches!(&error, SceneError::UnsupportedExtension { extension, ignorable: true, .. } if extension == "KHR_animation_pointer"),
            "{error}"
        );
        let ignoring = |options: ReadOptions| ReadOptions {
            ignore_extensions: vec!["KHR_animation_pointer".to_owned()],
            ..options
        };
        let scene = try_with(&b.0, &ignoring(moment(0, 1.0))).unwrap();
        assert_eq!(super::animation::placed(&scene)[0][0], [2.0, 0.0, 0.0]);
        assert_eq!(scene.report.ignored_extensions, ["KHR_animation_pointer"]);
        // At rest no pointer moves anything.
        assert_eq!(try_with(&b.0, &ignoring(options())).unwrap().report.ignored_extensions, [""; 0]);
        read_json(&b.0);
    }
    for pointer in ["/materials/0/emissiveFactor", "/nodes/0/extensions/KHR_lights_punctual/color", "/nodes/9/scale"] {
        let b = pointed(pointer);
        assert_eq!(posed(&b, 1.0)[0][0], [2.0, 0.0, 0.0], "{pointer}");
        assert_eq!(at(&b, 0, 1.0).report.ignored_extensions, [""; 0]);
    }
}

#[test]
fn broken_animations_are_refused_where_they_are_played_and_only_there() {
    let refused = |edit: &dyn Fn(&mut Builder)| {
        let mut b = on_axes(json!({ "mesh": 0 }));
        let values = b.floats("VEC3", &[[0., 0., 0.], [1., 0., 0.]]);
        add_channel(&mut b, target(0, "translation"), "LINEAR", &[0., 1.], values);
        edit(&mut b);
        read_json(&b.0);
        let error = try_with(&b.0, &moment(0, 0.5)).expect_err("it should be refused");
        assert_eq!(error.kind(), ErrorKind::BadModel, "{error}");
        error.to_string()
    };
    let channel = |b: &mut Builder, path: &str, times: &[f32], output: usize| {
        b.0["animations"] = json!([]);
        add_animation(b, "broken");
        add_channel(b, target(0, path), "LINEAR", times, output);
    };
    type Edit<'e> = &'e dyn Fn(&mut Builder);
    let cases: &[(&str, Edit)] = &[
        ("channel 0 of animation 0 moves node 5, but there are 1", &|b| {
            b.0["animations"][0]["channels"][0]["target"]["node"] = 5.into();
        }),
        ("channel 1 of animation 0 moves the translation of node 0, which another channel moves already", &|b| {
            let again = b.0["animations"][0]["channels"][0].clone();
            b.0["animations"][0]["channels"].as_array_mut().unwrap().push(again);
        }),
        ("channel 0 of animation 0 moves the translation of node 0, which has a matrix in its place", &|b| {
            b.0["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]);
        }),
        ("channel 0 of animation 0 uses sampler 3, but there are 1", &|b| {
            b.0["animations"][0]["channels"][0]["sampler"] = 3.into();
        }),
        ("has the interpolation 'BEZIER'; it must be STEP, LINEAR or CUBICSPLINE", &|b| {
            b.0["animations"][0]["samplers"][0]["interpolation"] = "BEZIER".into();
        }),
        ("animation 0 is not that of a glTF file", &|b| b.0["animations"][0]["channels"][0]["target"] = json!({})),
        ("uses accessor 77, but there are", &|b| b.0["animations"][0]["samplers"][0]["input"] = 77.into()),
        ("its use here needs VEC4 of FLOAT", &|b| channel(b, "rotation", &[0., 1.], 1)),
        ("channel 0 of animation 0 has key 2 at 0.5 s behind one at 1 s", &|b| {
            channel(b, "translation", &[0., 1., 0.5], 1);
        }),
        ("channel 0 of animation 0 has key 1 at NaN", &|b| channel(b, "translation", &[0., f32::NAN], 1)),
        ("channel 0 of animation 0 has no keys", &|b| {
            channel(b, "translation", &[0.], 1);
            b.0["accessors"].as_array_mut().unwrap().last_mut().unwrap()["count"] = 0.into();
        }),
        ("channel 0 of animation 0 has 3 keys, but 6 numbers of translation; it needs 9", &|b| {
            channel(b, "translation", &[0., 1., 2.], 1);
        }),
        ("channel 0 of animation 0 has 2 keys, but 3 numbers of weights; it needs 2", &|b| {
            let three = b.floats("SCALAR", &[[0.], [1.], [2.]]);
            channel(b, "weights", &[0., 1.], three);
        }),
        ("channel 0 of animation 0 has 3 keys, but 1 numbers of weights; it needs 3", &|b| {
            let one = b.floats("SCALAR", &[[0.]]);
            channel(b, "weights", &[0., 1., 2.], one);
        }),
    ];
    for (says, edit) in cases {
        let text = refused(edit);
        assert!(text.contains(says), "{text}\nwant {says}");
    }
}

#[test]
fn the_memory_of_keys_is_within_the_limit() {
    let mut b = on_axes(json!({ "mesh": 0 }));
    let (keys, values) = (json!({ "componentType": 5126, "type": "SCALAR", "count": 1 << 20 }), 1 << 20);
    b.0["accessors"].as_array_mut().unwrap().push(keys);
    b.0["accessors"].as_array_mut().unwrap().push(json!({ "componentType": 5126, "type": "VEC3", "count": values }));
    add_channel(&mut b, target(0, "translation"), "STEP", &[0.], 2);
    b.0["animations"][0]["samplers"][0]["input"] = 1.into();
    stands(&b, 0.0, 0, [1.0, 0.0, 0.0]);
    let small = ReadOptions { max_memory: 16 << 20, ..moment(0, 0.0) };
    assert_eq!(try_with(&b.0, &small).unwrap_err().kind(), ErrorKind::Limit);
    assert!(try_with(&b.0, &ReadOptions { moment: None, ..small }).is_ok());
}
