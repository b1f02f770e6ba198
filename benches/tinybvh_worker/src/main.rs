//! Builds trees with tinybvh 1.6.8 (the header in the package tinybvh-rs 0.1.0-beta.3) for a benchmark in another process.
//!
//! Input: a count and that many triangles of nine floats; then a byte per request, the number of a setting: binned with 8 bins, full sweep, spatial splits
//! with 8 bins, with 32, with 32 and 25 rounds of optimisation, with 32 and 50 extreme ones. Each is answered by the build's milliseconds (f64), the nodes as
//! 32-byte records `min, first, max, count` with their number (u32) before, and the leaf order of primitive indices with its number before. Everything is
//! in the machine's byte order. With `league` it also traces rays: see `benches/league/serve.rs`.

#[path = "../../league/serve.rs"]
mod serve;

use std::ffi::c_void;
use std::io::{Read, Result, Write, stdin, stdout};

#[repr(C)]
struct Raw([u8; 0]);

/// A `bvhvec4` of the header, which asks for 16 bytes of alignment.
#[repr(C, align(16))]
struct Vertex([f32; 4]);

// SAFETY: the types are those of `shim.cpp`, which this package compiles.
unsafe extern "C" {
    fn tree_build(vertices: *const f32, triangles: u32, setting: u32, wide: u32, milliseconds: *mut f64) -> *mut Raw;
    fn tree_nodes(tree: *const Raw, nodes: *mut *const c_void) -> u32;
    fn tree_indices(tree: *const Raw, indices: *mut *const u32) -> u32;
    fn tree_wide_nodes(tree: *const Raw, bytes: *mut f64) -> u32;
    fn tree_trace(tree: *const Raw, wide: u32, ray: *const f32, t: *mut f32, triangle: *mut u32) -> u32;
    fn tree_free(tree: *mut Raw);
    fn has_wide() -> u32;
}

/// A tree over vertices that outlive it.
struct Tree<'a> {
    raw: *mut Raw,
    wide: u32,
    milliseconds: f64,
    _vertices: &'a [Vertex],
}

impl Drop for Tree<'_> {
    fn drop(&mut self) {
        // SAFETY: made by `tree_build`, freed once.
        unsafe { tree_free(self.raw) }
    }
}

impl<'a> Tree<'a> {
    fn build(vertices: &'a [Vertex], setting: u8, wide: u8) -> Tree<'a> {
        let mut milliseconds = 0.0;
        let triangles = (vertices.len() / 3) as u32;
        // SAFETY: three vertices a triangle, of the header's size and alignment, borrowed for as long as the tree lives.
        let raw =
            unsafe { tree_build(vertices.as_ptr().cast(), triangles, setting.into(), wide.into(), &mut milliseconds) };
        Tree { raw, wide: wide.into(), milliseconds, _vertices: vertices }
    }

    fn nodes(&self) -> &[[u32; 8]] {
        let mut nodes = std::ptr::null();
        // SAFETY: so many records of 32 bytes, alive with the tree.
        unsafe {
            let count = tree_nodes(self.raw, &mut nodes) as usize;
            std::slice::from_raw_parts(nodes.cast(), count)
        }
    }

    /// The leaf order, up to the end of the last leaf. Slots in no leaf are 0: spatial splits set aside more than they write.
    fn indices(&self) -> Vec<u32> {
        let mut indices: *const u32 = std::ptr::null();
        // SAFETY: the tree is alive; this hands out a pointer and how many slots are behind it.
        let room = unsafe { tree_indices(self.raw, &mut indices) } as usize;
        let leaves = || {
            let ranges = self.nodes().iter().map(|node| (node[3] as usize, node[7] as usize));
            ranges.filter(|(first, count)| *count > 0 && first.saturating_add(*count) <= room)
        };
        let mut order = vec![0; leaves().map(|(first, count)| first + count).max().unwrap_or(0)];
        for (first, count) in leaves() {
            // SAFETY: the slots of a leaf lie within the room and were written by the build. The vector is of this function alone.
            unsafe {
                std::ptr::copy_nonoverlapping(indices.add(first), order[first..first + count].as_mut_ptr(), count)
            };
        }
        order
    }

    fn trace(&self, ray: &serve::Ray) -> Option<(f32, u32)> {
        let (mut t, mut triangle) = (0.0, 0);
        // SAFETY: the tree is alive, and a ray has eight floats.
        let hit = unsafe { tree_trace(self.raw, self.wide, ray.as_ptr(), &mut t, &mut triangle) };
        (hit == 1).then_some((t, triangle))
    }
}

fn main() -> Result<()> {
    let (mut input, mut output) = (stdin().lock(), stdout().lock());
    let floats = serve::triangles(&mut input)?;
    let vertices: Vec<Vertex> =
        floats.iter().flat_map(|t| [0, 3, 6].map(|i| Vertex([t[i], t[i + 1], t[i + 2], 0.0]))).collect();
    if std::env::args().nth(1).as_deref() == Some("league") {
        return serve::serve(&mut input, &mut output, |setting, wide, rays| {
            // SAFETY: it takes nothing. The library has no way from a full sweep to its wide trees.
            if wide == 1 && (setting == 1 || unsafe { has_wide() } == 0) {
                return None;
            }
            let tree = Tree::build(&vertices, setting, wide);
            let (nodes, bytes) = if wide == 1 {
                let mut bytes = 0.0;
                // SAFETY: the tree is alive.
                let nodes = unsafe { tree_wide_nodes(tree.raw, &mut bytes) };
                (f64::from(nodes), bytes)
            } else {
                let (nodes, indices) = (tree.nodes().len(), tree.indices().len());
                (nodes as f64, (32 * nodes + 4 * indices + size_of_val(&vertices[..])) as f64)
            };
            let (seconds, hits) = serve::traced(rays, |ray| tree.trace(ray));
            Some(serve::Told { milliseconds: tree.milliseconds, nodes, bytes, seconds, hits })
        });
    }
    let mut request = [0];
    while input.read(&mut request)? == 1 {
        let tree = Tree::build(&vertices, request[0], 0);
        let (nodes, indices) = (tree.nodes(), tree.indices());
        output.write_all(&tree.milliseconds.to_ne_bytes())?;
        output.write_all(&(nodes.len() as u32).to_ne_bytes())?;
        output.write_all(bytemuck::cast_slice(nodes))?;
        output.write_all(&(indices.len() as u32).to_ne_bytes())?;
        output.write_all(bytemuck::cast_slice(&indices))?;
        output.flush()?;
    }
    Ok(())
}
