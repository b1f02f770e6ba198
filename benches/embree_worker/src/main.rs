//! Builds binary trees with Embree 4's builder interface for a benchmark in another process.
//!
//! `embree_worker LIBRARY THREADS`. Input: a count and that many triangles of nine floats; then a byte per request, 0 for LOW
//! (Morton codes), 1 for MEDIUM (binned SAH), 2 for HIGH (with spatial splits). Each is answered by the build's milliseconds (f64), the nodes as
//! 32-byte records `min, first, max, count` with their number (u32) before, and the leaf order of primitive indices with its
//! number before. Everything is in the machine's byte order.
//!
//! The time is that of `rtcBuildBVH` alone; primitive boxes are filled before it and nodes are renumbered after it, outside of the
//! clock, and its nodes come from Embree's own per-thread allocator.
//!
//! `embree_worker LIBRARY THREADS refit` refits instead, and with `trace` or `league` it traces rays: see `refit`, `rays` and `league`.

mod api;
mod league;
mod rays;
mod refit;
#[path = "../../league/serve.rs"]
mod serve;
mod tree;

use api::{BuildArguments, Library, Primitive, QUALITY_HIGH, QUALITY_LOW, QUALITY_MEDIUM, SceneLibrary, TraceLibrary};
use std::ffi::{CString, c_void};
use std::io::{Error, Read, Result, Write, stdin, stdout};
use std::time::Instant;

/// References that HIGH may make, as a multiple of the triangles.
const CAPACITY: f64 = 2.0;

/// What the callbacks need.
pub struct Scene {
    pub library: Library,
    pub triangles: Vec<[[f32; 3]; 3]>,
}

fn main() -> Result<()> {
    let mut args = std::env::args().skip(1);
    let (path, threads) = (args.next().unwrap_or_default(), args.next().unwrap_or_default());
    let library = Library::load(&path).map_err(Error::other)?;
    let config = CString::new(format!("threads={threads},set_affinity=0")).map_err(Error::other)?;
    // SAFETY: the pointer is to a string that ends with a zero and outlives the call.
    let device = unsafe { (library.new_device)(config.as_ptr()) };
    if device.is_null() {
        return Err(Error::other("rtcNewDevice gave no device"));
    }

    let (mut input, mut output) = (stdin().lock(), stdout().lock());
    if let Some(mode) = args.next() {
        let library = SceneLibrary::load(&path).map_err(Error::other)?;
        if mode == "refit" {
            return refit::serve(&library, device, &mut input, &mut output);
        }
        let tracing = TraceLibrary::load(&path).map_err(Error::other)?;
        if mode == "league" {
            return league::serve(&library, &tracing, device, &mut input, &mut output);
        }
        return rays::serve(&library, &tracing, device, &mut input, &mut output);
    }
    let mut count = [0; 4];
    input.read_exact(&mut count)?;
    let mut triangles = vec![[[0f32; 3]; 3]; u32::from_ne_bytes(count) as usize];
    input.read_exact(bytemuck::cast_slice_mut(&mut triangles))?;
    let scene = Scene { library, triangles };

    let mut request = [0];
    while input.read(&mut request)? == 1 {
        let quality = match request[0] {
            0 => QUALITY_LOW,
            1 => QUALITY_MEDIUM,
            _ => QUALITY_HIGH,
        };
        let (milliseconds, nodes, refs) = build(&scene, device, quality)?;
        output.write_all(&milliseconds.to_ne_bytes())?;
        output.write_all(&(nodes.len() as u32).to_ne_bytes())?;
        output.write_all(bytemuck::cast_slice(&nodes))?;
        output.write_all(&(refs.len() as u32).to_ne_bytes())?;
        output.write_all(bytemuck::cast_slice(&refs))?;
        output.flush()?;
    }
    Ok(())
}

fn build(scene: &Scene, device: api::Device, quality: i32) -> Result<(f64, Vec<[u32; 8]>, Vec<u32>)> {
    let count = scene.triangles.len();
    let capacity = if quality == QUALITY_HIGH { (count as f64 * CAPACITY) as usize } else { count };
    let mut primitives: Vec<Primitive> = scene.triangles.iter().enumerate().map(primitive).collect();
    // Before the build, which cuts and moves them.
    let whole = primitives.iter().fold([[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]], |[lower, upper], p| {
        [[0, 1, 2].map(|k| lower[k].min(p.lower[k])), [0, 1, 2].map(|k| upper[k].max(p.upper[k]))]
    });
    primitives.resize(capacity, Primitive::default());

    // SAFETY: the device is valid.
    let bvh = unsafe { (scene.library.new_bvh)(device) };
    // Leaves of 1 to 8 by the costs that everything is judged with, so that SAH and ray cost compare like with like.
    let arguments = BuildArguments {
        byte_size: size_of::<BuildArguments>(),
        quality,
        flags: 0,
        max_branching_factor: 2,
        max_depth: 64,
        sah_block_size: 1,
        min_leaf_size: 1,
        max_leaf_size: 8,
        traversal_cost: 1.2,
        intersection_cost: 1.0,
        bvh,
        primitives: primitives.as_mut_ptr(),
        primitive_count: count,
        primitive_array_capacity: capacity,
        create_node: tree::create_node,
        set_node_children: tree::set_node_children,
        set_node_bounds: tree::set_node_bounds,
        create_leaf: tree::create_leaf,
        split_primitive: Some(tree::split_primitive),
        build_progress: None,
        user: std::ptr::from_ref(scene).cast_mut().cast::<c_void>(),
    };
    let start = Instant::now();
    // SAFETY: the arguments have the layout of the public header; the array holds `capacity` records and outlives the call, and the
    // callbacks read `user` as the `Scene` that it is and never write to it.
    let root = unsafe { (scene.library.build)(&arguments) };
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    if root.is_null() && count > 0 {
        // SAFETY: the device is valid.
        return Err(Error::other(format!("rtcBuildBVH failed: error {}", unsafe {
            (scene.library.device_error)(device)
        })));
    }
    // SAFETY: the root was made by the callbacks of `tree`, and the BVH that owns its memory is released only afterwards.
    let (nodes, refs) = unsafe { tree::flatten(root, whole) };
    // SAFETY: made above, used no more.
    unsafe { (scene.library.release_bvh)(bvh) };
    Ok((milliseconds, nodes, refs))
}

fn primitive((i, corners): (usize, &[[f32; 3]; 3])) -> Primitive {
    let fold = |pick: fn(f32, f32) -> f32| [0, 1, 2].map(|k| pick(pick(corners[0][k], corners[1][k]), corners[2][k]));
    Primitive { lower: fold(f32::min), geometry: 0, upper: fold(f32::max), primitive: i as u32 }
}
