//! Models: whatever their bytes are, reading ends in a scene or an error, and a scene becomes a valid cache.

use super::{Target, limit};
use crate::guard::within;
use crate::mutate::{document, text};
use crate::planted::Seen;
use bvhc::build::{BuildOptions, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::cache::check::{Limits, check_image};
use bvhc::compile::compile;
use bvhc::exec::Executor;
use bvhc::scene::{Degenerate, Format, ReadOptions, Scene, read_bytes};

pub const OBJ: Target = Target {
    name: "obj",
    run: |input| read(input, "a.obj", Format::Obj),
    change: text::change,
    faults: &["part 2", "before its group ends", "polygon"],
};

pub const GLTF: Target = Target {
    name: "gltf",
    run: |input| read(input, "a.gltf", Format::Gltf),
    change: document::change,
    faults: &["sparse", "out of range", "byteStride"],
};

pub const POSING: Target = Target {
    name: "posing",
    run: |input| read(input, "posed.gltf", Format::Gltf),
    change: document::change_pose,
    faults: &["unweighted", "inverse bind matrices", "uses joint"],
};

/// The limit, and a bit for texts of errors.
fn allowance(input: &[u8]) -> usize {
    limit(input) as usize + (16 << 10)
}

fn read(input: &[u8], name: &str, format: Format) -> Seen {
    let policies = [Degenerate::Drop, Degenerate::Keep, Degenerate::Error];
    let degenerate = policies[input.len() / 5 % 3];
    let options = ReadOptions { degenerate, max_memory: limit(input), ..ReadOptions::default() };
    let bytes = input.to_vec();
    match within(allowance(input), || read_bytes(bytes, name, Some(format), None, &options)) {
        Ok(scene) => {
            let seen = marks(&scene);
            hold(&scene);
            if input.len().is_multiple_of(4) {
                become_a_cache(scene);
            }
            seen
        }
        Err(error) => {
            let text = error.to_string();
            assert!(text.starts_with("cannot read ") && text.len() < 4096, "{text}");
            vec![text]
        }
    }
}

/// What planted faults may look for in a scene that was read.
fn marks(scene: &Scene) -> Seen {
    let report = &scene.report;
    let mut seen = Seen::new();
    let mut mark = |found: bool, name: &str| {
        if found {
            seen.push(name.to_owned());
        }
    };
    mark(scene.meshes.iter().any(|m| m.parts.len() > 2), "part 2");
    mark(report.out_of_range_instances > 0, "out of range");
    mark(report.unweighted_vertices > 0, "unweighted");
    mark(scene.meshes.iter().any(|m| m.parts.iter().any(|p| p.prim_count > 5)), "polygon");
    seen
}

/// What every scene holds, whatever it was read from.
fn hold(scene: &Scene) {
    scene.validate(&Executor::sequential()).unwrap_or_else(|e| panic!("the reader made it: {e}"));
    for mesh in &scene.meshes {
        assert!(mesh.remainders.is_empty() || mesh.remainders.len() == mesh.positions.len());
        assert!(mesh.remainders.iter().flatten().all(|r| r.is_finite()));
        assert!(mesh.source_prims.is_empty() || mesh.source_prims.len() == mesh.triangles.len());
        let in_parts: u64 = mesh.parts.iter().map(|p| u64::from(p.triangle_count)).sum();
        assert_eq!(in_parts, mesh.triangles.len() as u64, "parts cover the triangles");
    }
    for instance in &scene.instances {
        let corner = instance.transform.transform_point([1.0; 3]);
        assert!(corner.iter().all(|c| c.is_finite()), "{instance:?}");
    }
}

/// Small scenes are built, and what is built is valid.
fn become_a_cache(scene: Scene) {
    let triangles: usize = scene.instances.iter().map(|i| scene.meshes[i.mesh as usize].triangles.len()).sum();
    if triangles > 64 {
        return;
    }
    let exec = Executor::sequential();
    let options = BuildOptions::preset(Preset::Draft);
    let Ok(accel) = compile(scene, &options, &exec, &NoProgress) else { return };
    let Ok(image) = Image::new(&accel, &exec) else { return };
    let report = check_image(&image, &Limits::default(), &exec);
    assert!(report.is_valid(), "a scene became a cache that is not valid: {:?}", report.findings.first());
}
