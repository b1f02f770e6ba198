//! Every corner-case file ends in the right number of triangles or in a clear error; real scenes have their known counts.

mod common;

use bvhc::scene::{self, Degenerate, ErrorKind, ReadOptions, Scene, SceneError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

/// Turns a hang into a failure; no file here takes a hundredth of it.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// Read on another thread, so that neither a hang nor a panic ends the test run unnoticed.
fn read_guarded(path: PathBuf) -> Result<Scene, SceneError> {
    let (sender, receiver) = mpsc::channel();
    let options = ReadOptions { degenerate: Degenerate::Keep, ..ReadOptions::default() };
    let shown = path.display().to_string();
    std::thread::spawn(move || {
        // Nobody listens after the time limit.
        let _ = sender.send(scene::read(&path, &options));
    });
    match receiver.recv_timeout(TIME_LIMIT) {
        Ok(result) => result,
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("{shown}: not read within {TIME_LIMIT:?}"),
        Err(mpsc::RecvTimeoutError::Disconnected) => panic!("{shown}: reading panicked"),
    }
}

/// Triangles of the source, instances expanded, dropped ones included.
fn source_triangles(scene: &Scene) -> u64 {
    let of_mesh = |m: u32| scene.meshes[m as usize].parts.iter().map(|p| u64::from(p.prim_count)).sum::<u64>();
    scene.instances.iter().map(|i| of_mesh(i.mesh)).sum()
}

fn unique_triangles(scene: &Scene) -> u64 {
    scene.meshes.iter().flat_map(|m| &m.parts).map(|p| u64::from(p.prim_count)).sum()
}

/// What the rest of the program relies on.
fn assert_well_formed(scene: &Scene, name: &str) {
    for mesh in &scene.meshes {
        assert!(!mesh.triangles.is_empty(), "{name}: an empty mesh");
        assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.positions.len()), "{name}");
        assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()), "{name}: a position is not finite");
        assert!(mesh.source_prims.is_empty() || mesh.source_prims.len() == mesh.triangles.len(), "{name}");
        assert!(mesh.source_prims.is_sorted(), "{name}");
        let mut next = 0;
        for part in &mesh.parts {
            assert_eq!(part.first_triangle, next, "{name}: parts do not tile the triangles");
            assert!(part.triangle_count <= part.prim_count, "{name}");
            next += part.triangle_count;
        }
        assert_eq!(next as usize, mesh.triangles.len(), "{name}: parts do not tile the triangles");
    }
    for instance in &scene.instances {
        assert!((instance.mesh as usize) < scene.meshes.len() && instance.transform.inverse().is_some(), "{name}");
    }
    let mut shown = vec![false; scene.meshes.len()];
    scene.instances.iter().for_each(|i| shown[i.mesh as usize] = true);
    assert!(shown.iter().all(|s| *s), "{name}: a mesh without instance");
    assert!(!scene.inputs.is_empty() && scene.inputs.iter().all(|i| !Path::new(&i.name).is_absolute()), "{name}");
}

fn assert_clear(error: &SceneError, path: &Path, name: &str) {
    let text = error.to_string();
    let file = path.file_name().unwrap().to_string_lossy();
    assert!(text.starts_with("cannot read ") && text.contains(&*file), "{name}: {text}");
    // What the operating system says is the reason where there is no other.
    let facts = error.facts();
    let is_told = facts.iter().all(|fact| fact.len() > 8 && !fact.contains('\n')) && !facts.is_empty();
    assert!(is_told || std::error::Error::source(error).is_some(), "{name}: no reason in {text}");
    assert!(!text.contains(" { ") && !text.contains("Some(") && !text.contains("Err("), "{name}: {text}");
}

fn corner_counts(models: &Path) -> BTreeMap<String, i64> {
    let table = std::fs::read_to_string(models.join("CORNER.tsv")).unwrap();
    let row = |line: &str| {
        let mut fields = line.split('\t');
        Some((fields.next()?.to_owned(), fields.next()?.parse().ok()?))
    };
    table.lines().skip(1).filter_map(row).collect()
}

/// Files that end otherwise than the table says, and why that is right. `None`: refused.
const DIFFERENCES: [(&str, Option<u64>, &str); 38] = [
    // Read, though the script that made the table could not.
    ("obj_corner/tinyobjloader/test-nan.obj", Some(36), "1.#IND is an old spelling of NaN; two triangles are dropped"),
    (
        "gltf_corner/gltf_validator/base/data/glb/extra_data.glb",
        Some(0),
        "what follows the GLB's stated length is not part of it",
    ),
    (
        "gltf_corner/gltf_validator/base/data/json/integer_written_as_float.gltf",
        Some(0),
        "1e0 is a whole number in JSON",
    ),
    ("gltf_corner/gltf_validator/base/data/json/bom.gltf", Some(0), "a byte order mark does no harm"),
    ("gltf_corner/gltf_validator/base/data/mesh/unresolved_indices.gltf", Some(0), "no node shows the broken mesh"),
    ("gltf_corner/gltf_validator/base/data/mesh/unresolved_positions.gltf", Some(0), "no node shows the broken mesh"),
    // Nothing left.
    ("obj_corner/draco/inf_nan.obj", Some(0), "its only triangle is not finite, and its mesh goes with it"),
    // Refused, though the script counted faces without looking at what they name.
    ("obj_corner/tinyobjloader/invalid-relative-texture-index.obj", None, "its face names a vertex that is not there"),
    ("obj_corner/tinyobjloader/invalid-relative-vertex-index.obj", None, "its face names a vertex that is not there"),
    ("obj_corner/tinyobjloader/issue-140-zero-face-idx.obj", None, "vertex 0 does not exist"),
    (
        "gltf_corner/draco/CubeScaledInstances/glTF/cube_att.gltf",
        None,
        "a node with four parents (glTF 2.0, 3.5.2 allows one)",
    ),
    ("gltf_corner/draco/KhronosSampleModels/DragonAttenuation/glTF/DragonAttenuation.gltf", None, "its .bin is absent"),
    ("gltf_corner/gltf_transform/cli/test/in/ACMEBox.gltf", None, "requires an extension that nobody knows"),
    (
        "gltf_corner/gltf_validator/base/data/root/undefined_used_extensions.gltf",
        None,
        "requires an extension that nobody knows",
    ),
    ("gltf_corner/gltf_validator/base/data/root/named_objects.gltf", None, "its buffer has no data"),
    ("gltf_corner/gltf_validator/base/data/root/unused_objects.gltf", None, "its buffer has no data"),
    ("gltf_corner/gltf_validator/base/data/root/empty_object.gltf", None, "no asset"),
    ("gltf_corner/gltf_validator/base/data/glb/empty_json_object.glb", None, "no asset"),
    ("gltf_corner/gltf_validator/base/data/asset/1_0_version.gltf", None, "glTF 1.0"),
    ("gltf_corner/gltf_validator/base/data/asset/empty_array.gltf", None, "no version"),
    ("gltf_corner/gltf_validator/base/data/asset/invalid_version.gltf", None, "no version of that form"),
    ("gltf_corner/gltf_validator/base/data/asset/min_version_invalid.gltf", None, "needs a later glTF"),
    ("gltf_corner/gltf_validator/base/data/asset/min_version_valid.gltf", None, "needs a later glTF"),
    ("gltf_corner/gltf_validator/base/data/accessor/empty_object.gltf", None, "an accessor without a count"),
    ("gltf_corner/gltf_validator/base/data/buffer/empty_object.gltf", None, "a buffer without a length"),
    ("gltf_corner/gltf_validator/base/data/buffer/invalid_uri_data_bytelength.gltf", None, "a buffer without a length"),
    ("gltf_corner/gltf_validator/base/data/buffer/invalid_object.gltf", None, "a buffer that is a string"),
    ("gltf_corner/gltf_validator/base/data/buffer_view/empty_object.gltf", None, "a view without a buffer"),
    ("gltf_corner/gltf_validator/base/data/glb/chunk_too_big.glb", None, "a chunk longer than the file"),
    ("gltf_corner/gltf_validator/base/data/glb/json_and_two_buffers.glb", None, "two BIN chunks"),
    ("gltf_corner/gltf_validator/base/data/glb/length_mismatch.glb", None, "shorter than its header says"),
    ("gltf_corner/gltf_validator/base/data/glb/truncated_chunk_data.glb", None, "cut off in a chunk"),
    ("gltf_corner/gltf_validator/base/data/glb/two_valid_json_chunks.glb", None, "two JSON chunks"),
    ("gltf_corner/gltf_validator/base/data/node/infinite_transform.gltf", None, "a number that no float holds"),
    ("gltf_corner/gltf_validator/base/data/node/matrix_indecomposable.gltf", None, "a matrix that is not affine"),
    ("gltf_corner/gltf_validator/base/data/node/node_loop_scene.gltf", None, "a node that is its own ancestor"),
    ("gltf_corner/gltf_validator/base/data/node/node_parent_override.gltf", None, "a node with two parents"),
    (
        "gltf_corner/gltf_validator/base/data/scene/unresolved_default_scene.gltf",
        None,
        "a default scene that is not there",
    ),
];

#[test]
fn every_corner_file_is_read_rightly_or_refused_clearly() {
    let Some(models) = common::models_dir() else { return };
    let mut differences: BTreeMap<&str, Option<u64>> = DIFFERENCES.iter().map(|d| (d.0, d.1)).collect();
    let (mut wrong, mut read, mut refused) = (Vec::new(), 0, 0);
    for (name, counted) in corner_counts(&models) {
        let path = models.join(&name);
        let result = read_guarded(path.clone());
        match &result {
            Ok(scene) => assert_well_formed(scene, &name),
            Err(error) => assert_clear(error, &path, &name),
        }
        *if result.is_ok() { &mut read } else { &mut refused } += 1;
        let got = result.as_ref().ok().map(source_triangles);
        let is_right = match (differences.remove(name.as_str()), &result) {
            (Some(expected), _) => got == expected,
            (None, Ok(_)) => got.map(|g| g as i64) == Some(counted),
            (None, Err(SceneError::UnsupportedExtension { extension, .. })) => extension.ends_with("_compression"),
            (None, Err(_)) => counted == -1,
        };
        if !is_right {
            wrong.push(format!(
                "{name}: table {counted}, got {got:?} {}",
                result.err().map_or(String::new(), |e| e.to_string())
            ));
        }
    }
    println!("{read} files read, {refused} refused");
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
    assert!(differences.is_empty(), "listed but absent: {differences:?}");
}

/// Name, triangles with instances expanded, triangles stored once: `INDEX.md`'s columns.
type Known = (&'static str, u64, u64);

const SMALL: [Known; 17] = [
    ("anim_cesium_milk_truck/CesiumMilkTruck.glb", 3_624, 2_856),
    ("anim_cesiumman/CesiumMan.gltf", 4_672, 4_672),
    ("anim_fox/Fox.glb", 576, 576),
    ("anim_interpolation_test/InterpolationTest.gltf", 110, 110),
    ("anim_morph_cube/AnimatedMorphCube.gltf", 12, 12),
    ("anim_morph_stress/MorphStressTest.gltf", 2_412, 2_412),
    ("anim_soldier/Soldier.glb", 11_376, 11_376),
    ("ldraw_eiffel_tower/ldraw_eiffel_tower.glb", 135_950, 40_559),
    ("legocar/legocar.obj", 10_992, 10_992),
    ("obvhs_kitchen/kitchen.obj", 56_939, 56_939),
    ("sf_japanese_temple/sf_japanese_temple.glb", 29_696, 29_696),
    ("sf_pigman/scene.gltf", 37_136, 37_136),
    ("sf_steampunk_robot/scene.gltf", 23_898, 23_898),
    ("sf_terrarium_robots/scene.gltf", 55_682, 55_682),
    ("stanford_dragon/dragon_11k.obj", 11_102, 11_102),
    ("teapot/teapot.obj", 6_320, 6_320),
    ("tinybvh_balloon/scene.gltf", 35_698, 35_698),
];

const LARGE: [Known; 11] = [
    ("bitterli_kitchen/bitterli_kitchen.obj", 1_050_933, 1_050_933),
    ("bitterli_spaceship/bitterli_spaceship.obj", 257_480, 257_480),
    ("city_san_francisco/san_francisco.obj", 268_041, 268_041),
    ("ldraw_cafe_corner/ldraw_cafe_corner.glb", 912_344, 148_358),
    ("ldraw_falcon/ldraw_falcon.glb", 5_176_987, 317_605),
    ("sf_lamborghini/sf_lamborghini.glb", 145_917, 145_917),
    ("sf_macross_city/sf_macross_city.glb", 102_822, 102_822),
    ("sf_vino_bike/sf_vino_bike.glb", 95_598, 95_598),
    ("sponza_crytek_partial/sponza_crytek_partial.obj", 172_473, 172_473),
    ("sponza_dabrovic/sponza.obj", 66_450, 66_450),
    ("stanford_bunny/stanford_bunny.obj", 69_451, 69_451),
];

fn check_known(scenes: &[Known]) {
    let Some(models) = common::models_dir() else { return };
    for &(name, instanced, unique) in scenes {
        let started = std::time::Instant::now();
        let scene = scene::read(&models.join(name), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let seconds = started.elapsed().as_secs_f64();
        assert_well_formed(&scene, name);
        assert_eq!((source_triangles(&scene), unique_triangles(&scene)), (instanced, unique), "{name}");
        let bytes: u64 = scene.inputs.iter().map(|i| i.len).sum();
        println!("{name}: {:.0} ms, {:.0} MB/s, {:?}", seconds * 1e3, bytes as f64 / seconds / 1e6, scene.report);
    }
}

#[test]
fn small_scenes_have_their_known_counts() {
    check_known(&SMALL);
}

#[test]
#[ignore = "long: reads the large scenes"]
fn long_large_scenes_have_their_known_counts() {
    check_known(&LARGE);
}

#[test]
fn the_compressed_twins_of_a_scene_agree_where_they_can_be_read() {
    let Some(models) = common::models_dir() else { return };
    let read = |name: &str| scene::read(&models.join(name), &ReadOptions::default());
    let plain = read("ldraw_eiffel_tower/ldraw_eiffel_tower.glb").unwrap();
    for twin in ["eiffel_gpu_instancing.glb", "eiffel_quantized.glb"] {
        let twin = read(&format!("gltf_corner/variants/{twin}")).unwrap();
        let (a, b) = (world_box(&plain), world_box(&twin));
        let size = (0..3).map(|k| a[1][k] - a[0][k]).fold(0.0, f64::max);
        let far = a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(far < size * 1e-3, "{a:?} {b:?}");
    }
    for twin in ["eiffel_draco.glb", "eiffel_meshopt.glb"] {
        assert_eq!(read(&format!("gltf_corner/variants/{twin}")).unwrap_err().kind(), ErrorKind::Unsupported);
    }
}

/// The box of all vertices in world space.
fn world_box(scene: &Scene) -> [[f64; 3]; 2] {
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for instance in &scene.instances {
        for p in &scene.meshes[instance.mesh as usize].positions {
            let q = instance.transform.transform_point(p.map(f64::from));
            for k in 0..3 {
                bounds[0][k] = bounds[0][k].min(q[k]);
                bounds[1][k] = bounds[1][k].max(q[k]);
            }
        }
    }
    bounds
}
