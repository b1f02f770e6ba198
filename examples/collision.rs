//! A collision query: which triangles does a box touch? `cargo run --release --example collision -- FILE.bvhc X,Y,Z SIZE`
//!
//! The file is walked by the public visitor; what lies below a box that the query misses is skipped. In a file of two levels the boxes and
//! triangles of an instance are carried into the world.

use bvhc::Cache;
use bvhc::cache::{OpenOptions, Validation};
use bvhc::geom::{Aabb, Affine, clip::Polygon};
use bvhc::trace::{SceneVisit, Step};
use std::collections::BTreeSet;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [file, middle, size] = &args[..] else { return Err("usage: collision FILE.bvhc X,Y,Z SIZE".into()) };
    let middle = middle.split(',').map(str::parse).collect::<Result<Vec<f32>, _>>()?;
    let ([x, y, z], half) =
        (middle[..].try_into().map_err(|_| "the middle is three numbers, X,Y,Z")?, size.parse::<f32>()? / 2.0);
    let query = Aabb { min: [x - half, y - half, z - half], max: [x + half, y + half, z + half] };

    // A file from somebody else: every record is checked, so that the walk meets nothing but trees.
    let cache = Cache::open_with(file, &OpenOptions { validation: Validation::Tree, ..OpenOptions::default() })?;
    let (mut touched, mut nodes, mut tests) = (BTreeSet::new(), 0, 0);
    let mut to_world = Affine::IDENTITY;
    cache.view().visit(|place| {
        let met = match place {
            SceneVisit::Instance { instance, .. } => {
                to_world = Affine::from_f32(&instance.object_to_world);
                true
            }
            SceneVisit::Top { node, .. } => node.bounds().overlaps(&query),
            SceneVisit::Tree { at, .. } => to_world.transform_box(&at.node.bounds()).overlaps(&query),
            _ => true,
        };
        nodes += usize::from(!matches!(place, SceneVisit::Instance { .. }));
        if let (true, SceneVisit::Tree { instance, at }) = (met, place) {
            tests += at.triangles.len();
            // What of the triangle lies in the box? With spatial splits one triangle can stand in several leaves, hence the set.
            let inside = |corners| !Polygon::inside(&corners, &query).corners().is_empty();
            let found = at.triangles.iter().filter(|t| inside(t.corners().map(|corner| to_world.bake(corner))));
            touched.extend(found.map(|t| (instance.map(|i| i.id), t.geom, t.prim)));
        }
        if met { Step::Descend } else { Step::Skip }
    })?;
    println!("{} triangles touch the box; {nodes} nodes and {tests} triangles were looked at", touched.len());
    for (instance, geom, prim) in touched.iter().take(10) {
        let place = instance.map_or(String::new(), |id| format!(" of instance {id}"));
        println!("  {} triangle {prim}{place}", cache.name(*geom));
    }
    Ok(())
}
