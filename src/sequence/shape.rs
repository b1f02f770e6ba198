use super::policy::RefitPolicy;
use super::weld::Weld;
use crate::cache::{CacheError, Image, IndexedTriangleRecord, Parts, PoseRecord, SequenceWriter, TriangleRecord};
use crate::exec::Executor;
use crate::geom::Point;
use crate::scene::Mesh;
use crate::tree::{Node, Tree, quality, refit};

/// Most trees of one mesh that are tried for a pose before another one is built.
const TRIED: usize = 4;

/// The trees that meshes of the same triangles have had so far.
#[derive(Debug, Default)]
pub struct Shape {
    trees: Vec<Keyed>,
    /// The one that the last pose was fitted by.
    current: usize,
}

/// A tree with the pose that it was built over.
#[derive(Debug)]
struct Keyed {
    /// Its boxes are those of the pose that it was built over.
    tree: Tree,
    weld: Weld,
    /// Its row in the file.
    topology: u32,
    /// The SAH cost that it was built with.
    sah: f32,
    /// The largest cost, relative to that, at which building anew was not worth it.
    borne: f32,
}

/// A tree refitted to a pose.
#[derive(Debug)]
pub struct Fitted {
    keyed: usize,
    nodes: Vec<Node>,
    sah: f32,
    /// Its SAH cost relative to that with which it was built.
    pub ratio: f32,
    /// The policy asks for another tree.
    pub is_dear: bool,
}

impl Shape {
    /// The tree that serves a pose best, refitted; `None` where there is none yet.
    pub fn refit(&self, mesh: &Mesh, policy: &RefitPolicy, exec: &Executor) -> Option<Fitted> {
        let current = self.fit(self.current, mesh, policy, exec)?;
        if !current.is_dear {
            return Some(current);
        }
        // A walk comes back to where it was: the trees of then may serve again.
        let others = (0..self.trees.len()).rev().filter(|i| *i != self.current).take(TRIED - 1);
        let fitted = others.filter_map(|i| self.fit(i, mesh, policy, exec));
        Some(fitted.fold(current, |best, one| if one.sah < best.sah { one } else { best }))
    }

    fn fit(&self, number: usize, mesh: &Mesh, policy: &RefitPolicy, _exec: &Executor) -> Option<Fitted> {
        let keyed = self.trees.get(number)?;
        let mut nodes = keyed.tree.nodes.clone();
        let corners = |slot: usize| mesh.corners(keyed.tree.refs[slot] as usize).map(super::weld::clean);
        refit(&mut nodes, corners);
        let sah = quality::sah(&nodes);
        let ratio = if keyed.sah > 0.0 { sah / keyed.sah } else { 1.0 };
        Some(Fitted { keyed: number, nodes, sah, ratio, is_dear: policy.is_dear(ratio, keyed.borne) })
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
    pub fn write_refit(&mut self, mesh: &Mesh, fitted: Fitted, writer: &mut SequenceWriter) -> u32 {
        self.current = fitted.keyed;
        let keyed = &mut self.trees[fitted.keyed];
        let positions = keyed.weld.positions(mesh).unwrap_or_else(|| {
            // What was one vertex is two from here on: the same tree with other corners.
            keyed.weld = keyed.weld.split(mesh, &keyed.tree.refs);
            keyed.topology = Shape::write_topology(mesh, &keyed.tree, &keyed.weld, writer, &Executor::current());
            keyed.weld.positions(mesh).unwrap_or_default()
        });
        writer.pose(keyed.topology, &fitted.nodes, &positions, 0)
    }

    /// Store a tree that was built for a pose, and the pose. The pose's number.
    pub fn write_built(
        &mut self,
        mesh: &Mesh,
        tree: Tree,
        writer: &mut SequenceWriter,
        exec: &Executor,
    ) -> Result<u32, CacheError> {
        let weld = Weld::new(mesh, &tree.refs);
        let topology = Shape::write_topology(mesh, &tree, &weld, writer, exec);
        let positions: Vec<Point> = weld.positions(mesh).unwrap_or_default();
        let pose = writer.pose(topology, &tree.nodes, &positions, PoseRecord::KEY);
        let sah = quality::sah(&tree.nodes);
        self.current = self.trees.len();
        self.trees.push(Keyed { tree, weld, topology, sah, borne: 0.0 });
        Ok(pose)
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

/// What two meshes have in common if one tree can serve both: their triangles, with all that is told of them, but not where they stand.
pub fn topology_hash(mesh: &Mesh) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    let mut words = |some: &[u32]| {
        hasher.update(&(some.len() as u64).to_le_bytes());
        some.iter().for_each(|word| {
            hasher.update(&word.to_le_bytes());
        });
    };
    words(mesh.triangles.as_flattened());
    words(&mesh.source_prims);
    words(mesh.vertices.as_flattened());
    for part in &mesh.parts {
        let node = part.baked_node.unwrap_or(u32::MAX);
        words(&[part.source_mesh, part.source_part, node, part.mirrored.into(), part.first_prim, part.prim_count]);
        words(&[part.first_triangle, part.triangle_count]);
        for name in [&part.name, &part.material] {
            words(&[name.len() as u32]);
            words(&name.bytes().map(u32::from).collect::<Vec<_>>());
        }
    }
    *hasher.finalize().as_bytes()
}

/// Where the vertices of a mesh stand.
pub fn geometry_hash(mesh: &Mesh) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytemuck::cast_slice(&mesh.positions));
    *hasher.finalize().as_bytes()
}
