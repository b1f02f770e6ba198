//! Traces rays through Embree's own scenes for `benches/league.rs`: see `benches/league/serve.rs`.
//!
//! They are scenes of one triangle geometry with the library's default flags, so not robust ones. Their nodes have four or eight children, as the machine's
//! vectors ask, so they answer for the 8-wide form; to the binary trees of the builder interface the library has no rays.

use crate::api::{Device, QUALITY_HIGH, QUALITY_LOW, QUALITY_MEDIUM, RayHit, Scene, SceneLibrary, TraceLibrary};
use crate::refit::{FLOAT3, INDEX, TRIANGLES, UINT3, VERTEX};
use crate::serve;
use std::io::{Read, Result, Write};
use std::time::Instant;

pub fn serve(
    library: &SceneLibrary,
    tracing: &TraceLibrary,
    device: Device,
    input: &mut impl Read,
    output: &mut impl Write,
) -> Result<()> {
    let triangles = serve::triangles(input)?;
    serve::serve(input, output, |setting, wide, rays| {
        let quality = [QUALITY_LOW, QUALITY_MEDIUM, QUALITY_HIGH][usize::from(setting).min(2)];
        let start = Instant::now();
        let scene = (wide == 1).then(|| scene(library, device, &triangles, quality))??;
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        let (seconds, hits) = serve::traced(rays, |ray| {
            let mut hit = RayHit::of(ray);
            // SAFETY: the scene is committed, and `RayHit` has the layout of the public header and at least its size and alignment. Without arguments the
            // defaults hold.
            unsafe { (tracing.intersect)(scene, &mut hit, std::ptr::null_mut()) };
            hit.found()
        });
        Some(serve::Told { milliseconds, nodes: f64::NAN, bytes: f64::NAN, seconds, hits })
    })
}

/// A scene, which is never released; nothing where the library gives no memory.
fn scene(library: &SceneLibrary, device: Device, triangles: &[[f32; 9]], quality: i32) -> Option<Scene> {
    let count = triangles.len();
    let indices: Vec<u32> = (0..3 * count as u32).collect();
    // SAFETY: the functions have the types of the public header, and the device is valid. Embree gives each buffer at least the bytes that were asked for,
    // aligned to 16, until its geometry is released, which never happens.
    unsafe {
        let scene = (library.new_scene)(device);
        (library.set_scene_quality)(scene, quality);
        let geometry = (library.new_geometry)(device, TRIANGLES);
        (library.set_geometry_quality)(geometry, quality);
        let index = (library.new_buffer)(geometry, INDEX, 0, UINT3, 12, count).cast::<u32>();
        let buffer = (library.new_buffer)(geometry, VERTEX, 0, FLOAT3, 12, 3 * count).cast::<[f32; 9]>();
        if index.is_null() || buffer.is_null() {
            return None;
        }
        index.copy_from_nonoverlapping(indices.as_ptr(), 3 * count);
        buffer.copy_from_nonoverlapping(triangles.as_ptr(), count);
        (library.commit_geometry)(geometry);
        (library.attach)(scene, geometry);
        (library.commit_scene)(scene);
        Some(scene)
    }
}
