use super::policy::RefitPolicy;
use super::weld::Weld;
use crate::build::BuildOptions;
use crate::build::motion::{Motion, triangle_cost};
use crate::cache::{Image, IndexedTriangleRecord, Parts, PoseRecord, SequenceWriter, TriangleRecord};
use crate::exec::Executor;
use crate::geom::Point;
use crate::scene::Mesh;
use crate::tree::{Node, Tree, quality, refit};

/// Most trees of one mesh that are kept: each is tried for a pose before another one is built.
const KEPT: usize = 4;

/// The trees that meshes of the same triangles have had so far, or were given beforehand.
#[derive(Debug, Default)]
pub struct Shape {
    trees: Vec<Keyed>,
    /// The one that the last pose was fitted by.
    current: usize,
    /// The trees were made for the whole animation: each pose takes the best of them.
    is_surveyed: bool,
}

/// A tree that may serve other poses than the one that it was built over.
#[derive(Debug)]
struct Keyed {
    tree: Tree,
    /// Its vertices and its row in the file, once a pose needed them.
    stored: Option<(Weld, u32)>,
    /// What it costs in the pose that it was built over; of a tree for many poses the least in those.
    cost: Cost,
    /// The largest cost, relative to that, at which building anew was not worth it.
    borne: f32,
}

/// What a tree costs in a pose.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    /// The SAH, over the area of the root.
    pub sah: f32,
    /// The SAH over what the triangles alone cost.
    pub excess: f32,
}

impl Cost {
    /// Of a refitted tree; `unit` is what the triangles alone cost.
    pub fn of(nodes: &[Node], unit: f32) -> Cost {
        let sah = quality::sah(nodes);
        Cost { sah, excess: sah / unit }
    }

    /// The smaller of each.
    pub fn min(self, other: Cost) -> Cost {
        Cost { sah: self.sah.min(other.sah), excess: self.excess.min(other.excess) }
    }

    /// How many times another cost it is, by the measure that says more. The SAH alone takes a smaller root for a worse tree, and what is over the triangles'
    /// cost takes triangles that grew for a better one. What is suspected wrongly is built once and found futile.
    fn ratio(self, to: Cost) -> f32 {
        let ratio = |a: f32, b: f32| if b > 0.0 { a / b } else { 1.0 };
        ratio(self.sah, to.sah).max(ratio(self.excess, to.excess))
    }
}

/// A tree refitted to a pose.
#[derive(Debug)]
pub struct Fitted {
    keyed: usize,
    nodes: Vec<Node>,
    sah: f32,
    /// Its cost relative to that of the poses that it was made for.
    pub ratio: f32,
    /// The policy asks for another tree.
    pub is_dear: bool,
}

impl Shape {
    /// Trees for the whole animation, each with the least cost that it has in the poses that it was made for.
    pub fn surveyed(trees: impl IntoIterator<Item = (Tree, Cost)>) -> Shape {
        let keyed = |(tree, cost)| Keyed { tree, stored: None, cost, borne: 0.0 };
        Shape { trees: trees.into_iter().map(keyed).collect(), current: 0, is_surveyed: true }
    }

    /// The tree that serves a pose best, refitted; `None` where there is none yet.
    pub fn refit(&self, mesh: &Mesh, policy: &RefitPolicy) -> Option<Fitted> {
        let unit = unit_of(mesh);
        let current = self.fit(self.current, mesh, unit, policy)?;
        if !current.is_dear && !self.is_surveyed {
            return Some(current);
        }
        // A walk comes back to where it was: the trees of then may serve again.
        let others = (0..self.trees.len()).filter(|i| *i != self.current);
        let fitted = others.filter_map(|i| self.fit(i, mesh, unit, policy));
        Some(fitted.fold(current, |best, one| if one.sah < best.sah { one } else { best }))
    }

    fn fit(&self, number: usize, mesh: &Mesh, unit: f32, policy: &RefitPolicy) -> Option<Fitted> {
        let keyed = self.trees.get(number)?;
        let mut nodes = keyed.tree.nodes.clone();
        let corners = |slot: usize| mesh.corners(keyed.tree.refs[slot] as usize).map(super::weld::clean);
        refit(&mut nodes, corners);
        let cost = Cost::of(&nodes, unit);
        let ratio = cost.ratio(keyed.cost);
        Some(Fitted { keyed: number, nodes, sah: cost.sah, ratio, is_dear: policy.is_dear(ratio, keyed.borne) })
    }

    /// Whether a tree that was built for a pose is hardly better than a refitted one. Then that is remembered, so that the next poses do not try again.
    pub fn is_futile(&mut self, built: &Tree, fitted: &Fitted, policy: &RefitPolicy) -> bool {
        let futile =
            policy.refit == super::Refit::Auto && quality::sah(&built.nodes) >= fitted.sah * RefitPolicy::WORTHWHILE;
        if futile {
            self.trees[fitted.keyed].borne = fitted.ratio * RefitPolicy::PATIENCE;
        }
        futile
    }

    /// Store a pose whose tree was refitted. Its number.
    pub fn write_refit(&mut self, mesh: &Mesh, fitted: Fitted, writer: &mut SequenceWriter, exec: &Executor) -> u32 {
        self.current = fitted.keyed;
        let Keyed { tree, stored, .. } = &mut self.trees[fitted.keyed];
        // Vertices that were one and stand apart in this pose are two from here on: the same tree with other corners.
        let known = stored.as_ref().and_then(|(weld, topology)| Some((weld.positions(mesh)?, *topology)));
        let (positions, topology) = known.unwrap_or_else(|| {
            let weld = stored.as_ref().map_or_else(|| Weld::new(mesh, &tree.refs), |(w, _)| w.split(mesh, &tree.refs));
            let topology = Shape::write_topology(mesh, tree, &weld, writer, exec);
            let positions = weld.positions(mesh).unwrap_or_default();
            *stored = Some((weld, topology));
            (positions, topology)
        });
        writer.pose(topology, &fitted.nodes, &positions, 0)
    }

    /// Store a tree that was built for a pose, and the pose. The pose's number.
    pub fn write_built(&mut self, mesh: &Mesh, tree: Tree, writer: &mut SequenceWriter, exec: &Executor) -> u32 {
        let weld = Weld::new(mesh, &tree.refs);
        let topology = Shape::write_topology(mesh, &tree, &weld, writer, exec);
        let positions: Vec<Point> = weld.positions(mesh).unwrap_or_default();
        let pose = writer.pose(topology, &tree.nodes, &positions, PoseRecord::KEY);
        let cost = Cost::of(&tree.nodes, unit_of(mesh));
        if self.trees.len() == KEPT {
            // The oldest goes. However many are built, memory holds a few.
            self.trees.remove(0);
        }
        self.current = self.trees.len();
        self.trees.push(Keyed { tree, stored: Some((weld, topology)), cost, borne: 0.0 });
        pose
    }

    fn write_topology(mesh: &Mesh, tree: &Tree, weld: &Weld, writer: &mut SequenceWriter, exec: &Executor) -> u32 {
        let image = Image::of_mesh(mesh, tree, exec);
        let indexed = |(t, r): (&TriangleRecord, &u32)| IndexedTriangleRecord {
            corners: mesh.triangles[*r as usize].map(|v| weld.of[v as usize]),
            prim: t.prim,
            geom: t.geom,
            flags: t.flags,
        };
        let triangles = image.triangles.iter().zip(&tree.refs).map(indexed);
        let Image { geoms, names, materials, sides, vertices, .. } = &image;
        let parts = Parts { geoms, names, materials, sides, vertices };
        writer.topology(&tree.nodes, weld.sources.len() as u32, triangles, &parts)
    }
}

/// What the triangles of a mesh [cost alone](triangle_cost) as it stands, by which the costs of two poses can be compared. 1 where that is nothing.
fn unit_of(mesh: &Mesh) -> f32 {
    let mut motion = Motion::new(&mesh.triangles);
    match motion.push(&mesh.positions) {
        Ok(()) => unit(&motion, 0),
        Err(_) => 1.0,
    }
}

/// The same of one of several poses.
pub fn unit(motion: &Motion, pose: usize) -> f32 {
    match triangle_cost(motion, pose, &BuildOptions::default()) {
        cost if cost > 0.0 => cost as f32,
        _ => 1.0,
    }
}

/// What two meshes have in common if one tree can serve both: their triangles, with all that is told of them, but not where they stand.
pub fn topology_hash(mesh: &Mesh) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    words(&mut hasher, mesh.triangles.as_flattened());
    words(&mut hasher, &mesh.source_prims);
    words(&mut hasher, mesh.vertices.as_flattened());
    hasher.update(&parts_hash(mesh));
    *hasher.finalize().as_bytes()
}

/// The parts of a mesh.
pub fn parts_hash(mesh: &Mesh) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    for part in &mesh.parts {
        let node = part.baked_node.unwrap_or(u32::MAX);
        let source = [part.source_mesh, part.source_part, node, part.mirrored.into()];
        words(&mut hasher, &source);
        words(&mut hasher, &[part.first_prim, part.prim_count, part.first_triangle, part.triangle_count]);
        for name in [&part.name, &part.material] {
            hasher.update(&(name.len() as u64).to_le_bytes()).update(name.as_bytes());
        }
    }
    *hasher.finalize().as_bytes()
}

fn words(hasher: &mut blake3::Hasher, some: &[u32]) {
    hasher.update(&(some.len() as u64).to_le_bytes()).update(bytemuck::cast_slice(some));
}

/// Where the vertices of a mesh stand.
pub fn geometry_hash(mesh: &Mesh) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytemuck::cast_slice(&mesh.positions));
    *hasher.finalize().as_bytes()
}
