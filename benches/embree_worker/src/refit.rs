//! Refits a triangle geometry whose vertices have moved.
//!
//! Input: the numbers of vertices, triangles and poses; the triangles' corners; the positions of each pose. A byte per request is the number of a pose. It is
//! answered by the milliseconds (f64) that committing it took, and the scene's box, six floats.
//!
//! The scene is dynamic and of low quality, since Embree refits geometries of others never. Positions are copied into Embree's buffer outside of the clock,
//! which runs from `rtcUpdateGeometryBuffer` until the scene is committed.

use crate::api::{Bounds, Device, SceneLibrary};
use std::io::{Error, Read, Result, Write};
use std::time::Instant;

/// `RTC_GEOMETRY_TYPE_TRIANGLE`, `RTC_SCENE_FLAG_DYNAMIC`, `RTC_BUILD_QUALITY_LOW` and `_REFIT`, `RTC_BUFFER_TYPE_INDEX` and `_VERTEX`,
/// `RTC_FORMAT_UINT3` and `_FLOAT3`.
pub const TRIANGLES: i32 = 0;
const DYNAMIC: i32 = 1;
const LOW: i32 = 0;
const REFIT: i32 = 3;
pub const INDEX: i32 = 0;
pub const VERTEX: i32 = 1;
pub const UINT3: i32 = 0x5003;
pub const FLOAT3: i32 = 0x9003;

pub fn serve(library: &SceneLibrary, device: Device, input: &mut impl Read, output: &mut impl Write) -> Result<()> {
    let mut counts = [0u32; 3];
    input.read_exact(bytemuck::cast_slice_mut(&mut counts))?;
    let [vertices, triangles, poses] = counts.map(|count| count as usize);
    let mut corners = vec![[0u32; 3]; triangles];
    input.read_exact(bytemuck::cast_slice_mut(&mut corners))?;
    let mut positions = vec![vec![[0f32; 3]; vertices]; poses];
    for pose in &mut positions {
        input.read_exact(bytemuck::cast_slice_mut(pose))?;
    }

    // SAFETY: the functions have the types of the public header, and the device is valid. Embree gives each buffer at least the bytes that were asked for,
    // aligned to 16, until its geometry is released, which never happens.
    let (scene, geometry, buffer) = unsafe {
        let scene = (library.new_scene)(device);
        (library.set_scene_flags)(scene, DYNAMIC);
        (library.set_scene_quality)(scene, LOW);
        let geometry = (library.new_geometry)(device, TRIANGLES);
        (library.set_geometry_quality)(geometry, REFIT);
        let index = (library.new_buffer)(geometry, INDEX, 0, UINT3, 12, triangles).cast::<[u32; 3]>();
        let buffer = (library.new_buffer)(geometry, VERTEX, 0, FLOAT3, 12, vertices).cast::<[f32; 3]>();
        if index.is_null() || buffer.is_null() {
            return Err(Error::other("Embree gave no buffer"));
        }
        index.copy_from_nonoverlapping(corners.as_ptr(), triangles);
        buffer.copy_from_nonoverlapping(positions[0].as_ptr(), vertices);
        (library.commit_geometry)(geometry);
        (library.attach)(scene, geometry);
        (library.commit_scene)(scene);
        (scene, geometry, buffer)
    };
    let mut request = [0];
    while input.read(&mut request)? == 1 {
        let Some(pose) = positions.get(request[0] as usize) else { return Err(Error::other("no such pose")) };
        let mut bounds = Bounds::default();
        // SAFETY: as above, and `Bounds` is `RTCBounds`.
        let milliseconds = unsafe {
            buffer.copy_from_nonoverlapping(pose.as_ptr(), vertices);
            let start = Instant::now();
            (library.update_buffer)(geometry, VERTEX, 0);
            (library.commit_geometry)(geometry);
            (library.commit_scene)(scene);
            let took = start.elapsed().as_secs_f64() * 1e3;
            (library.scene_bounds)(scene, &mut bounds);
            took
        };
        output.write_all(&milliseconds.to_ne_bytes())?;
        output.write_all(bytemuck::cast_slice(&[bounds.lower, bounds.upper]))?;
        output.flush()?;
    }
    Ok(())
}
