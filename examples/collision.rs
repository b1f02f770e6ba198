//! A collision query: which triangles does a box touch? `cargo run --release --example collision -- FILE.bvhc X,Y,Z SIZE`
//!
//! The tree is walked by the public visitor; subtrees whose box the query misses are skipped. The file must have one level
//! (`bvhc build --levels one`).

use bvhc::Cache;
use bvhc::cache::{OpenOptions, Validation};
use bvhc::geom::{Aabb, clip::Polygon};
use bvhc::trace::Step;
use std::collections::BTreeSet;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [file, middle, size] = &args[..] else { return Err("usage: collision FILE.bvhc X,Y,Z SIZE".into()) };
    let middle = middle.split(',').map(str::parse).collect::<Result<Vec<f32>, _>>()?;
    let ([x, y, z], half) =
        (middle[..].try_into().map_err(|_| "the middle is three numbers, X,Y,Z")?, size.parse::<f32>()? / 2.0);
    let query = Aabb { min: [x - half, y - half, z - half], max: [x + half, y + half, z + half] };

    // A file from somebody else: every record is checked, so that the walk meets nothing but a tree.
    let cache = Cache::open_with(file, &OpenOptions { validation: Validation::Tree, ..OpenOptions::default() })?;
    if !cache.instances().is_empty() {
        return Err("the file has two levels; build it with --levels one".into());
    }
    let (mut touched, mut nodes, mut tests) = (BTreeSet::new(), 0, 0);
    for tree in cache.view().trees() {
        tree?.visit(|at| {
            nodes += 1;
            if !at.node.bounds().overlaps(&query) {
                return Step::Skip;
            }
            for triangle in at.triangles {
                tests += 1;
                // What of the triangle lies in the box? With spatial splits one triangle can stand in several leaves, hence the set.
                if !Polygon::inside(&triangle.corners(), &query).corners().is_empty() {
                    touched.insert((triangle.geom, triangle.prim));
                }
            }
            Step::Descend
        })?;
    }
    println!("{} triangles touch the box; {nodes} nodes and {tests} triangles were looked at", touched.len());
    for (geom, prim) in touched.iter().take(10) {
        println!("  {} triangle {prim}", cache.name(*geom));
    }
    Ok(())
}
