//! glTF posed at times of its animations: what independent loaders and the specification make of animated situations and of real animations.

mod baked;
#[path = "../common/mod.rs"]
mod common;

use common::sequences_dir;

use bvhc::scene::{self, AnimationChoice, Degenerate, ErrorKind, Moment, ReadOptions, Scene, SceneError, Seconds};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

fn read_at(path: &Path, animation: u32, time: f64) -> Result<Scene, SceneError> {
    let moment = Moment { animation: AnimationChoice::Number(animation), time: Seconds::new(time) };
    let options = ReadOptions { degenerate: Degenerate::Keep, moment: Some(moment), ..ReadOptions::default() };
    scene::read(path, &options)
}

/// The positions of an instance in world space.
fn placed(scene: &Scene, instance: usize) -> Vec<[f64; 3]> {
    let instance = &scene.instances[instance];
    let mesh = &scene.meshes[instance.mesh as usize];
    (0..mesh.positions.len()).map(|v| instance.transform.transform_point(mesh.exact_position(v))).collect()
}

/// The largest distance along an axis between two lists of points; infinite where they are not as many.
fn farthest(got: &[[f64; 3]], want: &[[f64; 3]]) -> f64 {
    if got.len() != want.len() {
        return f64::INFINITY;
    }
    let far = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    // NaN is far.
    got.iter().zip(want).map(far).fold(0.0, |most, d| if d <= most { most } else { d })
}

/// Situations that no reader may play, each with a word of the refusal.
const REFUSED: [(&str, &str); 4] = [
    ("animation_pointer", "KHR_animation_pointer"),
    ("matrix_node_animated", "matrix"),
    ("same_target_twice", "another channel"),
    ("unsorted_key_times", "must increase"),
];

/// Invalid situations in which loaders differ from each other, and ours from what was noted, at these times.
const UNDEFINED: [(&str, f64); 3] =
    [("skin_weights_zero", 0.0), ("skin_weights_zero", 1.0), ("lin_rot_unnormalised", 0.5)];

fn wants(node: &Value) -> Vec<Vec<[f64; 3]>> {
    let points = |primitive: &Value| serde_json::from_value::<Vec<[f64; 3]>>(primitive.clone()).unwrap();
    let instance = |primitives: &Value| primitives.as_array().unwrap().iter().flat_map(points).collect();
    node.as_array().unwrap().iter().map(instance).collect()
}

#[test]
fn every_animated_situation_is_posed_as_the_specification_has_it() {
    let Some(folder) = sequences_dir() else { return };
    let folder = folder.join("situations");
    let expected = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: BTreeMap<String, Value> = serde_json::from_str(&expected).unwrap();
    let (mut wrong, mut compared, mut refused) = (Vec::new(), 0, 0);
    for (name, situation) in &expected {
        let path = folder.join(name).with_extension("gltf");
        for pose in situation["poses"].as_array().unwrap() {
            let Some(animation) = pose["clip"].as_u64() else { continue };
            let time = pose["t"].as_f64().unwrap();
            let has_animations =
                !scene::animations(&path, &ReadOptions::default()).is_ok_and(|animations| animations.is_empty());
            let scene = match read_at(&path, animation as u32, time) {
                Ok(scene) => scene,
                Err(error) => {
                    let word = REFUSED.iter().find(|(n, _)| n == name).map(|(_, word)| *word);
                    let is_meant = word.is_some_and(|word| error.to_string().contains(word));
                    if !is_meant && has_animations {
                        wrong.push(format!("{name}: {error}"));
                    }
                    refused += 1;
                    continue;
                }
            };
            if REFUSED.iter().any(|(n, _)| n == name) {
                wrong.push(format!("{name} is read"));
            }
            for (node, want) in pose["nodes"].as_object().unwrap() {
                let ours: Vec<usize> =
                    (0..scene.instances.len()).filter(|i| scene.instances[*i].name == *node).collect();
                let mut theirs = wants(want);
                // Nothing is left of what a scale of 0 takes.
                theirs.retain(|points| ours.len() == 1 || points.iter().flatten().any(|c| *c != 0.0));
                if ours.len() != theirs.len() {
                    wrong.push(format!("{name} at {time}: {} instances of {node}, want {}", ours.len(), theirs.len()));
                    continue;
                }
                for (instance, want) in ours.into_iter().zip(&theirs) {
                    let got = placed(&scene, instance);
                    // The smallest of them are 2 large.
                    if farthest(&got, want) > 1e-5 && !UNDEFINED.contains(&(name.as_str(), time)) {
                        wrong.push(format!("{name} at {time}: {node} is at {got:?}, want {want:?}"));
                    }
                    compared += 1;
                }
            }
        }
    }
    println!("{compared} poses compared, {refused} refused, in {} situations", expected.len());
    assert!(wrong.is_empty() && compared >= 120, "{compared} compared\n{}", wrong.join("\n"));
}

#[test]
fn real_animations_are_posed_as_baked_references_have_them() {
    let (Some(folder), Some(models)) = (sequences_dir(), common::models_dir()) else { return };
    let mut poses = 0;
    for name in ["cesiumman", "fox", "interpolation", "milktruck", "morphcube", "morphstress"] {
        let baked = baked::Baked::read(&folder.join(name).with_extension("npz"));
        let model = models.join(baked.meta["source"].as_str().unwrap());
        if !model.is_file() {
            println!("skipped: no {}", model.display());
            continue;
        }
        let mut worst: f64 = 0.0;
        for animation in baked.meta["clips"].as_array().unwrap() {
            let number = animation["index"].as_u64().unwrap();
            for (k, time) in animation["times"].as_array().unwrap().iter().enumerate() {
                let scene = read_at(&model, number as u32, time.as_f64().unwrap()).unwrap_or_else(|e| panic!("{e}"));
                let (mut got, mut want) = (Vec::new(), Vec::new());
                for i in 0..scene.instances.len() {
                    let (prefix, node) = (format!("c{number}_t{k}"), scene.instances[i].node);
                    let points = baked.points(&format!("{prefix}_n{node}_p"));
                    let ours = placed(&scene, i);
                    assert_eq!(ours.len(), points.len(), "{name} {prefix} node {node}");
                    got.extend(ours);
                    want.extend(points);
                }
                let extent = |k: usize| {
                    let along = || want.iter().map(|p| p[k]);
                    along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min)
                };
                let diagonal = (0..3).map(|k| extent(k).powi(2)).sum::<f64>().sqrt();
                let off = farthest(&got, &want) / diagonal;
                assert!(off <= 1e-5, "{name}: animation {number} at {time} is off by {off:.1e} of the diagonal");
                worst = worst.max(off);
                poses += 1;
            }
        }
        println!("{name}: off by at most {worst:.1e} of the diagonal");
    }
    println!("{poses} poses compared");
}

#[test]
fn animations_of_real_models_are_listed_with_their_rates() {
    let Some(models) = common::models_dir() else { return };
    for (file, number, animations, name, count, last, rate) in [
        ("anim_fox/Fox.glb", 0, 3, "Survey", 83, 3.416_666_7, Some(24.0)),
        // Its last eight keys lie 0.8 of a frame beside the grid of the others.
        ("anim_fox/Fox.glb", 2, 3, "Run", 25, 1.158_333_3, None),
        ("anim_cesiumman/CesiumMan.gltf", 0, 1, "", 49, 2.0, Some(24.0)),
        ("anim_soldier/Soldier.glb", 1, 4, "Run", 22, 0.7, Some(30.0)),
        ("anim_interpolation_test/InterpolationTest.gltf", 0, 9, "Step Scale", 5, 1.666_666_6, None),
        ("anim_interpolation_test/InterpolationTest.gltf", 8, 9, "Linear Translation", 5, 1.666_666_6, Some(2.4)),
        ("sf_pigman/scene.gltf", 3, 4, "PW_armature|run_pig_one_hand", 51, 0.833_333_3, Some(60.0)),
    ] {
        let path = models.join(file);
        if !path.is_file() {
            println!("skipped: no {file}");
            continue;
        }
        let all = scene::animations(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let animation = &all[number];
        let keys = animation.keys.expect("keys");
        assert_eq!((all.len(), animation.name.as_str(), keys.count), (animations, name, count), "{file}");
        assert!((keys.last - last).abs() < 1e-6, "{file}: {keys:?}");
        assert_eq!(keys.rate, rate, "{file}: {keys:?}");
    }
}

#[test]
fn an_animation_that_is_not_there_is_told_with_those_that_are() {
    let Some(models) = common::models_dir() else { return };
    let fox = models.join("anim_fox/Fox.glb");
    if !fox.is_file() {
        println!("skipped: no Fox.glb");
        return;
    }
    let error = read_at(&fox, 3, 0.0).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::BadModel);
    assert!(error.to_string().contains("animation 1 'Walk': 18 keys from 0 to 0.7083333 s, 24 a second"), "{error}");
}
