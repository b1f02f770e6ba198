//! What a finished tree is worth: the work of rays of all families in it, and the overlap that the SAH does not see.

use crate::build::Purpose;
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::scene::Mesh;
use crate::trace::Lent;
use crate::trace::probe::{Family, FamilyCost, FamilyRays};
use crate::tree::Tree;
use crate::tree::quality::{Subtrees, epo, sah};

/// A quarter of a ray a triangle in each family, as far as these allow: small meshes pay little. With the most of them, what two trees of a
/// real scene differ by in a family is known to some tenths of a per cent, which is less than what decides.
const FEWEST: usize = 128;
const MOST: usize = 2048;
/// Triangles whose boxes the rays of a family may meet, taken together: where everything lies on top of everything, each meets them all.
const MOST_MET: f64 = 2e6;
/// Triangles that a task looks at. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 14;

/// The seeds of the rays that judge, and of those that form.
const JUDGING: u64 = 7;
pub const FORMING: u64 = 11;

/// How many rays of each family a mesh is worth, to judge its trees by and to adapt them to.
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

/// Whether a family is asked for a purpose.
pub fn serves(family: Family, purpose: Purpose) -> bool {
    use Family as F;
    match purpose {
        Purpose::All => true,
        Purpose::Camera => matches!(family, F::Outside | F::Inside | F::Bounce | F::Occlusion | F::Light),
        Purpose::Bake => matches!(family, F::Bounce | F::Occlusion | F::Light | F::Area | F::Triangles),
        Purpose::Physics => matches!(family, F::Inside | F::Triangles | F::Chords),
    }
}

/// Points of the surface at which the end-point overlap is asked.
const POINTS: usize = 2048;

/// Asks all trees of a mesh the same.
pub struct Gauge<'a> {
    mesh: &'a Mesh,
    exec: &'a Executor,
    /// Rays in each family.
    count: usize,
    purpose: Purpose,
    rays: Option<FamilyRays>,
}

/// What was measured of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// `None` where no family has rays.
    pub cost: Option<FamilyCost>,
    pub sah: f64,
}

impl Measure {
    /// C_T · nodes + C_I · triangles a ray, the mean of the families; the SAH, which has the same unit, where there are no rays.
    pub fn mean(&self) -> f64 {
        let Some(cost) = &self.cost else { return self.sah };
        let means: Vec<f64> = Family::ALL.into_iter().filter_map(|family| cost.mean(family)).collect();
        means.iter().sum::<f64>() / means.len().max(1) as f64
    }
}

impl<'a> Gauge<'a> {
    /// About `count` rays in each family.
    pub fn new(mesh: &'a Mesh, count: usize, exec: &'a Executor) -> Gauge<'a> {
        Gauge { mesh, exec, count, purpose: Purpose::All, rays: None }
    }

    /// Rays of the families that serve a purpose, and no others.
    pub fn serving(self, purpose: Purpose) -> Gauge<'a> {
        Gauge { purpose, ..self }
    }

    /// What rays pay in the tree.
    ///
    /// The first tree that comes finds out where rays start: every tree of the mesh would find the same.
    pub fn measure(&mut self, tree: &Tree) -> Measure {
        let lent = Lent::new(self.mesh, tree, self.exec);
        let view = lent.view();
        let (count, purpose, exec) = (self.count, self.purpose, self.exec);
        let rays = self.rays.get_or_insert_with(|| {
            let mut rays = FamilyRays::new(&view, count, JUDGING, exec);
            let is_empty = rays.is_empty();
            rays.retain(|family| serves(family, purpose) && !is_empty);
            rays
        });
        let is_empty = Family::ALL.into_iter().all(|family| rays.len(family) == 0);
        Measure { cost: (!is_empty).then(|| rays.cost(&view, exec)), sah: f64::from(sah(&tree.nodes)) }
    }

    /// How many rays a tree is asked with, and of how many families; 0 where nothing can be hit.
    pub fn rays(&self) -> (usize, usize) {
        let lengths = self.rays.iter().flat_map(|rays| Family::ALL.map(|family| rays.len(family)));
        lengths.fold((0, 0), |(rays, families), length| (rays + length, families + usize::from(length > 0)))
    }

    /// The end-point overlap as a share of the SAH, both being what a ray pays.
    pub fn overlap_share(&self, tree: &Tree) -> f64 {
        let subtrees = Subtrees::new(&tree.nodes, &tree.refs, self.mesh.triangles.len());
        let overlap = epo::sampled(&subtrees, |t| self.mesh.corners(t), POINTS, epo::MOST_VISITS, self.exec).epo();
        let sah = f64::from(sah(&tree.nodes));
        if sah > 0.0 { overlap / sah } else { 0.0 }
    }
}
