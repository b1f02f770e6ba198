//! Builds trees with the crate bvh for a benchmark in another process.
//!
//! `bvh_worker THREADS`: one thread takes `Bvh::build`, more take its parallel twin on that many. Input: a count and that many
//! triangles of nine floats; then a byte per request, whatever its value, since the crate has one setting. Each is answered by the build's
//! milliseconds (f64), the nodes as 32-byte records `min, first, max, count` with their number (u32) before, and the leaf order of
//! primitive indices with its number before. Everything is in the machine's byte order. The crate keeps boxes in the parents and
//! one triangle a leaf; writing them as records is outside of the clock. `bvh_worker THREADS league` also traces rays: see `benches/league/serve.rs`. The crate's
//! traversal gives candidates, which are tested here in double precision, since its own triangle test leaves out triangles that are seen from behind.

#[path = "../../league/serve.rs"]
mod serve;

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::{Bvh, BvhNode};
use bvh::ray::Ray;
use nalgebra::{Point3, Vector3};
use std::io::{Error, Read, Result, Write, stdin, stdout};
use std::time::Instant;

#[derive(Clone)]
struct Triangle {
    bounds: Aabb<f32, 3>,
    node: usize,
    index: u32,
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
    let floats = serve::triangles(&mut input)?;
    let shape = |(i, t): (usize, &[f32; 9])| {
        let fold = |pick: fn(f32, f32) -> f32| Point3::from([0, 1, 2].map(|k| pick(pick(t[k], t[k + 3]), t[k + 6])));
        Triangle { bounds: Aabb { min: fold(f32::min), max: fold(f32::max) }, node: 0, index: i as u32 }
    };
    let triangles: Vec<Triangle> = floats.iter().enumerate().map(shape).collect();

    let build = |shapes: &mut Vec<Triangle>| {
        if threads == 1 { Bvh::build(shapes) } else { pool.install(|| Bvh::build_par(shapes)) }
    };
    if std::env::args().nth(2).as_deref() == Some("league") {
        return serve::serve(&mut input, &mut output, |_, wide, rays| {
            let mut shapes = triangles.clone();
            let start = Instant::now();
            let tree = (wide == 0).then(|| build(&mut shapes))?;
            let milliseconds = start.elapsed().as_secs_f64() * 1e3;
            let (seconds, hits) = serve::traced(rays, |ray| nearest(&tree, &shapes, &floats, ray));
            let bytes = size_of_val(&tree.nodes[..]) + size_of_val(&shapes[..]) + size_of_val(&floats[..]);
            Some(serve::Told { milliseconds, nodes: tree.nodes.len() as f64, bytes: bytes as f64, seconds, hits })
        });
    }
    let mut request = [0];
    while input.read(&mut request)? == 1 {
        let mut shapes = triangles.clone();
        let start = Instant::now();
        let tree = build(&mut shapes);
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

/// The nearest of the triangles whose boxes the crate's traversal gives.
fn nearest(tree: &Bvh<f32, 3>, shapes: &[Triangle], floats: &[[f32; 9]], ray: &serve::Ray) -> Option<(f32, u32)> {
    let direction = Vector3::new(ray[4], ray[5], ray[6]);
    let asked =
        Ray { origin: Point3::new(ray[0], ray[1], ray[2]), direction, inv_direction: direction.map(|x| 1.0 / x) };
    let mut best: Option<(f32, u32)> = None;
    for shape in tree.traverse_iterator(&asked, shapes) {
        let t = test(&floats[shape.index as usize], ray).map(|t| t as f32);
        if let Some(t) = t.filter(|t| best.is_none_or(|(nearest, _)| *t < nearest)) {
            best = Some((t, shape.index));
        }
    }
    best
}

/// The distance at which a ray meets a triangle from either side, its border included (Möller and Trumbore 1997).
fn test(t: &[f32; 9], ray: &serve::Ray) -> Option<f64> {
    let corner = |i: usize| Vector3::new(t[i], t[i + 1], t[i + 2]).map(f64::from);
    let (a, direction) = (corner(0), Vector3::new(ray[4], ray[5], ray[6]).map(f64::from));
    let (ab, ac) = (corner(3) - a, corner(6) - a);
    let from = Vector3::new(ray[0], ray[1], ray[2]).map(f64::from) - a;
    let p = direction.cross(&ac);
    let det = ab.dot(&p);
    let (u, q) = (from.dot(&p) / det, from.cross(&ab));
    let (v, distance) = (direction.dot(&q) / det, ac.dot(&q) / det);
    (det != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance >= 0.0).then_some(distance)
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
