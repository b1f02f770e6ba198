//! Models far from the origin: what is kept of their shape, and what is said where it cannot be.

use crate::common::cases_dir;
use crate::{Place, gltf};
use bvhc::cache::Cache;
use bvhc::geom::Ray;
use bvhc::trace::closest_hit;

/// A wavy patch of 20 × 20 cells of 0.1, its first corner at the place given, as OBJ with four digits.
fn patch(at: [f64; 3]) -> String {
    let mut text = String::new();
    for (i, j) in (0..=20).flat_map(|i| (0..=20).map(move |j| (i, j))) {
        let height = 0.02 * (f64::from(i) * 0.7).sin() * (f64::from(j) * 0.9).cos();
        text +=
            &format!("v {:.4} {:.4} {:.4}\n", at[0] + 0.1 * f64::from(i), at[1] + height, at[2] + 0.1 * f64::from(j));
    }
    for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
        let a = 1 + i * 21 + j;
        text += &format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + 22, a + 22, a + 21);
    }
    text
}

/// Rays straight down onto the patch, all of which hit; where rays can start at all, that is at floats.
fn misses(cache: &Cache, at: [f64; 3]) -> usize {
    let place = |k: u32, a: usize| (at[a] + 1.99 * f64::from(k) / 40.0 + 0.005) as f32;
    let inside = |v: f32, a: usize| (at[a]..=at[a] + 2.0).contains(&f64::from(v));
    let rays = (0..=40).flat_map(|i| (0..=40).map(move |j| (place(i, 0), place(j, 2))));
    let rays = rays.filter(|(x, z)| inside(*x, 0) && inside(*z, 2));
    rays.filter(|(x, z)| {
        let ray =
            Ray { origin: [*x, at[1] as f32 + 5.0, *z], direction: [0.0, -1.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };
        closest_hit(&cache.view(), &ray).unwrap().is_none()
    })
    .count()
}

const FAR: [f64; 3] = [500_123.26, 102.5, -4_649_776.77];

#[test]
fn map_coordinates_are_built_about_an_origin_of_their_own() {
    let place = Place::new();
    place.write("far.obj", patch(FAR));
    let said = place.ok("build far.obj -o far.bvhc -v");
    assert!(said.out.contains("  800 tris") && !said.err.contains("warning"), "{}{}", said.out, said.err);
    assert!(said.err.contains("about origins of their own"), "{}", said.err);
    let cache = Cache::open(place.path("far.bvhc")).unwrap();
    assert_eq!(misses(&cache, FAR), 0);
    assert_eq!((cache.instances().len(), cache.blases().len(), cache.geoms()[0].kept_count), (1, 1, 800));
    place.ok("check far.bvhc --source far.obj");
    place.ok("verify far.bvhc --source far.obj --rays 2k --device cpu");
    assert!(place.ok("build far.obj -o far.bvhc").out.contains("up to date"));

    // Near the origin nothing changes, and in one tree far from it the loss is told.
    place.write("near.obj", patch([0.0; 3]));
    assert_eq!(place.ok("build near.obj -o near.bvhc").err, "");
    assert!(Cache::open(place.path("near.bvhc")).unwrap().instances().is_empty());
    let said = place.ok("build far.obj -o flat.bvhc --flatten");
    assert!(said.err.contains("it loses its shape: ") && said.err.contains("--levels auto"), "{}", said.err);
    assert!(said.err.contains("triangles without area"), "the policy holds where triangles are put: {}", said.err);
    place.ok("check flat.bvhc --source far.obj");
    assert_eq!(place.run("build far.obj -o none.bvhc --flatten --degenerate error").code, 4);
    let kept = place.ok("build far.obj -o kept.bvhc --flatten --degenerate keep");
    assert!(kept.out.contains("  800 tris") && kept.err.contains("kept "), "{}{}", kept.out, kept.err);
}

#[test]
fn a_model_that_was_rounded_before_is_told_with_figures() {
    let Some(cases) = cases_dir() else { return };
    let place = Place::new();
    place.write("far.obj", std::fs::read(cases.join("05-obj-utm-coordinates/patch_far.obj")).unwrap());
    let said = place.ok("build far.obj -o far.bvhc");
    assert!(said.err.contains("rounded before") && said.err.contains("0.500 apart"), "{}", said.err);
    assert!(said.err.contains("closer to the origin"), "{}", said.err);
}

#[test]
fn a_mesh_that_a_node_puts_far_away_keeps_its_shape() {
    let Some(cases) = cases_dir() else { return };
    let place = Place::new();
    for name in ["patch_far", "patch_far_twice"] {
        place.write(
            &format!("{name}.gltf"),
            std::fs::read(cases.join(format!("03-far-placed-mesh-baked/{name}.gltf"))).unwrap(),
        );
        let said = place.ok(&format!("build {name}.gltf -o {name}.bvhc"));
        assert_eq!(said.err, "", "{name}");
        let cache = Cache::open(place.path(&format!("{name}.bvhc"))).unwrap();
        assert_eq!(cache.blases()[0].prim_count, 800, "{name}");
        assert_eq!(misses(&cache, [500_123.25, 102.5, -4_649_776.75]), 0, "{name}");
        place.ok(&format!("check {name}.bvhc --source {name}.gltf"));
        place.ok(&format!("verify {name}.bvhc --source {name}.gltf --rays 2k --device cpu"));
    }
    for levels in ["one", "two"] {
        place.ok(&format!("build patch_far.gltf -o far.bvhc --levels {levels}"));
        place.ok("check far.bvhc --source patch_far.gltf");
    }
}

/// The first of two places has a matrix whose determinant cancels away, 2⁻⁴⁸ of terms near 1: no file could say how a ray gets into the mesh.
#[test]
fn a_matrix_whose_inverse_cannot_be_told_is_baked() {
    let place = Place::new();
    let (model, buffer) = crate::gltf("needle");
    let u = f64::from(1f32.next_down());
    let nodes = format!(r#""nodes":[{{"mesh":0,"matrix":[1,1,1,0,1,{u},1,0,1,1,{u},0,0,0,0,1]}},{{"mesh":0}}]"#);
    let model = model.replace(r#""nodes":[{"mesh":0}]"#, &nodes).replace(r#"[{"nodes":[0]}]"#, r#"[{"nodes":[0,1]}]"#);
    place.write("needle.gltf", model);
    place.write("needle.bin", buffer);
    for levels in ["one", "two"] {
        place.ok(&format!("build needle.gltf -o {levels}.bvhc --levels {levels}"));
        place.ok(&format!("check {levels}.bvhc --source needle.gltf"));
        place.ok(&format!("verify {levels}.bvhc --source needle.gltf --rays 2k --device cpu"));
    }
    let cache = Cache::open(place.path("two.bvhc")).unwrap();
    assert_eq!((cache.instances().len(), cache.blases().len()), (2, 2));
    assert!(cache.geoms().iter().any(|part| part.baked_node == 0));
}

/// One triangle at two nodes: below a node that is scaled by `flat` along an axis, turned before and after, and where nothing is flat.
fn flat_and_not(place: &Place, name: &str, turns: [[f64; 4]; 2], flat: f64) {
    let (model, bin) = gltf("t");
    let nodes = format!(
        r#""nodes":[{{"mesh":0,"rotation":{:?}}},{{"children":[0],"translation":[10.1,2.2,-3.3],"rotation":{:?},"scale":[1,1,{flat:e}]}},{{"mesh":0,"translation":[1.1,2.7,3.3]}}]"#,
        turns[0], turns[1]
    );
    let model = model.replace(r#""nodes":[{"mesh":0}]"#, &nodes).replace(r#"{"nodes":[0]}"#, r#"{"nodes":[1,2]}"#);
    assert!(model.contains("10.1") && model.contains("[1,2]"));
    place.write(name, model);
    place.write("t.bin", bin);
}

/// A unit quaternion, another one for each number.
fn turn(number: u32) -> [f64; 4] {
    let some = [0.7, 1.3, 2.1, 2.9].map(|k: f64| (k * f64::from(number + 1)).sin());
    let length = some.iter().map(|c| c * c).sum::<f64>().sqrt();
    some.map(|c| c / length)
}

#[test]
fn a_mesh_that_is_flat_at_one_node_is_whole_at_the_others() {
    let place = Place::new();
    for number in 0..12 {
        for flat in [0.0, 1e-17, 1e-9, 1e-6, 1e-3] {
            let turns = [turn(2 * number), turn(2 * number + 1)];
            flat_and_not(&place, "a.gltf", turns, flat);
            let said = place.ok("build a.gltf -o a.bvhc --warnings-as-errors");
            assert!(said.out.contains("2 tris"), "{number} {flat}: {}", said.out);
            let checked = place.ok("check a.bvhc --source a.gltf");
            assert_eq!(checked.err, "", "{number} {flat}");
            let verified = place.ok("verify a.bvhc --source a.gltf --device cpu --rays 300 --json").json();
            let hits = verified["files"][0]["oracle"]["hits_tested"].as_u64();
            assert!(hits.is_some_and(|hits| hits > 20), "{number} {flat}: {verified}");
        }
    }
}

#[test]
fn what_no_shift_can_keep_is_told() {
    let place = Place::new();
    let (model, bin) = gltf("t");
    place.write("t.bin", bin);
    for (x, what) in [("39040537200000.3", "loses its shape"), ("1.1e15", "loses its shape")] {
        let nodes = format!(r#""nodes":[{{"mesh":0,"translation":[{x},0,0]}},{{"mesh":0,"translation":[{x},3,0]}}]"#);
        let model = model.replace(r#""nodes":[{"mesh":0}]"#, &nodes).replace(r#"{"nodes":[0]}"#, r#"{"nodes":[0,1]}"#);
        place.write("a.gltf", model);
        let said = place.ok("build a.gltf -o a.bvhc");
        assert!(said.err.contains(what), "{x}: {}", said.err);
        assert!(said.out.contains("2 instances (2 tris)"), "{x}: {}", said.out);
        assert_eq!(place.run("build a.gltf -o b.bvhc --warnings-as-errors").code, 4);
    }
}

#[test]
fn what_a_morph_target_moves_beyond_the_range_is_not_called_nan() {
    let place = Place::new();
    let floats = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 3e38, 0.0, 0.0, 3e38, 0.0, 0.0, 3e38, 0.0, 0.0];
    place.write("t.bin", floats.iter().flat_map(|f| f.to_le_bytes()).collect::<Vec<u8>>());
    place.write(
        "a.gltf",
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0},{"mesh":1}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":1}]}],"weights":[5]},{"primitives":[{"attributes":{"POSITION":0}}]}],
        "buffers":[{"uri":"t.bin","byteLength":72}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
        {"bufferView":1,"componentType":5126,"count":3,"type":"VEC3","min":[3e38,0,0],"max":[3e38,0,0]}]}"#,
    );
    let said = place.ok("build a.gltf -o a.bvhc --json");
    let read = &said.json()["files"][0]["built"]["read"];
    assert_eq!((read["out_of_range_triangles"].as_u64(), read["non_finite_triangles"].as_u64()), (Some(1), Some(0)));
    assert!(said.err.contains("1.5e39") && !said.err.contains("NaN"), "{}", said.err);
}
