//! What a finished tree is worth: the work of probe rays in it, and the overlap that the SAH does not see.

use crate::build::exec::Executor;
use crate::scene::Mesh;
use crate::trace::Lent;
use crate::trace::probe::{Camera, ProbeRays};
use crate::tree::Tree;
use crate::tree::quality::{Subtrees, epo, sah};

/// A quarter of a ray a triangle in each set, as far as these allow: small meshes pay little, and more rays than the most would not change
/// a choice.
const FEWEST: usize = 128;
const MOST: usize = 4096;

/// How many rays of each set a mesh is worth, to judge its trees by and to adapt them to.
pub fn rays_for(triangles: usize) -> usize {
    (triangles / 4).clamp(FEWEST, MOST)
}

/// Points of the surface at which the end-point overlap is asked.
const POINTS: usize = 2048;

/// Asks all trees of a mesh the same.
pub struct Gauge<'a> {
    mesh: &'a Mesh,
    exec: &'a Executor,
    rays: Option<ProbeRays>,
}

impl<'a> Gauge<'a> {
    pub fn new(mesh: &'a Mesh, exec: &'a Executor) -> Gauge<'a> {
        Gauge { mesh, exec, rays: None }
    }

    /// C_T · nodes + C_I · triangles a ray, the mean of the three sets; the SAH, which has the same unit, where the cameras see nothing.
    ///
    /// The first tree that comes finds out where rays start: every tree of the mesh would find the same.
    pub fn cost(&mut self, tree: &Tree) -> f64 {
        let lent = Lent::new(self.mesh, tree, self.exec);
        let view = lent.view();
        let count = rays_for(self.mesh.triangles.len());
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
        let overlap = epo::sampled(&subtrees, |t| self.mesh.corners(t), POINTS, self.exec).epo();
        let sah = f64::from(sah(&tree.nodes));
        if sah > 0.0 { overlap / sah } else { 0.0 }
    }
}
