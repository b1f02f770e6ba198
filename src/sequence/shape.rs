use super::weld::{Weld, clean};
use crate::build::BuildOptions;
use crate::build::motion::{Cost, Motion, Rebuild, RefitPolicy, Step, Verdict, triangle_cost};
use crate::cache::{Image, IndexedTriangleRecord, Parts, PoseRecord, SequenceWriter, TriangleRecord};
use crate::exec::Executor;
use crate::geom::Point;
use crate::scene::Mesh;
use crate::tree::{Node, Tree, quality, refit_built};
use std::ops::Range;

/// The trees that meshes of the same triangles have had so far, or were given beforehand.
#[derive(Debug)]
pub struct Shape {
    /// As [`Rebuild`] counts them.
    trees: Vec<Keyed>,
    rule: Rebuild,
    /// For each vertex the first one that stands with it in every pose that was surveyed; empty where none was.
    together: Vec<u32>,
}

/// A tree that may serve other poses than the one that it was built over.
#[derive(Debug)]
struct Keyed {
    tree: Tree,
    /// Its vertices and its row in the file, once a pose needed them.
    stored: Option<(Weld, u32)>,
}

/// A tree refitted to a pose.
#[derive(Debug)]
pub struct Fitted {
    keyed: usize,
    nodes: Vec<Node>,
    /// Its cost relative to that of the poses that it was made for.
    pub ratio: f32,
}

/// A tree that was built for a pose and is worth being stored.
#[derive(Debug)]
pub struct Built {
    tree: Tree,
    /// The places of the trees that go for it.
    gone: Range<usize>,
}

impl Shape {
    /// Without a tree.
    pub fn new(policy: RefitPolicy) -> Shape {
        Shape::surveyed(policy, [], Vec::new())
    }

    /// Trees for the whole animation, each with the least cost that it has in the poses that it was made for; and for each vertex the first one that stands with
    /// it in all of these.
    pub fn surveyed(policy: RefitPolicy, trees: impl IntoIterator<Item = (Tree, Cost)>, together: Vec<u32>) -> Shape {
        let (trees, costs): (Vec<Keyed>, Vec<Cost>) =
            trees.into_iter().map(|(tree, cost)| (Keyed { tree, stored: None }, cost)).unzip();
        Shape { trees, rule: Rebuild::with(policy, costs), together }
    }

    /// The tree that serves a pose best, refitted; `None` where one is to be [built](Shape::judge).
    pub fn refit(&mut self, mesh: &Mesh, exec: &Executor) -> Option<Fitted> {
        let Shape { trees, rule, .. } = self;
        let unit = unit_of(mesh);
        // Two are held at most: the cheapest so far and the one that is asked.
        let mut cheapest: Option<(usize, f64, Vec<Node>)> = None;
        let step = rule.step(|place| {
            let nodes = fit(&trees[place].tree, mesh, exec);
            let cost = cost_of(&nodes, unit);
            if cheapest.as_ref().is_none_or(|(_, sah, _)| cost.sah < *sah) {
                cheapest = Some((place, cost.sah, nodes));
            }
            cost
        });
        let Step::Refit(keyed, ratio) = step else { return None };
        let known = cheapest.filter(|(place, ..)| *place == keyed).map(|(_, _, nodes)| nodes);
        let nodes = known.unwrap_or_else(|| fit(&trees[keyed].tree, mesh, exec));
        Some(Fitted { keyed, nodes, ratio: ratio as f32 })
    }

    /// How many times as much a pose costs as those that its tree was made for, if the tree that serves it best is that of a topology which was written, refitted to
    /// these very nodes. Otherwise nothing has happened.
    pub fn follow(&mut self, mesh: &Mesh, topology: u32, nodes: &[Node], exec: &Executor) -> Option<f32> {
        let before = self.rule.clone();
        let fitted = self.refit(mesh, exec).filter(|fitted| {
            let stored = &self.trees[fitted.keyed].stored;
            stored.as_ref().is_some_and(|(_, written)| *written == topology) && fitted.nodes == nodes
        });
        if fitted.is_none() {
            self.rule = before;
        }
        fitted.map(|fitted| fitted.ratio)
    }

    /// For each vertex of the mesh its vertex in a topology that was written, if poses are still written to it.
    pub fn vertices_of(&self, topology: u32) -> Option<&[u32]> {
        let mut stored = self.trees.iter().filter_map(|keyed| keyed.stored.as_ref());
        stored.find(|(_, written)| *written == topology).map(|(weld, _)| &weld.of[..])
    }

    /// A tree that was built for a pose; or, where it is hardly better than a refitted one, that.
    pub fn judge(&mut self, mesh: &Mesh, tree: Tree, exec: &Executor) -> Result<Fitted, Built> {
        match self.rule.built(cost_of(&tree.nodes, unit_of(mesh))) {
            Verdict::Kept(gone) => Err(Built { tree, gone: gone.map_or(0..0, |place| place..place + 1) }),
            Verdict::Key => Err(Built { tree, gone: 0..self.trees.len() }),
            Verdict::Futile(keyed, ratio) => {
                Ok(Fitted { keyed, nodes: fit(&self.trees[keyed].tree, mesh, exec), ratio: ratio as f32 })
            }
        }
    }

    /// Store a pose whose tree was refitted. Its number.
    pub fn write_refit(&mut self, mesh: &Mesh, fitted: Fitted, writer: &mut SequenceWriter, exec: &Executor) -> u32 {
        let Keyed { tree, stored } = &mut self.trees[fitted.keyed];
        // Vertices that were one and stand apart in this pose are two from here on: the same tree with other corners.
        let known = stored.as_ref().and_then(|(weld, topology)| Some((weld.positions(mesh)?, *topology)));
        let (positions, topology) = known.unwrap_or_else(|| {
            let weld =
                stored.as_ref().map_or_else(|| weld(mesh, tree, &self.together), |(w, _)| w.split(mesh, &tree.refs));
            let topology = Shape::write_topology(mesh, tree, &weld, writer, exec);
            let positions = weld.positions(mesh).unwrap_or_default();
            *stored = Some((weld, topology));
            (positions, topology)
        });
        writer.pose(topology, &fitted.nodes, &positions, 0)
    }

    /// Store a tree that was built for a pose, and the pose. The pose's number.
    pub fn write_built(&mut self, mesh: &Mesh, built: Built, writer: &mut SequenceWriter, exec: &Executor) -> u32 {
        let Built { tree, gone } = built;
        let weld = weld(mesh, &tree, &self.together);
        let topology = Shape::write_topology(mesh, &tree, &weld, writer, exec);
        let positions: Vec<Point> = weld.positions(mesh).unwrap_or_default();
        let pose = writer.pose(topology, &tree.nodes, &positions, PoseRecord::KEY);
        self.trees.drain(gone);
        self.trees.push(Keyed { tree, stored: Some((weld, topology)) });
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

/// The nodes of a tree, refitted to a mesh as it stands.
fn fit(tree: &Tree, mesh: &Mesh, exec: &Executor) -> Vec<Node> {
    let mut nodes = tree.nodes.clone();
    refit_built(&mut nodes, |slot| mesh.corners(tree.refs[slot] as usize).map(clean), exec);
    nodes
}

/// What a refitted tree costs where the triangles alone cost `unit`.
pub fn cost_of(nodes: &[Node], unit: f64) -> Cost {
    Cost::new(quality::sah(nodes).into(), unit)
}

/// The vertices of a tree over a mesh as it stands; apart stay those that are known to part.
fn weld(mesh: &Mesh, tree: &Tree, together: &[u32]) -> Weld {
    Weld::by(mesh, &tree.refs, |v| together.get(v as usize).copied().unwrap_or(0))
}

/// What the triangles of a mesh [cost alone](triangle_cost) as it stands, by which the costs of two poses can be compared.
fn unit_of(mesh: &Mesh) -> f64 {
    let mut motion = Motion::new(&mesh.triangles);
    motion.push(&mesh.positions).map_or(0.0, |()| unit(&motion, 0))
}

/// The same of one of several poses.
pub fn unit(motion: &Motion, pose: usize) -> f64 {
    triangle_cost(motion, pose, &BuildOptions::default())
}

/// What two meshes have in common if one tree can serve both: their triangles, with all that is told of them and the faces that they were cut from, but not where
/// they stand.
pub fn topology_hash(mesh: &Mesh) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    words(&mut hasher, mesh.triangles.as_flattened());
    words(&mut hasher, &mesh.source_prims);
    words(&mut hasher, mesh.vertices.as_flattened());
    hasher.update(&parts_hash(mesh));
    hasher.update(&mesh.faces.unwrap_or_default());
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

/// Where the triangles of a mesh stand.
pub fn geometry_hash(mesh: &Mesh) -> [u8; 32] {
    /// Triangles that are put together before they are hashed.
    const SOME: usize = 1 << 12;
    let mut hasher = blake3::Hasher::new();
    let mut corners: Vec<[Point; 3]> = Vec::with_capacity(SOME.min(mesh.triangles.len()));
    for some in mesh.triangles.chunks(SOME) {
        corners.clear();
        corners.extend(some.iter().map(|t| t.map(|v| clean(mesh.positions[v as usize]))));
        hasher.update(bytemuck::cast_slice(&corners));
    }
    *hasher.finalize().as_bytes()
}
