//! Animations that move nodes: how values between keys are found, and what of an animation counts.

use super::skins::Builder;
use super::*;
use crate::scene::{AnimationChoice, Moment, Seconds};

/// Options for a moment of an animation.
pub(super) fn moment(animation: u32, time: f64) -> ReadOptions {
    let moment = Moment { animation: AnimationChoice::Number(animation), time: Seconds::new(time) };
    ReadOptions { moment: Some(moment), ..options() }
}

pub(super) fn try_with(document: &Value, options: &ReadOptions) -> Result<Scene, SceneError> {
    read_bytes(document.to_string().into_bytes(), "test.gltf", Some(Format::Gltf), None, options)
}

/// The scene at a moment of an animation.
pub(super) fn at(b: &Builder, animation: u32, time: f64) -> Scene {
    try_with(&b.0, &moment(animation, time)).unwrap_or_else(|e| panic!("{e}\n{}", b.0))
}

/// The vertices of each instance in world space, at a time of the first animation.
pub(super) fn posed(b: &Builder, time: f64) -> Vec<Vec<[f64; 3]>> {
    placed(&at(b, 0, time))
}

pub(super) fn placed(scene: &Scene) -> Vec<Vec<[f64; 3]>> {
    let place = |i: &crate::scene::Instance| {
        let mesh = &scene.meshes[i.mesh as usize];
        (0..mesh.positions.len()).map(|v| i.transform.transform_point(mesh.exact_position(v))).collect()
    };
    scene.instances.iter().map(place).collect()
}

/// Vertex `v` of the first instance stands at `want` at a time of the first animation.
#[track_caller]
pub(super) fn stands(b: &Builder, time: f64, v: usize, want: [f64; 3]) {
    let got = posed(b, time)[0][v];
    assert!((0..3).all(|k| (got[k] - want[k]).abs() < 2e-7), "vertex {v} is at {got:?} at {time} s, want {want:?}");
}

/// An animation without channels.
pub(super) fn add_animation(b: &mut Builder, name: &str) {
    let animation = json!({ "name": name, "channels": [], "samplers": [] });
    match b.0["animations"].as_array_mut() {
        Some(animations) => animations.push(animation),
        None => b.0["animations"] = json!([animation]),
    }
}

/// Let the last animation move a target by keys at `times` and the values of an accessor.
pub(super) fn add_channel(b: &mut Builder, target: Value, interpolation: &str, times: &[f32], output: usize) {
    let times: Vec<[f32; 1]> = times.iter().map(|t| [*t]).collect();
    let input = b.floats("SCALAR", &times);
    let animation = b.0["animations"].as_array_mut().unwrap().last_mut().unwrap();
    let samplers = animation["samplers"].as_array_mut().unwrap();
    samplers.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
    let sampler = samplers.len() - 1;
    animation["channels"].as_array_mut().unwrap().push(json!({ "sampler": sampler, "target": target }));
}

pub(super) fn target(node: usize, path: &str) -> Value {
    json!({ "node": node, "path": path })
}

/// A node with a triangle whose corners lie on the axes, at 1, 2 and 3, and an animation.
pub(super) fn on_axes(node: Value) -> Builder {
    let mut b = Builder::new();
    let positions = b.floats("VEC3", &[[1., 0., 0.], [0., 2., 0.], [0., 0., 3.]]);
    b.mesh(json!([{ "attributes": { "POSITION": positions } }]));
    b.node(node);
    add_animation(&mut b, "A");
    b
}

/// That triangle with an animation that moves one property.
fn moved<const N: usize>(path: &str, interpolation: &str, times: &[f32], values: &[[f32; N]]) -> Builder {
    let mut b = on_axes(json!({ "mesh": 0 }));
    let output = b.floats(if N == 3 { "VEC3" } else { "VEC4" }, values);
    add_channel(&mut b, target(0, path), interpolation, times, output);
    b
}

const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

#[test]
fn rotations_take_the_shorter_arc_at_an_even_pace() {
    // Ninety degrees about y, to a negated quaternion.
    let b = moved("rotation", "LINEAR", &[0., 1.], &[[0., 0., 0., 1.], [0., -HALF, 0., -HALF]]);
    stands(&b, 0.25, 2, [1.1480503, 0.0, 2.7716386]);
    stands(&b, 1.0, 2, [3.0, 0.0, 0.0]);
    // 170 degrees about z: between the keys a straight line would be 6.5 degrees behind.
    let (sin, cos) = f32::to_radians(85.0).sin_cos();
    let b = moved("rotation", "LINEAR", &[0., 1.], &[[0., 0., 0., 1.], [0., 0., sin, cos]]);
    stands(&b, 0.25, 1, [-1.3511804, 1.4745547, 0.0]);
    // Exactly half a turn, where the dot product is 0: the way that its sign + tells.
    let b = moved("rotation", "LINEAR", &[0., 1.], &[[0., 0., 0., 1.], [0., 1., 0., 0.]]);
    stands(&b, 0.5, 0, [0.0, 0.0, -1.0]);
    // A full turn, thinned to three keys: the product of each and the next is 6e-17 above 0.
    let keys = [[0., 0., 0., 1.], [0., 1., 0., 6.123_234e-17], [0., 1.224_646_8e-16, 0., -1.]];
    let b = moved("rotation", "LINEAR", &[0., 1., 2.], &keys);
    stands(&b, 0.5, 0, [0.0, 0.0, -1.0]);
    stands(&b, 1.5, 0, [0.0, 0.0, 1.0]);
    // Keys of length 2 and 1/2 mean the rotations that they mean at rest.
    let b = moved("rotation", "LINEAR", &[0., 1.], &[[0., 0., 0., 2.], [HALF / 2., 0., 0., HALF / 2.]]);
    stands(&b, 1.0, 2, [0.0, -3.0, 0.0]);
}

#[test]
fn a_step_holds_its_value_until_the_next_key() {
    let b = moved("translation", "STEP", &[0., 0.5, 1.], &[[0., 0., 0.], [4., 0., 0.], [0., 6., 0.]]);
    for (time, want) in [(0.25, [1., 0., 0.]), (0.49, [1., 0., 0.]), (0.5, [5., 0., 0.]), (1.0, [1., 6., 0.])] {
        stands(&b, time, 0, want);
    }
}

/// A frame's own time, k / fps, must show the value of the key that an exporter rounded to `f32`.
#[test]
fn every_frame_shows_the_step_of_its_own_key() {
    for fps in [24.0, 30.0] {
        let times: Vec<f32> = (0..49).map(|k| (f64::from(k) / fps) as f32).collect();
        let values: Vec<[f32; 3]> = (0..49).map(|k| [k as f32, 0., 0.]).collect();
        let b = moved("translation", "STEP", &times, &values);
        for k in 0..49 {
            stands(&b, f64::from(k) / fps, 0, [1.0 + f64::from(k), 0.0, 0.0]);
        }
    }
}

#[test]
fn splines_have_tangents_per_second_and_rotations_no_change_of_sign() {
    // The first interval is 2 s long.
    let values = [[0., 0., 0.], [0., 0., 0.], [1., 3., 0.], [-1., 0., 2.], [4., 0., 0.], [2., 0., 0.]];
    let b = moved(
        "translation",
        "CUBICSPLINE",
        &[0., 2., 3.],
        &[&values[..], &[[0., 0., 1.], [4., 4., 0.], [0.; 3]]].concat(),
    );
    stands(&b, 1.0, 0, [3.5, 0.75, -0.5]);
    stands(&b, 2.0, 0, [5.0, 0.0, 0.0]);
    stands(&b, 2.5, 0, [5.25, 2.0, -0.125]);

    // The value in the middle has a length of 1.3, which is divided away.
    let (sin, cos) = f32::to_radians(30.0).sin_cos();
    let away = [0., 0.345_900_3, 0., 1.290_820_5];
    let values = [[0.; 4], [0., 0., 0., 1.], away, away.map(|c| -c), [0., sin, 0., cos], [0.; 4]];
    let b = moved("rotation", "CUBICSPLINE", &[0., 1.], &values);
    let middle = posed(&b, 0.5)[0][2];
    assert!((middle[0] - 1.5).abs() < 1e-3 && (middle[2] - 2.598).abs() < 1e-3, "{middle:?}");
    let length = middle.iter().map(|c| c * c).sum::<f64>().sqrt();
    assert!((length - 3.0).abs() < 1e-9, "{length}");

    // To a negated quaternion, the long way.
    let values = [[0.; 4], [0., 0., 0., 1.], [0., 0., 0.4, 0.], [0.; 4], [0., -sin, 0., -cos], [0.; 4]];
    let b = moved("rotation", "CUBICSPLINE", &[0., 1.], &values);
    stands(&b, 0.5, 2, [-1.4460334, -1.0793339, -2.3966697]);
}

#[test]
fn an_animation_holds_its_ends_and_one_key_is_enough() {
    let at_nine = json!({ "mesh": 0, "translation": [9, 9, 9] });
    for (times, values) in
        [(&[1.0f32, 2.0][..], &[[1., 2., 3.], [2., 2., 3.]][..]), (&[0.5], &[[1., 2., 3.]]), (&[0.0], &[[1., 2., 3.]])]
    {
        for interpolation in ["LINEAR", "STEP"] {
            let mut b = on_axes(at_nine.clone());
            let output = b.floats("VEC3", values);
            add_channel(&mut b, target(0, "translation"), interpolation, times, output);
            for time in [-7.0, 0.0, 0.5] {
                stands(&b, time, 2, [1.0, 2.0, 6.0]);
            }
            stands(&b, 3.0, 2, if times.len() == 2 { [2.0, 2.0, 6.0] } else { [1.0, 2.0, 6.0] });
        }
    }
    // A spline of one key is its value.
    let b = moved("translation", "CUBICSPLINE", &[0.5], &[[9.; 3], [1., 2., 3.], [9.; 3]]);
    stands(&b, 0.7, 2, [1.0, 2.0, 6.0]);
    // Without an interpolation it is linear; keys may lie before 0; of two keys at one time the last counts from there on.
    let mut b = moved("translation", "LINEAR", &[-1., 1.], &[[-2., 0., 0.], [2., 0., 0.]]);
    b.0["animations"][0]["samplers"][0].as_object_mut().unwrap().remove("interpolation");
    stands(&b, 0.5, 2, [1.0, 0.0, 3.0]);
    let jump = [[0., 0., 0.], [1., 0., 0.], [5., 0., 0.], [6., 0., 0.]];
    let b = moved("translation", "LINEAR", &[0., 1., 1., 2.], &jump);
    for (time, x) in [(0.999, 1.999), (1.0, 6.0), (1.001, 6.001)] {
        stands(&b, time, 0, [x, 0.0, 0.0]);
    }
}

#[test]
fn integers_of_rotations_are_normalized_and_the_lowest_is_minus_one() {
    let rotated = |component: u32, bytes: &[u8]| {
        let mut b = on_axes(json!({ "mesh": 0 }));
        let output = b.accessor(component, "VEC4", 2, bytes);
        add_channel(&mut b, target(0, "rotation"), "LINEAR", &[0., 1.], output);
        b
    };
    let shorts: Vec<u8> = [0i16, 0, 0, 32767, 0, 23170, 0, 23170].iter().flat_map(|v| v.to_le_bytes()).collect();
    let b = rotated(5122, &shorts);
    stands(&b, 0.5, 0, [f64::from(HALF), 0.0, -f64::from(HALF)]);
    let b = rotated(5120, &[0, 0, 0, 127, 0, 0x80, 0, 0]);
    stands(&b, 1.0, 2, [0.0, 0.0, -3.0]);
    let mut b = rotated(5121, &[0, 0, 0, 255, 0, 255, 0, 0]);
    stands(&b, 0.5, 0, [0.0, 0.0, -1.0]);
    // Whether the file says so or not.
    b.0["accessors"][1]["normalized"] = false.into();
    stands(&b, 0.5, 0, [0.0, 0.0, -1.0]);
    let shorts: Vec<u8> = [0u16, 0, 0, 65535, 65535, 0, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    stands(&rotated(5123, &shorts), 1.0, 2, [0.0, 0.0, -3.0]);
}

#[test]
fn keys_may_be_strided_or_sparse() {
    // Two times and two translations, interleaved.
    let mut b = on_axes(json!({ "mesh": 0 }));
    let all = b.floats("VEC4", &[[0., 1., 0., 0.], [2., 5., 0., 0.]]);
    let view = b.0["accessors"][all]["bufferView"].clone();
    b.0["bufferViews"][view.as_u64().unwrap() as usize]["byteStride"] = 16.into();
    add_channel(&mut b, target(0, "translation"), "LINEAR", &[0.], 0);
    let accessors = b.0["accessors"].as_array_mut().unwrap();
    accessors.push(json!({ "bufferView": view, "componentType": 5126, "type": "SCALAR", "count": 2 }));
    accessors.push(json!({ "bufferView": view, "byteOffset": 4, "componentType": 5126, "type": "VEC3", "count": 2 }));
    let input = accessors.len() - 2;
    b.0["animations"][0]["samplers"][0] = json!({ "input": input, "output": input + 1 });
    stands(&b, 1.0, 0, [4.0, 0.0, 0.0]);

    // Translations of zeros, but for the second.
    let mut b = on_axes(json!({ "mesh": 0 }));
    let (places, values) = (b.joints(&[1, 0, 0, 0]), b.floats("VEC3", &[[0., 8., 0.]]));
    let view = |accessor: usize| b.0["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": view(places), "componentType": 5121 },
        "values": { "bufferView": view(values) },
    });
    let accessor = json!({ "componentType": 5126, "type": "VEC3", "count": 2, "sparse": sparse });
    b.0["accessors"].as_array_mut().unwrap().push(accessor);
    let output = b.0["accessors"].as_array().unwrap().len() - 1;
    add_channel(&mut b, target(0, "translation"), "LINEAR", &[0., 1.], output);
    stands(&b, 0.25, 0, [1.0, 2.0, 0.0]);
}

#[test]
fn what_an_animation_does_not_move_stands_at_rest() {
    let mut b = on_axes(json!({ "mesh": 0 }));
    b.node(json!({ "mesh": 0, "translation": [10, 0, 0], "scale": [2, 2, 2] }));
    let moved = b.floats("VEC3", &[[0., 0., 0.], [1., 0., 0.]]);
    add_channel(&mut b, target(0, "translation"), "LINEAR", &[0., 1.], moved);
    add_animation(&mut b, "B");
    let moved = b.floats("VEC3", &[[20., 0., 0.], [20., 5., 0.]]);
    add_channel(&mut b, target(1, "translation"), "LINEAR", &[0., 1.], moved);
    let firsts = |animation, time| placed(&at(&b, animation, time)).iter().map(|mesh| mesh[0]).collect::<Vec<_>>();
    assert_eq!(firsts(0, 1.0), [[2., 0., 0.], [12., 0., 0.]]);
    assert_eq!(firsts(1, 1.0), [[1., 0., 0.], [22., 5., 0.]]);
}

#[test]
fn scales_shear_what_is_turned_below_and_nothing_is_left_at_zero() {
    let mut b = on_axes(json!({ "mesh": 0, "rotation": [0, 0, 0.3826834323650898, 0.9238795325112867] }));
    b.node(json!({ "children": [0], "scale": [1, 3, 1] }));
    let scales = b.floats("VEC3", &[[1., 3., 1.], [1., 1., 1.]]);
    add_channel(&mut b, target(1, "scale"), "LINEAR", &[0., 1.], scales);
    stands(&b, 0.0, 1, [-std::f64::consts::SQRT_2, 3.0 * std::f64::consts::SQRT_2, 0.0]);
    stands(&b, 1.0, 1, [-std::f64::consts::SQRT_2, std::f64::consts::SQRT_2, 0.0]);

    let b = moved("scale", "STEP", &[0., 1., 2.], &[[1.; 3], [0.; 3], [1.; 3]]);
    stands(&b, 0.5, 0, [1.0, 0.0, 0.0]);
    stands(&b, 2.0, 0, [1.0, 0.0, 0.0]);
    let scene = at(&b, 0, 1.5);
    assert_eq!((scene.instances.len(), scene.report.singular_instances), (0, 1));
}

#[test]
fn instances_move_with_their_node() {
    let mut b = on_axes(json!({ "mesh": 0 }));
    let places = b.floats("VEC3", &[[0., 0., 0.], [10., 0., 0.]]);
    b.0["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    let turns = b.floats("VEC4", &[[0., 0., 0., 1.], [0., HALF, 0., HALF]]);
    add_channel(&mut b, target(0, "rotation"), "LINEAR", &[0., 1.], turns);
    let got = posed(&b, 1.0)[1][2];
    assert!((0..3).all(|k| (got[k] - [3.0, 0.0, -10.0][k]).abs() < 1e-6), "{got:?}");
}

/// Of several poses of one model each is what reading the file for it alone gives, and no buffer is fetched again.
#[test]
fn a_model_is_read_once_and_posed_many_times() {
    use crate::exec::Executor;
    use crate::scene::gltf::{Model, data_uri};
    use crate::scene::source::Source;
    let b = moved("translation", "LINEAR", &[0., 1.], &[[0., 0., 0.], [1., 0., 0.]]);
    let (folder, mut external) = (tempfile::tempdir().unwrap(), b.0.clone());
    let buffer = |i: usize| folder.path().join(format!("{i}.bin"));
    let buffers = external["buffers"].as_array_mut().unwrap();
    for (i, json) in buffers.iter_mut().enumerate() {
        let data = data_uri::strip_scheme(json["uri"].as_str().unwrap()).unwrap();
        std::fs::write(buffer(i), data_uri::decode(data).unwrap()).unwrap();
        json["uri"] = format!("{i}.bin").into();
    }
    let count = buffers.len();
    let (text, options, exec) = (external.to_string().into_bytes(), options(), Executor::sequential());
    let (mut progress, place) = (|_, _| (), Some(folder.path().to_owned()));
    let mut source = Source::new(std::path::Path::new("test.gltf"), place, &options, &exec, &mut progress);
    let mut model = Model::read(&text, &mut source).unwrap();
    let animation = model.animation(&AnimationChoice::Only, &mut source).unwrap();
    model.at_rest(&mut source).unwrap();
    (0..count).for_each(|i| std::fs::remove_file(buffer(i)).unwrap());
    for time in [0.5, 0.0, 0.5, 1.0] {
        let scene = model.at(&animation, Seconds::new(time).unwrap(), &mut source).unwrap();
        assert_eq!(placed(&scene), posed(&b, time));
    }
    let rest = model.at_rest(&mut source).unwrap();
    assert_eq!(placed(&rest), placed(&read_json(&b.0)));
    assert_eq!((rest.report.unplayed_animations, rest.posed), (1, None));
}
