//! [`FileReport`]: the trees of one file, folded.

use super::effort::BuildEffort;
use super::families::FamilyReport;
use super::overlap::EpoReport;
use super::rays::RayReport;
use super::stats::{TopReport, TreeReport, TreeStats};
use crate::cache::{CompactNode, View};
use crate::trace::TurnedView;
use crate::trace::wide::WideView;
use serde::Serialize;

/// The figures of a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileReport {
    pub path: String,
    pub file_len: u64,
    /// Bytes of the file per distinct triangle; 0 without triangles.
    pub bytes_per_triangle: f64,
    /// Bytes of the BLASes' nodes per distinct triangle.
    pub node_bytes_per_triangle: f64,
    /// The same of compact trees, their rows and their order of references included; `None` in a file without them.
    pub compact8_bytes_per_triangle: Option<f64>,
    /// Turned subtrees; `None` in a file without them. All other figures but the next are those of the tree along the axes of the scene.
    pub turned_subtrees: Option<u64>,
    /// Bytes of turned subtrees, nodes and rows, per distinct triangle.
    pub turned_bytes_per_triangle: Option<f64>,
    /// 1, or 2 with a tree over instances.
    pub levels: u32,
    pub instances: u64,
    /// Triangles that a ray can hit: each mesh counted as often as it stands in the scene.
    pub instanced_triangles: u64,
    /// All BLASes together. The SAH is the mean over trees weighted by the areas of their roots.
    pub blas: TreeReport,
    /// End-point overlap of the BLASes; `None` where it was not asked for.
    pub epo: Option<EpoReport>,
    /// What probe rays do in the trees; `None` where none were traced.
    pub rays: Option<RayReport>,
    /// What each family of rays pays; empty where none were traced.
    pub families: Vec<FamilyReport>,
    /// How the BLASes differ; `None` for a file with a single one.
    pub blas_spread: Option<BlasSpread>,
    pub tlas: Option<TopReport>,
    /// What the build took; `None` where META does not say, which it does only where that was asked for.
    pub effort: Option<BuildEffort>,
    /// What META says about why the trees are as they are; empty where it was not asked.
    pub notes: Vec<String>,
}

/// The extremes among several BLASes, with their numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BlasSpread {
    pub count: u64,
    /// Trees without triangles.
    pub empty: u64,
    pub largest: Extreme,
    pub deepest: Extreme,
    pub highest_sah: Extreme,
    /// Over the trees that are not empty, each counted alike.
    pub mean_sah: f64,
}

/// The BLAS in which a value is greatest; the first of equals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Extreme {
    pub blas: u64,
    pub value: f64,
}

impl FileReport {
    /// Walk every tree of a file once, all but for [`FileReport::epo`] and [`FileReport::rays`], which have their own price.
    pub fn of_view(path: String, file_len: u64, view: &View) -> FileReport {
        let each: Vec<TreeStats> = (0..view.blases.len())
            .filter_map(|i| Some(TreeStats::of_tree(view.blas(i)?.nodes, u64::from(view.blases[i].prim_count))))
            .collect();
        let spread = (each.len() > 1).then(|| BlasSpread::of_trees(&each));
        let blas = each.into_iter().fold(TreeStats::default(), |all, one| all + one);

        // A one-level file is its own only instance.
        let two_levels = !view.tlas_nodes.is_empty() || !view.instances.is_empty();
        let hit_by = |blas: u32| view.blases.get(blas as usize).map_or(0, |b| u64::from(b.prim_count));
        let instanced: u64 = view.instances.iter().map(|i| hit_by(i.blas)).fold(0, u64::saturating_add);
        let tlas = two_levels.then(|| TreeStats::of_tree(view.tlas_nodes, view.instances.len() as u64));
        FileReport {
            path,
            file_len,
            bytes_per_triangle: per_triangle(file_len, blas.prims),
            node_bytes_per_triangle: per_triangle(size_of_val(view.nodes) as u64, blas.prims),
            compact8_bytes_per_triangle: None,
            turned_subtrees: None,
            turned_bytes_per_triangle: None,
            levels: if two_levels { 2 } else { 1 },
            instances: view.instances.len() as u64,
            instanced_triangles: if two_levels { instanced } else { blas.prims },
            blas: TreeReport::from(&blas),
            epo: None,
            rays: None,
            families: Vec::new(),
            blas_spread: spread,
            tlas: tlas.as_ref().map(TopReport::from),
            effort: None,
            notes: Vec::new(),
        }
    }

    /// The notes of META: what the build took, and the others.
    pub fn with_notes(self, notes: &[String]) -> FileReport {
        let effort = notes.iter().find_map(|note| BuildEffort::of_note(note));
        let notes = notes.iter().filter(|note| BuildEffort::of_note(note).is_none()).cloned().collect();
        FileReport { effort, notes, ..self }
    }
}

impl FileReport {
    /// The figures of a file's compact trees besides.
    pub fn with_compact(self, trees: &WideView<'_, 8, CompactNode>) -> FileReport {
        let bytes = size_of_val(trees.rows) + size_of_val(trees.nodes) + size_of_val(trees.order);
        FileReport { compact8_bytes_per_triangle: Some(per_triangle(bytes as u64, self.blas.triangles)), ..self }
    }

    /// The figures of a file's turned subtrees besides.
    pub fn with_turned(self, turned: &TurnedView<'_>) -> FileReport {
        let bytes = size_of_val(turned.rows) + size_of_val(turned.nodes);
        FileReport {
            turned_subtrees: Some(turned.rows.len() as u64),
            turned_bytes_per_triangle: Some(per_triangle(bytes as u64, self.blas.triangles)),
            ..self
        }
    }
}

fn per_triangle(bytes: u64, triangles: u64) -> f64 {
    if triangles == 0 { 0.0 } else { bytes as f64 / triangles as f64 }
}

impl BlasSpread {
    fn of_trees(trees: &[TreeStats]) -> BlasSpread {
        let greatest = |value: &dyn Fn(&TreeStats) -> f64| {
            trees.iter().enumerate().fold(Extreme::default(), |best, (i, tree)| {
                if value(tree) > best.value { Extreme { blas: i as u64, value: value(tree) } } else { best }
            })
        };
        let empty = trees.iter().filter(|t| t.nodes == 0).count();
        let sah_sum: f64 = trees.iter().map(TreeStats::sah).sum();
        BlasSpread {
            count: trees.len() as u64,
            empty: empty as u64,
            largest: greatest(&|t| t.prims as f64),
            deepest: greatest(&|t| f64::from(t.max_depth)),
            highest_sah: greatest(&TreeStats::sah),
            mean_sah: if trees.len() == empty { 0.0 } else { sah_sum / (trees.len() - empty) as f64 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::Image;
    use crate::exec::Executor;
    use crate::geom::Affine;
    use crate::scene::{Instance, Mesh};
    use crate::tree::{Accel, Node, Tree};

    fn one_triangle() -> (Mesh, Tree) {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new("", positions, vec![[0, 1, 2]]).unwrap();
        let leaf = Node::leaf(mesh.triangle_box(0), 0, 1);
        (mesh, Tree { nodes: vec![leaf, bytemuck::Zeroable::zeroed()], refs: vec![0] })
    }

    #[test]
    fn one_level_and_two_levels() {
        let (mesh, tree) = one_triangle();
        let flat = Accel { meshes: vec![mesh.clone()], blases: vec![tree.clone()], tlas: None, ..Accel::default() };
        let r = FileReport::of_view("flat".into(), 960, &Image::new(&flat, &Executor::sequential()).unwrap().view());
        assert_eq!((r.levels, r.instanced_triangles, r.bytes_per_triangle), (1, 1, 960.0));
        assert_eq!((r.node_bytes_per_triangle, r.compact8_bytes_per_triangle), (64.0, None));
        assert!(r.blas_spread.is_none() && r.tlas.is_none());

        let place = |mesh| Instance { mesh, transform: Affine::IDENTITY, node: 0, name: String::new() };
        let top = Tree { nodes: vec![Node { count: 3, ..tree.nodes[0] }, tree.nodes[1]], refs: vec![0, 1, 2] };
        let two = Accel {
            meshes: vec![mesh.clone(), mesh],
            blases: vec![tree.clone(), tree],
            tlas: Some(top),
            instances: vec![place(0), place(1), place(1)],
            ..Accel::default()
        };
        let r = FileReport::of_view("two".into(), 960, &Image::new(&two, &Executor::sequential()).unwrap().view());
        assert_eq!((r.levels, r.instances, r.instanced_triangles, r.blas.trees), (2, 3, 3, 2));
        assert_eq!(r.tlas.unwrap().instances, 3);
        assert_eq!(r.blas_spread.unwrap().largest, Extreme { blas: 0, value: 1.0 });
    }
}
