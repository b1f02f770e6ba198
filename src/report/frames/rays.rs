//! What rays cost in a frame, in the trees that a file has and in trees that are built for the frame anew.

use crate::build::{BuildError, BuildOptions, Progress};
use crate::cache::{BlasRecord, BlasView, Frame, Image, TriangleRecord, View};
use crate::compile;
use crate::exec::Executor;
use crate::scene::{Mesh, Part};
use crate::trace::probe::{Camera, ProbeRays};
use crate::tree::Node;
use std::collections::BTreeMap;

/// What rays cost in a frame: 1.2 for each inner node and 1 for each triangle, a mean over three sets of rays: from four cameras around the frame, one diffuse
/// bounce, and ambient occlusion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameRays {
    /// In the trees of the file.
    pub stored: f64,
    /// The same rays in trees that were built for the frame.
    pub fresh: Option<f64>,
}

/// How the frames of a sequence are asked, one after another.
pub struct Gauge<'a> {
    /// Rays in each set.
    pub rays: usize,
    /// How trees are built for a frame, if they are.
    pub fresh: Option<BuildOptions>,
    pub exec: &'a Executor,
    pub progress: &'a dyn Progress,
    /// Trees that were built for the frame before, by pose: what stands still is built once.
    built: BTreeMap<u32, Built>,
}

impl<'a> Gauge<'a> {
    pub fn new(rays: usize, fresh: Option<BuildOptions>, exec: &'a Executor, progress: &'a dyn Progress) -> Gauge<'a> {
        Gauge { rays, fresh, exec, progress, built: BTreeMap::new() }
    }

    /// What rays cost in the next frame; nothing where nothing is seen.
    ///
    /// # Errors
    /// Where its trees cannot be built anew.
    pub fn ask(&mut self, frame: &Frame<'_>) -> Result<FrameRays, BuildError> {
        let view = frame.view();
        let rays = ProbeRays::around(&view, &Camera::around(&view), self.rays);
        let stored = rays.cost(&view, self.exec).mean();
        let Some(options) = &self.fresh else { return Ok(FrameRays { stored, fresh: None }) };
        let mut built = BTreeMap::new();
        for (number, pose) in frame.poses().iter().enumerate() {
            let known = self.built.remove(pose);
            let tree = match (known, view.blas(number)) {
                (Some(tree), _) => tree,
                (None, Some(blas)) => Built::of(&blas, options, self.exec, self.progress)?,
                (None, None) => Built::default(),
            };
            built.insert(*pose, tree);
        }
        self.built = built;
        let fresh = rays.cost(&Anew::new(&view, frame.poses(), &self.built).view(&view), self.exec).mean();
        Ok(FrameRays { stored, fresh: Some(fresh) })
    }
}

/// One tree that was built for a pose.
#[derive(Default)]
struct Built {
    nodes: Vec<Node>,
    triangles: Vec<TriangleRecord>,
}

impl Built {
    /// Over the triangles of another one.
    fn of(
        blas: &BlasView<'_>,
        options: &BuildOptions,
        exec: &Executor,
        progress: &dyn Progress,
    ) -> Result<Built, BuildError> {
        // In the order of the source, each once, as the builder of the file had them.
        let mut source: Vec<TriangleRecord> = blas.triangles.to_vec();
        source.sort_unstable_by_key(|t| (t.geom, t.prim));
        source.dedup_by_key(|t| (t.geom, t.prim));
        let count = source.len() as u32;
        let mesh = Mesh {
            positions: source.iter().flat_map(TriangleRecord::corners).collect(),
            triangles: (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
            parts: vec![Part { triangle_count: count, prim_count: count, ..Part::default() }],
            ..Mesh::default()
        };
        let (tree, _) = compile::decide_tree(&mesh, options, exec, progress)?;
        let image = Image::of_mesh(&mesh, &tree, exec);
        let slot = |(r, made): (&u32, &TriangleRecord)| TriangleRecord { flags: made.flags, ..source[*r as usize] };
        let triangles = tree.refs.iter().zip(&image.triangles).map(slot).collect();
        Ok(Built { nodes: tree.nodes, triangles })
    }
}

/// A frame with other trees. They fill the same boxes as those before, so the top level stays.
struct Anew {
    nodes: Vec<Node>,
    triangles: Vec<TriangleRecord>,
    blases: Vec<BlasRecord>,
}

impl Anew {
    fn new(view: &View<'_>, poses: &[u32], built: &BTreeMap<u32, Built>) -> Anew {
        let mut anew = Anew { nodes: Vec::new(), triangles: Vec::new(), blases: Vec::new() };
        for (before, tree) in view.blases.iter().zip(poses.iter().filter_map(|pose| built.get(pose))) {
            anew.blases.push(BlasRecord {
                node_offset: anew.nodes.len() as u64,
                node_count: tree.nodes.len() as u32,
                ref_offset: anew.triangles.len() as u64,
                ref_count: tree.triangles.len() as u32,
                ..*before
            });
            anew.nodes.extend_from_slice(&tree.nodes);
            anew.triangles.extend_from_slice(&tree.triangles);
        }
        anew
    }

    fn view<'v>(&'v self, before: &View<'v>) -> View<'v> {
        View { nodes: &self.nodes, triangles: &self.triangles, blases: &self.blases, ..*before }
    }
}
