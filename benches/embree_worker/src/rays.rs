//! Traces rays through robust static scenes of one triangle geometry.
//!
//! Input: the numbers of vertices and triangles; the triangles' corners; the positions; then three sets of rays, each its number and eight floats a ray: origin,
//! least distance, direction, greatest distance. Two bytes a request are the number of a set, of which the third asks for any hit, and 0 for a scene of medium
//! quality or 1 for one of high quality. It is answered by the seconds (f64) that each 1,024 rays took, one after the other, and by how
//! many of the set hit (u64).

use crate::api::{Device, QUALITY_HIGH, QUALITY_MEDIUM, RayHit, SceneLibrary, TraceLibrary};
use crate::refit::{FLOAT3, INDEX, TRIANGLES, UINT3, VERTEX};
use std::io::{Error, Read, Result, Write};
use std::time::Instant;

/// `RTC_SCENE_FLAG_ROBUST`.
const ROBUST: i32 = 4;
/// Rays that a clock runs over.
const CHUNK: usize = 1024;

pub fn serve(
    library: &SceneLibrary,
    tracing: &TraceLibrary,
    device: Device,
    input: &mut impl Read,
    output: &mut impl Write,
) -> Result<()> {
    let mut counts = [0u32; 2];
    input.read_exact(bytemuck::cast_slice_mut(&mut counts))?;
    let [vertices, triangles] = counts.map(|count| count as usize);
    let mut corners = vec![[0u32; 3]; triangles];
    input.read_exact(bytemuck::cast_slice_mut(&mut corners))?;
    let mut positions = vec![[0f32; 3]; vertices];
    input.read_exact(bytemuck::cast_slice_mut(&mut positions))?;
    let mut sets = Vec::new();
    for _ in 0..3 {
        let mut count = [0; 4];
        input.read_exact(&mut count)?;
        let mut rays = vec![[0f32; 8]; u32::from_ne_bytes(count) as usize];
        input.read_exact(bytemuck::cast_slice_mut(&mut rays))?;
        sets.push(rays);
    }

    let mut scenes = Vec::new();
    for quality in [QUALITY_MEDIUM, QUALITY_HIGH] {
        // SAFETY: the functions have the types of the public header, and the device is valid. Embree gives each buffer at least the bytes that were asked
        // for, aligned to 16, until its geometry is released, which never happens.
        scenes.push(unsafe {
            let scene = (library.new_scene)(device);
            (library.set_scene_flags)(scene, ROBUST);
            (library.set_scene_quality)(scene, quality);
            let geometry = (library.new_geometry)(device, TRIANGLES);
            (library.set_geometry_quality)(geometry, quality);
            let index = (library.new_buffer)(geometry, INDEX, 0, UINT3, 12, triangles).cast::<[u32; 3]>();
            let buffer = (library.new_buffer)(geometry, VERTEX, 0, FLOAT3, 12, vertices).cast::<[f32; 3]>();
            if index.is_null() || buffer.is_null() {
                return Err(Error::other("Embree gave no buffer"));
            }
            index.copy_from_nonoverlapping(corners.as_ptr(), triangles);
            buffer.copy_from_nonoverlapping(positions.as_ptr(), vertices);
            (library.commit_geometry)(geometry);
            (library.attach)(scene, geometry);
            (library.commit_scene)(scene);
            scene
        });
    }
    let mut request = [0; 2];
    while input.read_exact(&mut request).is_ok() {
        let [set, scene] = request.map(usize::from);
        let (Some(rays), Some(scene)) = (sets.get(set), scenes.get(scene)) else {
            return Err(Error::other("no such set or scene"));
        };
        let mut hits = 0u64;
        for some in rays.chunks(CHUNK) {
            let start = Instant::now();
            for ray in some {
                let mut ray = RayHit::of(ray);
                // SAFETY: the scene is committed, and `RayHit` has the layout of the public header and at least its size and alignment. Without
                // arguments the defaults hold.
                unsafe {
                    if set == 2 {
                        (tracing.occluded)(*scene, &mut ray, std::ptr::null_mut());
                    } else {
                        (tracing.intersect)(*scene, &mut ray, std::ptr::null_mut());
                    }
                }
                hits += u64::from(if set == 2 { ray.is_occluded() } else { ray.is_hit() });
            }
            output.write_all(&start.elapsed().as_secs_f64().to_ne_bytes())?;
        }
        output.write_all(&hits.to_ne_bytes())?;
        output.flush()?;
    }
    Ok(())
}
