//! Sequences from frames to file and back: every frame is what a still build of it is, and what frames share is stored once.

use bvhc::build::{BuildOptions, NoProgress};
use bvhc::cache::check::{Level, Limits, check_bytes};
use bvhc::cache::keys::Recipe;
use bvhc::cache::{
    self, Cache, CacheError, Codec, FrameRecord, GeomRecord, IndexedTriangleRecord, Meta, OpenOptions, Parts,
    PoseRecord, Sequence, SequenceWriter, Validation,
};
use bvhc::exec::Executor;
use bvhc::geom::{Aabb, Affine, Ray};
use bvhc::scene::{self, Degenerate, Format, ReadOptions, Scene};
use bvhc::sequence::{FrameLabel, FrameOutcome, Refit, RefitPolicy, SequenceBuilder, Trees};
use bvhc::trace::closest_hit;
use bvhc::tree::Node;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A sheet of small triangles in waves, as an OBJ.
fn sheet(time: f32, side: usize) -> Scene {
    let mut obj = String::from("o sheet\n");
    for i in 0..side * side {
        let (x, z) = ((i % side) as f32, (i / side) as f32);
        writeln!(obj, "v {x} {} {z}", (x * 0.7 + time).sin() * 2.0 + (z * 0.3).cos()).unwrap();
    }
    for c in (0..side * (side - 1)).filter(|c| c % side != side - 1) {
        writeln!(obj, "f {} {} {} {}", c + 1, c + 2, c + side + 2, c + side + 1).unwrap();
    }
    read(&obj)
}

fn read(obj: &str) -> Scene {
    let options = ReadOptions { degenerate: Degenerate::Keep, ..ReadOptions::default() };
    scene::read_bytes(obj.as_bytes().to_vec(), "frame.obj", Some(Format::Obj), None, &options).unwrap()
}

fn read_faces(obj: &str) -> Scene {
    let options = ReadOptions { degenerate: Degenerate::Keep, faces: true, ..ReadOptions::default() };
    scene::read_bytes(obj.as_bytes().to_vec(), "frame.obj", Some(Format::Obj), None, &options).unwrap()
}

fn meta() -> Meta {
    cache::provenance(
        Recipe { method: "sbvh".into(), builder_revision: 1, options: Vec::new() },
        &[],
        &scene::ReadReport::default(),
    )
}

struct File {
    _folder: tempfile::TempDir,
    path: PathBuf,
    outcomes: Vec<FrameOutcome>,
}

fn build(frames: Vec<Scene>, policy: RefitPolicy, codec: Codec) -> File {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sequence.bvhc");
    let exec = Executor::sequential();
    let mut builder = SequenceBuilder::new(&path, &BuildOptions::default(), policy, codec, &exec, &NoProgress).unwrap();
    let label = |i: usize| FrameLabel { number: 10 + i as i32, time: Some(i as f32 / 24.0), held: false };
    let outcomes = frames.into_iter().enumerate().map(|(i, scene)| builder.add(scene, label(i)).unwrap()).collect();
    builder.finish(&meta()).unwrap();
    File { _folder: folder, path, outcomes }
}

fn check_clean(path: &Path) {
    let report =
        check_bytes(&std::fs::read(path).unwrap(), Level::Tree, None, &Limits::default(), &Executor::sequential());
    assert!(report.is_clean() && report.not_checked.is_empty(), "{:#?} {:?}", report.findings, report.not_checked);
}

fn rays() -> impl Iterator<Item = Ray> {
    (0..400).map(|i| {
        let (a, b) = ((i % 20) as f32, (i / 20) as f32);
        Ray::new([a * 0.55 + 0.1, 9.0, b * 0.5], [(b - 9.0) * 0.02, -1.0, (a - 9.0) * 0.03])
    })
}

/// Each frame of the file is hit where a still build of its scene is, by the same triangle of the model.
fn hits_are_those_of_still_builds(path: &Path, frames: impl Fn(usize) -> Scene) {
    let options = OpenOptions { validation: Validation::Tree, ..OpenOptions::default() };
    let sequence = Sequence::open_with(path, &options).unwrap();
    let exec = Executor::sequential();
    for number in 0..sequence.frame_count() {
        let frame = sequence.frame(number).unwrap();
        let accel = bvhc::compile::compile(frames(number), &BuildOptions::default(), &exec, &NoProgress).unwrap();
        let still = cache::Image::new(&accel, &exec).unwrap();
        let mut hits = 0;
        for ray in rays() {
            let (ours, theirs) = (closest_hit(&frame.view(), &ray).unwrap(), closest_hit(&still.view(), &ray).unwrap());
            assert_eq!(ours.map(|h| (h.t, h.prim)), theirs.map(|h| (h.t, h.prim)), "frame {number}, {ray:?}");
            assert_eq!((frame.closest_hit(&ray).unwrap(), frame.any_hit(&ray).unwrap()), (ours, ours.is_some()));
            if let Some(hit) = ours {
                let part = frame.part(hit.geom).unwrap();
                let normal = frame.normal(&hit, sequence.is_mirrored(part)).unwrap();
                let of_still = still.view().normal(&theirs.unwrap(), false, |id| {
                    still.instances.iter().position(|instance| instance.id == id)
                });
                assert_eq!((Some(normal), frame.node(&hit)), (of_still, Some(0)), "frame {number}, {ray:?}");
            }
            hits += usize::from(ours.is_some());
        }
        assert!(hits > 50, "{hits}");
    }
}

#[test]
fn a_mesh_that_moves_is_refitted_and_every_frame_is_hit_as_a_still_one() {
    let times = [0.0, 0.1, 0.2, 0.1, 0.0];
    for codec in [Codec::Raw, Codec::Zstd { level: 3 }] {
        let file = build(times.iter().map(|t| sheet(*t, 20)).collect(), RefitPolicy::default(), codec);
        check_clean(&file.path);
        let done: Vec<_> = file.outcomes.iter().map(|o| (o.built, o.refitted, o.same)).collect();
        assert_eq!(done, [(1, 0, 0), (0, 1, 0), (0, 1, 0), (0, 0, 1), (0, 0, 1)]);
        let sequence = Sequence::open(&file.path).unwrap();
        assert_eq!((sequence.topologies().len(), sequence.poses().len(), sequence.block_count()), (1, 3, 3));
        assert_eq!(sequence.poses().iter().map(|p| p.flags).collect::<Vec<_>>(), [PoseRecord::KEY, 0, 0]);
        assert_eq!(sequence.frames().iter().map(|f| f.number).collect::<Vec<_>>(), [10, 11, 12, 13, 14]);
        assert!(sequence.frames().iter().all(|f| f.flags == FrameRecord::TIMED));
        assert_eq!(sequence.numbered(12), Some(2));
        // Vertices are stored once: 400 places, not six for each of 361 quads.
        assert_eq!(sequence.topologies()[0].vertex_count, 400);
        hits_are_those_of_still_builds(&file.path, |i| sheet(times[i], 20));
    }
}

#[test]
fn a_mesh_that_tumbles_into_another_shape_is_built_anew_and_the_old_tree_serves_again() {
    // The whole sheet is shuffled: triangles that were neighbours are apart.
    let shuffled = |by: usize| {
        let mut scene = sheet(0.0, 20);
        let n = scene.meshes[0].positions.len();
        let old = scene.meshes[0].positions.clone();
        for (i, p) in scene.meshes[0].positions.iter_mut().enumerate() {
            *p = old[(i * by) % n];
        }
        scene
    };
    let frames = || vec![sheet(0.0, 20), shuffled(7), shuffled(7), sheet(0.05, 20)];
    let file = build(frames(), RefitPolicy::default(), Codec::Raw);
    check_clean(&file.path);
    let done: Vec<_> = file.outcomes.iter().map(|o| (o.built, o.refitted, o.same)).collect();
    assert_eq!(done, [(1, 0, 0), (1, 0, 0), (0, 0, 1), (0, 1, 0)], "{:?}", file.outcomes);
    hits_are_those_of_still_builds(&file.path, |i| frames().swap_remove(i));

    let never = build(frames(), RefitPolicy { refit: Refit::Never, ..RefitPolicy::default() }, Codec::Raw);
    assert_eq!(never.outcomes.iter().map(|o| o.built).sum::<u64>(), 3);
    let always = build(frames(), RefitPolicy { refit: Refit::Always, ..RefitPolicy::default() }, Codec::Raw);
    assert_eq!(always.outcomes.iter().map(|o| o.built).sum::<u64>(), 1);
    hits_are_those_of_still_builds(&always.path, |i| frames().swap_remove(i));
}

/// A quad that turns concave is cut along its other diagonal.
#[test]
fn quads_that_turn_concave_are_cut_anew() {
    let quad = |second: &str| read_faces(&format!("v 0 0 0\nv {second}\nv 2 0 2\nv 0 0 2\nf 1 2 3 4\n"));
    let (convex, concave) = (quad("2 0 0"), quad("0.5 0 1.2"));
    assert_ne!(convex.meshes[0].triangles, concave.meshes[0].triangles, "the reader cuts them otherwise");
    assert_eq!(convex.meshes[0].faces, concave.meshes[0].faces);
    let file = build(vec![convex, concave], RefitPolicy { refit: Refit::Always, ..RefitPolicy::default() }, Codec::Raw);
    check_clean(&file.path);
    // That diagonal would leave the face, so the frame keeps its own.
    assert_eq!(Sequence::open(&file.path).unwrap().topologies().len(), 2, "{:?}", file.outcomes);
}

#[test]
fn what_moves_as_a_whole_is_stored_once() {
    let at = |t: f32| {
        let mut scene = sheet(0.0, 20);
        scene.instances[0].transform = Affine::translation([f64::from(t), 0.0, 0.0]);
        scene
    };
    let file = build((0..20).map(|i| at(i as f32 * 0.25)).collect(), RefitPolicy::default(), Codec::Raw);
    check_clean(&file.path);
    let sequence = Sequence::open(&file.path).unwrap();
    assert_eq!((sequence.poses().len(), sequence.block_count()), (1, 1));
    hits_are_those_of_still_builds(&file.path, |i| at(i as f32 * 0.25));
}

#[test]
fn other_triangles_are_another_topology_and_an_empty_frame_shows_nothing() {
    let frames = || vec![read(""), sheet(0.0, 20), sheet(0.0, 21), read(""), sheet(0.1, 20)];
    let file = build(frames(), RefitPolicy::default(), Codec::Raw);
    check_clean(&file.path);
    let sequence = Sequence::open(&file.path).unwrap();
    assert_eq!(sequence.topologies().len(), 2);
    for empty in [0, 3] {
        let frame = sequence.frame(empty).unwrap();
        assert!(rays().all(|ray| closest_hit(&frame.view(), &ray).unwrap().is_none()));
    }
    let nothing = build(vec![read("")], RefitPolicy::default(), Codec::Raw);
    check_clean(&nothing.path);
}

#[test]
fn a_sequence_is_no_still_file_and_a_still_file_no_sequence() {
    let file = build(vec![sheet(0.0, 4), sheet(0.1, 4)], RefitPolicy::default(), Codec::Raw);
    let error = Cache::open(&file.path).unwrap_err();
    assert!(matches!(error, CacheError::Sequence { frames: 2, .. }), "{error}");
    let still = file.path.with_file_name("still.bvhc");
    bvhc::Build::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])
        .unwrap()
        .run()
        .unwrap()
        .write(&still)
        .unwrap();
    assert!(matches!(Sequence::open(&still).unwrap_err(), CacheError::Still { .. }));
    assert!(Sequence::open(&file.path).unwrap().frame(2).is_err());
}

/// What the format forbids is refused when it is written, and leaves no file.
#[test]
fn parts_that_break_a_rule_are_not_written() {
    let written = |parts: usize, change: fn(&mut [GeomRecord])| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bvhc");
        let exec = Executor::sequential();
        let mut writer = SequenceWriter::new(&path, Codec::Raw, &exec).unwrap();
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let nodes = [Node::leaf(Aabb::from_points(&points), 0, 1), bytemuck::Zeroable::zeroed()];
        let mut geoms: Vec<GeomRecord> = vec![bytemuck::Zeroable::zeroed(); parts];
        (geoms[0].prim_count, geoms[0].kept_count) = (1, 1);
        for (number, geom) in (1..).zip(&mut geoms[1..]) {
            (geom.source_part, geom.first_prim) = (number, 1);
        }
        change(&mut geoms);
        let corner = IndexedTriangleRecord { corners: [0, 1, 2], prim: 0, geom: 0, flags: 0 };
        let parts = Parts { geoms: &geoms, names: &[], materials: &[], sides: &[], vertices: &[] };
        let topology = writer.topology(&nodes, 3, [corner], &parts);
        writer.pose(topology, &nodes, &points, PoseRecord::KEY);
        let frame = FrameRecord { number: 0, placement: 0, time: 0.0, flags: 0, reserved: [0; 4] };
        writer.frame(frame, &[], &[]).unwrap();
        let result = writer.finish(&meta());
        let valid = std::fs::read(&path)
            .ok()
            .map(|bytes| check_bytes(&bytes, Level::Tree, None, &Limits::default(), &exec).is_valid());
        (result.map(drop), valid)
    };
    assert!(matches!(written(255, |_| ()), (Ok(()), Some(true))));
    assert!(matches!(written(256, |_| ()), (Err(CacheError::Unwritable { .. }), None)), "room for fewer");
    let told = |change| match written(3, change) {
        (Err(CacheError::Unwritable { detail, .. }), None) => detail,
        other => panic!("{other:?}"),
    };
    assert!(told(|geoms| geoms[2].first_prim = 0).contains("E0328"), "a number of the part before");
    assert!(told(|geoms| (geoms[2].first_prim, geoms[2].prim_count) = (u32::MAX, 1)).contains("E0316"));
}

/// Stored as differences, each frame is the same to the last bit, in whatever order they are opened; and the raw file comes back.
#[test]
fn differences_decode_to_the_raw_file() {
    let frames = || {
        let mut frames: Vec<Scene> = (0..11).map(|i| sheet(i as f32 * 0.3, 12)).collect();
        // A frame in which it stands as before, one with other triangles, and one of few decimals.
        frames[4] = sheet(0.9, 12);
        frames[6] = sheet(0.2, 9);
        frames[9] = sheet(0.0, 12);
        frames
    };
    let compact = Codec::Compact { level: 3 };
    let (raw, small) =
        (build(frames(), RefitPolicy::default(), Codec::Raw), build(frames(), RefitPolicy::default(), compact));
    check_clean(&small.path);
    let (whole, packed) = (std::fs::read(&raw.path).unwrap(), std::fs::read(&small.path).unwrap());
    assert!(packed.len() * 3 < whole.len(), "{} of {}", packed.len(), whole.len());

    let (a, b) = (Sequence::open(&raw.path).unwrap(), Sequence::open(&small.path).unwrap());
    assert_eq!(a.header().content_id, b.header().content_id);
    assert_eq!((b.header().minor, b.header().min_minor), (cache::DELTA_MIN_MINOR, cache::DELTA_MIN_MINOR));
    let of_codec = |codec| b.sections().iter().filter(move |s| s.codec == codec).count();
    assert!(of_codec(cache::SectionEntry::DELTA) >= 2 * b.block_count(), "{:?}", b.sections());
    for frame in [10, 0, 7, 3, 3, 9, 1, 6, 5, 8, 2, 4] {
        let (a, b) = (a.frame(frame).unwrap(), b.frame(frame).unwrap());
        let (a, b) = (a.view(), b.view());
        assert!(a.nodes == b.nodes && a.triangles == b.triangles && a.instances == b.instances, "frame {frame}");
        assert!(a.tlas_nodes == b.tlas_nodes && a.geoms == b.geoms && a.blases == b.blases, "frame {frame}");
    }

    // There and back, and from the one to the other.
    let converted = |from: &Path, codec| {
        let to = from.with_extension("converted");
        let write = cache::WriteOptions { codec, check: true };
        let options = cache::ConvertOptions { write, ..cache::ConvertOptions::default() };
        cache::convert(from, &to, &OpenOptions::default(), &options, &Executor::sequential()).unwrap();
        std::fs::read(to).unwrap()
    };
    assert!(converted(&small.path, Codec::Raw) == whole);
    assert!(converted(&raw.path, compact) == packed);
    assert!(converted(&small.path, compact) == packed);

    // What decoding takes is asked before it is allocated.
    let mut opened = 0;
    for max_memory in (2_000..80_000).step_by(1_000) {
        let options = OpenOptions { max_memory, ..OpenOptions::default() };
        let frame = |sequence: Sequence| sequence.frame(10).map(|frame| frame.view().triangles.len());
        match Sequence::open_with(&small.path, &options).and_then(frame) {
            Ok(triangles) => opened += usize::from(triangles == 242),
            Err(error) => assert!(opened == 0 && matches!(error, CacheError::Limit { .. }), "{max_memory}: {error}"),
        }
    }
    assert!((1..70).contains(&opened), "{opened}");
}

/// Trees with spatial splits have boxes that do not follow from the vertices: their nodes are packed as ever.
#[test]
fn boxes_that_are_cut_stay_as_they_are() {
    let beams = |time: f32| {
        let mut obj = String::new();
        for i in 0..40 {
            let (a, b) = (i as f32 * 0.31, (i * 7 % 40) as f32 * 0.29);
            writeln!(obj, "v {a} 0 {time}\nv {} 9 {b}\nv {} 9.1 {b}\nf -3 -2 -1", a + 3.0, a + 3.1).unwrap();
        }
        read(&obj)
    };
    let never = RefitPolicy { refit: Refit::Never, ..RefitPolicy::default() };
    let file = build(vec![beams(0.0), beams(0.5)], never, Codec::Compact { level: 3 });
    check_clean(&file.path);
    let sequence = Sequence::open(&file.path).unwrap();
    assert!(sequence.topologies().iter().any(|t| t.flags & cache::tree_flags::DUP_REFS != 0));
    let codecs = |kind| sequence.sections().iter().filter(move |s| s.kind == kind).map(|s| s.codec);
    assert!(codecs(cache::SectionKind::NODE).all(|codec| codec != cache::SectionEntry::DELTA));
    let other = build(vec![beams(0.0), beams(0.5)], never, Codec::Raw);
    let raw = Sequence::open(&other.path).unwrap();
    for frame in 0..2 {
        assert!(sequence.frame(frame).unwrap().view().nodes == raw.frame(frame).unwrap().view().nodes);
    }
}

/// Labels that no file may have are refused with the frame, and nothing is written.
#[test]
fn frames_that_break_a_rule_are_refused() {
    let exec = Executor::sequential();
    let label = |number, time, held| FrameLabel { number, time, held };
    let refused = |labels: &[FrameLabel]| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bvhc");
        let options = BuildOptions::default();
        let policy = RefitPolicy::default();
        let mut builder = SequenceBuilder::new(&path, &options, policy, Codec::Raw, &exec, &NoProgress).unwrap();
        let scene = |i: usize| sheet(i as f32 * 0.2, 4);
        let added = labels.iter().enumerate().try_for_each(|(i, label)| builder.add(scene(i), *label).map(drop));
        let error = added.and_then(|()| builder.finish(&meta()).map(drop)).err();
        assert_eq!(path.exists(), error.is_none());
        error.map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(refused(&[label(-1, Some(0.0), false), label(3, Some(1.0), false)]), "");
    for (labels, said) in [
        (&[][..], "one frame at least"),
        (&[label(2, None, false), label(2, None, false)], "frame 2 comes after frame 2"),
        (&[label(0, Some(f32::NAN), false)], "times are finite"),
        (&[label(0, None, true)], "there is none"),
        (&[label(0, None, false), label(1, None, true)], "shows something else"),
    ] {
        let error = refused(labels);
        assert!(error.contains(said), "{labels:?}: {error}");
    }
}

#[test]
fn the_file_does_not_depend_on_threads() {
    let bytes = |threads, trees| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bvhc");
        let exec = Executor::new(threads).unwrap();
        let policy = RefitPolicy::default();
        let mut builder =
            SequenceBuilder::new(&path, &BuildOptions::default(), policy, Codec::Raw, &exec, &NoProgress).unwrap();
        if let Some(trees) = trees {
            builder.survey((0..3).map(|i| sheet(i as f32 * 0.2, 24)).collect(), trees).unwrap();
        }
        for i in 0..3 {
            builder.add(sheet(i as f32 * 0.2, 24), FrameLabel { number: i, time: None, held: false }).unwrap();
        }
        builder.finish(&meta()).unwrap();
        std::fs::read(path).unwrap()
    };
    for trees in [None, Some(Trees::Auto)] {
        assert!(bytes(1, trees) == bytes(5, trees), "{trees:?}");
    }
}
