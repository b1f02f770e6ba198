//! The examples that a newcomer reads run, and say what is so.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Examples are built beside the tests, which cargo does before any test runs.
fn example(name: &str) -> Command {
    let folder = std::env::current_exe().unwrap();
    let profile = folder.parent().and_then(Path::parent).unwrap();
    Command::new(profile.join("examples").join(name))
}

fn output(command: &mut Command) -> String {
    let out = command.output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8(out.stdout).unwrap()
}

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(name)
}

#[test]
fn own_geometry_is_built_written_and_asked() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("own.bvhc");
    let text = output(example("own_geometry").arg(&file));
    assert!(text.starts_with("4421 triangles, 101 instances\n"), "{text}");
    assert!(text.contains("of the tent, instance Some(1)"), "{text}");
    let checked = bvhc::cache::check::check_bytes(
        &std::fs::read(&file).unwrap(),
        bvhc::cache::check::Level::Tree,
        None,
        &Default::default(),
        &bvhc::exec::Executor::sequential(),
    );
    assert!(checked.is_clean(), "{:?}", checked.findings);
}

/// Two frames of an OBJ each.
fn sequence(file: &Path, frame: impl Fn(i32) -> String) {
    use bvhc::scene::{self, Format, ReadOptions};
    use bvhc::sequence::{FrameLabel, RefitPolicy, SequenceBuilder};
    let (exec, options) = (bvhc::exec::Executor::sequential(), bvhc::build::BuildOptions::default());
    let progress = bvhc::build::NoProgress;
    let codec = bvhc::cache::Codec::Raw;
    let mut builder = SequenceBuilder::new(file, &options, RefitPolicy::default(), codec, &exec, &progress).unwrap();
    for number in 0..2 {
        let obj = frame(number);
        let read = scene::read_bytes(obj.into(), "roof.obj", Some(Format::Obj), None, &ReadOptions::default()).unwrap();
        builder.add(read, FrameLabel { number, time: None, held: false }).unwrap();
    }
    builder.finish(&bvhc::cache::Meta::default()).unwrap();
}

/// Three bytes a pixel.
fn pixels_of(picture: &Path) -> Vec<u8> {
    let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(picture).unwrap()));
    let mut reader = reader.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels
}

#[test]
fn a_sequence_is_played() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.bvhc");
    // A roof that sinks by one unit a frame.
    sequence(&file, |number| format!("o roof\nv -1 -1 {0}\nv 1 -1 {0}\nv 0 1 {0}\nf 1 2 3\n", 5 - number));
    let text = output(example("frames").arg(&file));
    let hits: Vec<&str> = text.lines().filter_map(|line| line.split_once("triangles  ")).map(|(_, hit)| hit).collect();
    // The box that the ray starts above is rounded outward.
    let roofs = ["triangle 0 of 'roof' at 2.00000", "triangle 0 of 'roof' at 3.00000"];
    assert!(hits.len() == 2 && hits.iter().zip(roofs).all(|(hit, roof)| hit.starts_with(roof)), "{text}");
}

/// Where a roof was half of the time, its pixels are between the roof's and the sky's.
#[test]
fn what_moves_is_blurred() {
    let folder = tempfile::tempdir().unwrap();
    let (file, picture) = (folder.path().join("s.bvhc"), folder.path().join("s.png"));
    sequence(&file, |number| format!("o roof\nv {0} 0 -1\nv {0} 0 1\nv {1} 0 0\nf 1 2 3\n", -number, 2 - number));
    output(example("motion_blur").args([&file, &picture]));
    let pixels = pixels_of(&picture);
    let share =
        |is: &dyn Fn(u8) -> bool| pixels.chunks(3).filter(|p| is(p[0])).count() as f32 / (pixels.len() / 3) as f32;
    let roof = *pixels.chunks(3).map(|p| &p[0]).max().unwrap();
    let (clear, blurred) = (share(&|red| red == roof), share(&|red| red > 28 && red < roof - 4));
    assert!(clear > 0.002 && blurred > 0.01, "{clear} of the picture is roof, {blurred} blurred");

    // The time between a frame and itself is that frame: but for pixels at its edges, everything is roof or sky.
    output(example("motion_blur").args([&file, &picture]).args(["1", "1"]));
    let pixels = pixels_of(&picture);
    let still = pixels.chunks(3).filter(|p| p[0] > 28 && p[0] < roof - 4).count() as f32 / (pixels.len() / 3) as f32;
    assert!(still < blurred / 3.0, "{still} blurred where nothing moves, {blurred} where it does");
}

#[test]
fn the_renderer_sees_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let (file, picture) = (folder.path().join("p.bvhc"), folder.path().join("p.png"));
    bvhc::Build::of_model(sample("pillar.obj")).unwrap().run().unwrap().write(&file).unwrap();
    output(example("render").args([&file, &picture]));
    let pixels = pixels_of(&picture);
    let seen = pixels.chunks(3).filter(|p| *p != [24, 28, 36]).count();
    assert!(seen > pixels.len() / 3 / 50, "{seen} pixels of {} show the scene", pixels.len() / 3);
}

#[test]
fn a_box_touches_what_brute_force_says() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("c.bvhc");
    let built = bvhc::Build::of_model(sample("colonnade.obj")).unwrap().run().unwrap();
    built.write(&file).unwrap();
    let bounds = bvhc::Cache::open(&file).unwrap().header().scene_bounds();
    let [x, y, z] = bounds.center2().map(|c| c / 2.0);
    let size = bounds.extent()[0] / 4.0;
    let text = output(example("collision").arg(&file).arg(format!("{x},{y},{z}")).arg(size.to_string()));
    let half = size / 2.0;
    let query = bvhc::geom::Aabb { min: [x - half, y - half, z - half], max: [x + half, y + half, z + half] };
    let inside = |t: &&bvhc::cache::TriangleRecord| {
        !bvhc::geom::clip::Polygon::inside(&t.corners(), &query).corners().is_empty()
    };
    let slots = built.view().triangles;
    let expected: std::collections::BTreeSet<_> = slots.iter().filter(inside).map(|t| (t.geom, t.prim)).collect();
    assert!(!expected.is_empty() && expected.len() < slots.len(), "the query is a part of the scene");
    assert!(text.starts_with(&format!("{} triangles touch the box", expected.len())), "{text}");
}

/// Trees and their instances: every triangle of every instance is put into the world and held against the box.
#[test]
fn a_box_touches_what_brute_force_says_in_two_levels() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("f.bvhc");
    let built = bvhc::Build::of_model(sample("forest.gltf")).unwrap().run().unwrap();
    built.write(&file).unwrap();
    let view = built.view();
    let bounds = view.tlas_nodes[0].bounds();
    let [x, y, z] = bounds.center2().map(|c| c / 2.0);
    let size = bounds.extent()[0] / 5.0;
    let text = output(example("collision").arg(&file).arg(format!("{x},{y},{z}")).arg(size.to_string()));
    let half = size / 2.0;
    let query = bvhc::geom::Aabb { min: [x - half, y - half, z - half], max: [x + half, y + half, z + half] };
    let (mut expected, mut all) = (std::collections::BTreeSet::new(), 0);
    for instance in view.instances {
        let to_world = bvhc::geom::Affine::from_f32(&instance.object_to_world);
        let triangles = view.blas(instance.blas as usize).unwrap().triangles;
        all += triangles.len();
        let corners = |t: &bvhc::cache::TriangleRecord| t.corners().map(|corner| to_world.bake(corner));
        let inside = |t: &&bvhc::cache::TriangleRecord| {
            !bvhc::geom::clip::Polygon::inside(&corners(t), &query).corners().is_empty()
        };
        expected.extend(triangles.iter().filter(inside).map(|t| (instance.id, t.geom, t.prim)));
    }
    let instances = expected.iter().map(|(instance, ..)| instance).collect::<std::collections::BTreeSet<_>>();
    assert!(instances.len() > 1 && expected.len() < all / 2, "{} of {all} in {instances:?}", expected.len());
    assert!(text.starts_with(&format!("{} triangles touch the box", expected.len())), "{text}");
    // What the query misses is not looked at.
    let looked_at: usize = text.split(" nodes and ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(looked_at < all, "{looked_at} of {all}");
}

#[test]
fn the_renderer_has_sixty_lines() {
    let text = std::fs::read_to_string(sample("../examples/render.rs")).unwrap();
    assert!(text.lines().count() <= 60 && text.lines().all(|line| line.chars().count() <= 120));
}

#[test]
fn a_wrong_call_is_told_and_nothing_is_written() {
    for name in ["own_geometry", "render", "collision"] {
        let folder = tempfile::tempdir().unwrap();
        let out = example(name).current_dir(&folder).output().unwrap();
        assert_eq!(out.status.code(), Some(1), "{name}: {out:?}");
        let said = String::from_utf8_lossy(&out.stderr);
        assert!(said.starts_with(&format!("Error: \"usage: {name} ")) && out.stdout.is_empty(), "{name}: {said}");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0, "{name}");
    }
}
