use super::shape::{Shape, cost_of, geometry_hash, topology_hash, unit};
use super::weld::bits;
use crate::build::motion::{Cost, Motion, RefitPolicy, Trees, keyed};
use crate::build::{BuildError, BuildOptions, Progress};
use crate::exec::Executor;
use crate::geom::Point;
use crate::scene::Mesh;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// How the meshes of an animation stand in some of its frames.
#[derive(Default)]
pub struct Survey {
    /// By what the poses share.
    meshes: BTreeMap<[u8; 32], Poses>,
}

#[derive(Default)]
struct Poses {
    triangles: Vec<[u32; 3]>,
    positions: Vec<Vec<Point>>,
    seen: BTreeSet<[u8; 32]>,
}

impl Survey {
    /// Take the meshes of a frame.
    pub fn add(&mut self, meshes: Vec<Mesh>) {
        for mesh in meshes {
            let poses = self.meshes.entry(topology_hash(&mesh)).or_default();
            if poses.seen.insert(geometry_hash(&mesh)) {
                poses.triangles = mesh.triangles;
                poses.positions.push(mesh.positions);
            }
        }
    }

    /// Trees for those that stand in several ways, and how many each has.
    ///
    /// # Errors
    /// Where a tree would be too large, or `progress` cancels.
    pub fn shapes(
        self,
        trees: Trees,
        options: &BuildOptions,
        policy: RefitPolicy,
        exec: &Executor,
        progress: &dyn Progress,
    ) -> Result<Vec<([u8; 32], Shape, u64)>, BuildError> {
        let moving = self.meshes.into_iter().filter(|(_, poses)| poses.positions.len() > 1);
        let shape = |(topology, poses): ([u8; 32], Poses)| {
            let mut motion = Motion::new(&poses.triangles);
            // What cannot be indexed or is no number was refused when it was laid out.
            poses.positions.iter().for_each(|positions| _ = motion.push(positions));
            let keyed = keyed(&motion, trees, options, exec, progress)?;
            let mut least: Vec<Option<Cost>> = vec![None; keyed.trees.len()];
            for (frame, tree) in keyed.serves.iter().enumerate() {
                let mut nodes = keyed.trees[*tree].nodes.clone();
                let refs = &keyed.trees[*tree].refs;
                crate::tree::refit_built(&mut nodes, |slot| motion.corners(frame, refs[slot] as usize), exec);
                let cost = cost_of(&nodes, unit(&motion, frame));
                least[*tree] = Some(least[*tree].map_or(cost, |least| least.min(cost)));
            }
            let together = together(&poses.positions);
            let count = keyed.trees.len() as u64;
            let least = least.into_iter().map(Option::unwrap_or_default);
            Ok((topology, Shape::surveyed(policy, keyed.trees.into_iter().zip(least), together), count))
        };
        moving.map(shape).collect()
    }
}

/// For each vertex the first one that stands with it in every pose. On a grid many vertices meet in some pose and part again.
fn together(poses: &[Vec<Point>]) -> Vec<u32> {
    let count = poses.iter().map(Vec::len).min().unwrap_or(0);
    let mut first: Vec<u32> = vec![0; count];
    for pose in poses {
        // Only asked, never walked through: the order of a hash map decides nothing.
        let mut places: HashMap<(u32, [u32; 3]), u32> = HashMap::with_capacity(count);
        for (v, (first, position)) in first.iter_mut().zip(pose).enumerate() {
            *first = *places.entry((*first, bits(*position))).or_insert(v as u32);
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_together_that_never_part() {
        let (a, b) = ([1.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        let poses = [vec![a, b, a, a, [-0.0, 2.0, 0.0]], vec![b, a, b, a, a]];
        assert_eq!(together(&poses), [0, 1, 0, 3, 1]);
        assert_eq!(together(&poses[..1]), [0, 1, 0, 0, 1]);
        assert!(together(&[]).is_empty());
    }
}
