//! What a finished tree is worth: the work of probe rays in it, and the overlap that the SAH does not see.

use crate::exec::Executor;
use crate::geom::Aabb;
use crate::scene::Mesh;
use crate::trace::Lent;
use crate::trace::probe::{Camera, ProbeRays};
use crate::tree::Tree;
use crate::tree::quality::{Subtrees, epo, sah};

/// A quarter of a ray a triangle in each set, as far as these allow: small meshes pay little, and more rays than the most would not change
/// a choice.
const FEWEST: usize = 128;
const MOST: usize = 4096;
/// Triangles whose boxes the rays of a set may meet, taken together: where everything lies on top of everything, each meets them all.
const MOST_MET: f64 = 4e6;
/// Triangles that a task looks at. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 14;

/// How many rays of each set a mesh is worth, to judge its trees by and to adapt them to.
pub fn rays_for(mesh: &Mesh, exec: &Executor) -> usize {
    let count = (mesh.triangles.len() / 4).clamp(FEWEST, MOST);
    // A random ray meets a box inside another in proportion to their areas.
    let parts = exec.map_chunks(&mesh.triangles, CHUNK, |index, chunk| {
        let boxes = (0..chunk.len()).map(|i| mesh.triangle_box(index * CHUNK + i));
        boxes.fold((0.0, Aabb::EMPTY), |(sum, all), b| (sum + area(&b), all.union(b)))
    });
    let (sum, all) = parts.into_iter().fold((0.0, Aabb::EMPTY), |(sum, all), (a, b)| (sum + a, all.union(b)));
    let met = sum / area(&all);
    if met.is_finite() { count.min((MOST_MET / met) as usize).max(1) } else { count }
}

/// Half of it, in `f64`, which no box overflows.
fn area(b: &Aabb) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(b.max[k]) - f64::from(b.min[k]));
    x * y + y * z + z * x
}

/// Points of the surface at which the end-point overlap is asked.
const POINTS: usize = 2048;

/// Asks all trees of a mesh the same.
pub struct Gauge<'a> {
    mesh: &'a Mesh,
    exec: &'a Executor,
    /// Rays in each set.
    count: usize,
    rays: Option<ProbeRays>,
}

impl<'a> Gauge<'a> {
    /// About `count` rays in each set.
    pub fn new(mesh: &'a Mesh, count: usize, exec: &'a Executor) -> Gauge<'a> {
        Gauge { mesh, exec, count, rays: None }
    }

    /// C_T · nodes + C_I · triangles a ray, the mean of the three sets; the SAH, which has the same unit, where the cameras see nothing.
    ///
    /// The first tree that comes finds out where rays start: every tree of the mesh would find the same.
    pub fn cost(&mut self, tree: &Tree) -> f64 {
        let lent = Lent::new(self.mesh, tree, self.exec);
        let view = lent.view();
        let count = self.count;
        let rays = self.rays.get_or_insert_with(|| ProbeRays::around(&view, &Camera::around(&view), count));
        if rays.is_empty() { f64::from(sah(&tree.nodes)) } else { rays.cost(&view, self.exec).mean() }
    }

    /// How many rays a tree is asked with; 0 where the cameras saw nothing.
    pub fn rays(&self) -> usize {
        self.rays.as_ref().filter(|rays| !rays.is_empty()).map_or(0, |rays| (0..3).map(|set| rays.len(set)).sum())
    }

    /// The end-point overlap as a share of the SAH, both being what a ray pays.
    pub fn overlap_share(&self, tree: &Tree) -> f64 {
        let subtrees = Subtrees::new(&tree.nodes, &tree.refs, self.mesh.triangles.len());
        let overlap = epo::sampled(&subtrees, |t| self.mesh.corners(t), POINTS, epo::MOST_VISITS, self.exec).epo();
        let sah = f64::from(sah(&tree.nodes));
        if sah > 0.0 { overlap / sah } else { 0.0 }
    }
}
