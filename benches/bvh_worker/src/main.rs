//! Builds trees with the crate bvh for a benchmark in another process.
//!
//! `bvh_worker THREADS`: one thread takes `Bvh::build`, more take its parallel twin on that many. Input: a count and that many
//! triangles of nine floats; then a byte per request, whatever its value, since the crate has one setting. Each is answered by the build's
//! milliseconds (f64), the nodes as 32-byte records `min, first, max, count` with their number (u32) before, and the leaf order of
//! primitive indices with its number before. Everything is in the machine's byte order. The crate keeps boxes in the parents and
//! one triangle a leaf; writing them as records is outside of the clock.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::{Bvh, BvhNode};
use nalgebra::Point3;
use std::io::{Error, Read, Result, Write, stdin, stdout};
use std::time::Instant;

#[derive(Clone)]
struct Triangle {
    bounds: Aabb<f32, 3>,
    node: usize,
}

impl Bounded<f32, 3> for Triangle {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.bounds
    }
}

impl BHShape<f32, 3> for Triangle {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

fn main() -> Result<()> {
    let threads: usize = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(Error::other)?;
    let (mut input, mut output) = (stdin().lock(), stdout().lock());
    let mut count = [0; 4];
    input.read_exact(&mut count)?;
    let mut floats = vec![[0f32; 9]; u32::from_ne_bytes(count) as usize];
    input.read_exact(bytemuck::cast_slice_mut(&mut floats))?;
    let shape = |t: &[f32; 9]| {
        let fold = |pick: fn(f32, f32) -> f32| Point3::from([0, 1, 2].map(|k| pick(pick(t[k], t[k + 3]), t[k + 6])));
        Triangle { bounds: Aabb { min: fold(f32::min), max: fold(f32::max) }, node: 0 }
    };
    let triangles: Vec<Triangle> = floats.iter().map(shape).collect();

    let mut request = [0];
    while input.read(&mut request)? == 1 {
        let mut shapes = triangles.clone();
        let start = Instant::now();
        let tree = if threads == 1 { Bvh::build(&mut shapes) } else { pool.install(|| Bvh::build_par(&mut shapes)) };
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        let (nodes, refs) = records(&tree, &triangles);
        output.write_all(&milliseconds.to_ne_bytes())?;
        output.write_all(&(nodes.len() as u32).to_ne_bytes())?;
        output.write_all(bytemuck::cast_slice(&nodes))?;
        output.write_all(&(refs.len() as u32).to_ne_bytes())?;
        output.write_all(bytemuck::cast_slice(&refs))?;
        output.flush()?;
    }
    Ok(())
}

/// Pairs of siblings behind their parent, record 1 unused.
fn records(tree: &Bvh<f32, 3>, triangles: &[Triangle]) -> (Vec<[u32; 8]>, Vec<u32>) {
    let (mut nodes, mut refs) = (vec![[0; 8]; 2], Vec::new());
    if tree.nodes.is_empty() {
        return (Vec::new(), refs);
    }
    let whole = triangles.iter().fold(Aabb::empty(), |all, t| all.join(&t.bounds));
    let mut stack = vec![(0usize, 0usize, whole)];
    while let Some((at, node, bounds)) = stack.pop() {
        let (first, count) = match tree.nodes[node] {
            BvhNode::Leaf { shape_index, .. } => {
                refs.push(shape_index as u32);
                (refs.len() as u32 - 1, 1)
            }
            BvhNode::Node { child_l_index, child_l_aabb, child_r_index, child_r_aabb, .. } => {
                let pair = nodes.len();
                nodes.resize(pair + 2, [0; 8]);
                stack.push((pair + 1, child_r_index, child_r_aabb));
                stack.push((pair, child_l_index, child_l_aabb));
                (pair as u32, 0)
            }
        };
        let (a, b) = (bounds.min.coords.map(f32::to_bits), bounds.max.coords.map(f32::to_bits));
        nodes[at] = [a[0], a[1], a[2], first, b[0], b[1], b[2], count];
    }
    (nodes, refs)
}
