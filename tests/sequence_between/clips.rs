//! Real animations: a million rays at random times.

use super::brute::Tally;
use super::{build, common, open, play};
use bvhc::cache::{Codec, Validation};
use bvhc::scene::{self, AnimationChoice, Degenerate, Moment, ReadOptions, Scene, Seconds};
use std::path::Path;

fn clip_frames(path: &Path, animation: u32, times: impl Iterator<Item = f64>) -> Vec<Scene> {
    let read = |time: f64| {
        let moment = Moment { animation: AnimationChoice::Number(animation), time: Seconds::new(time) };
        let options = ReadOptions { degenerate: Degenerate::Keep, moment: Some(moment), ..ReadOptions::default() };
        scene::read(path, &options).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    };
    times.map(read).collect()
}

#[test]
#[ignore = "long: a million rays at random times of every clip"]
fn long_a_million_rays_between_frames_of_real_clips() {
    const RAYS: usize = 1_000_000;
    let Some(models) = common::models_dir() else { return };
    let mut clips = Vec::new();
    for name in [
        "anim_fox/Fox.glb",
        "anim_cesiumman/CesiumMan.gltf",
        "anim_cesium_milk_truck/CesiumMilkTruck.glb",
        "anim_interpolation_test/InterpolationTest.gltf",
        "anim_morph_cube/AnimatedMorphCube.gltf",
        "anim_morph_stress/MorphStressTest.gltf",
        "anim_soldier/Soldier.glb",
    ] {
        let path = models.join(name);
        if !path.is_file() {
            println!("skipped: no {name}");
            continue;
        }
        for (number, animation) in scene::animations(&path, &ReadOptions::default()).unwrap().iter().enumerate() {
            let Some(keys) = animation.keys else { continue };
            let (first, last) = (f64::from(keys.first), f64::from(keys.last));
            let times = (0..4).map(|k| first + (last - first) * 0.27 * f64::from(k));
            clips.push((format!("{name} {number}"), clip_frames(&path, number as u32, times)));
        }
    }
    let cats = models.join("seq_cat_run_lowpoly");
    if cats.is_dir() {
        let options = ReadOptions { degenerate: Degenerate::Keep, ..ReadOptions::default() };
        let cat = |k: u32| scene::read(&cats.join(format!("cat_{:06}.obj", 1 + 4 * k)), &options).unwrap();
        clips.push(("cat".into(), (0..4).map(cat).collect()));
    }
    let share = RAYS.div_ceil(clips.len().max(1));
    let mut total = Tally::default();
    for (number, (name, frames)) in clips.into_iter().enumerate() {
        let bytes = build(frames, Codec::Raw);
        let sequence = open(&bytes, Validation::Tree);
        let tally = play(&sequence, 200, share.div_ceil(600), number as u64);
        println!("{name:<48} {tally:?}");
        assert!(tally.hits * 2 > tally.rays, "{name}: {tally:?}");
        total.rays += tally.rays;
        total.hits += tally.hits;
        total.sure += tally.sure;
    }
    println!("{total:?}: 0 missed, 0 farther, 0 false");
    assert!(total.rays >= RAYS, "{total:?}");
}
