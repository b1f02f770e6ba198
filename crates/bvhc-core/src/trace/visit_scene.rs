//! A walk over all of a file: the nodes over the instances, each instance, and the nodes of its tree.

use super::hit::Malformed;
use super::visit::{Step, Visit, walk};
use crate::layout::{InstanceRecord, Node, View};

/// Where a walk over a scene is.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum SceneVisit<'a> {
    /// At a node of the tree over the instances. Its box is in world space.
    Top {
        /// Number of the node's record in `TNOD`.
        index: usize,
        /// The record.
        node: &'a Node,
        /// The root has depth 0.
        depth: u32,
        /// The instances of a leaf, which the walk comes to next; empty for an inner node.
        instances: &'a [InstanceRecord],
    },
    /// At an instance of a leaf, before its tree.
    Instance {
        /// Number of its record in `INST`; what hits name is its `id`.
        record: usize,
        /// The record, with the maps from its tree's space to the world and back.
        instance: &'a InstanceRecord,
    },
    /// At a node of a tree over triangles.
    Tree {
        /// The instance that shows the tree: the node's box and its triangles are in the tree's space. `None` in a file of one level, where
        /// that is the world.
        instance: Option<&'a InstanceRecord>,
        /// The node.
        at: Visit<'a>,
    },
}

impl<'a> View<'a> {
    /// Walk the whole scene, whether it has one level or two. `see` decides at each place how the walk goes on: past a node of either level
    /// with what is below it, past an instance with its tree, or nowhere. Returns whether `see` stopped the walk.
    ///
    /// In a file of two levels the order is that of a walk by [`BlasView::visit`](crate::layout::BlasView::visit) over the instances' tree, and
    /// behind each of its leaves come the leaf's instances, each with a walk over its tree. A file of one level has [`SceneVisit::Tree`] alone. A
    /// tree that stands in many places is walked in each of them.
    ///
    /// ```
    /// use bvhc_core::geom::{Aabb, Affine};
    /// use bvhc_core::layout::View;
    /// use bvhc_core::trace::{Malformed, SceneVisit, Step};
    ///
    /// /// How many triangles lie in leaves that a box in world space meets.
    /// fn near(view: &View<'_>, query: &Aabb) -> Result<usize, Malformed> {
    ///     let (mut to_world, mut count) = (Affine::IDENTITY, 0);
    ///     view.visit(|place| {
    ///         let met = match place {
    ///             SceneVisit::Top { node, .. } => node.bounds().overlaps(query),
    ///             SceneVisit::Instance { instance, .. } => {
    ///                 to_world = Affine::from_f32(&instance.object_to_world);
    ///                 true
    ///             }
    ///             SceneVisit::Tree { at, .. } => {
    ///                 let met = to_world.transform_box(&at.node.bounds()).overlaps(query);
    ///                 count += if met { at.triangles.len() } else { 0 };
    ///                 met
    ///             }
    ///             _ => true,
    ///         };
    ///         if met { Step::Descend } else { Step::Skip }
    ///     })?;
    ///     Ok(count)
    /// }
    /// ```
    ///
    /// # Errors
    /// As for rays ([`closest_hit`](super::closest_hit)): where the walk comes upon records that are no tree. It ends on every input, and its
    /// memory is constant.
    pub fn visit(&self, mut see: impl FnMut(SceneVisit<'a>) -> Step) -> Result<bool, Malformed> {
        if self.tlas_nodes.is_empty() {
            if self.blases.is_empty() {
                return Ok(false);
            }
            let tree = self.blas(0).ok_or(Malformed::BlasOutOfRange { instance: 0, blas: 0 })?;
            return tree.visit(|at| see(SceneVisit::Tree { instance: None, at }));
        }
        walk(self.tlas_nodes, self.instances, |index, node, depth, instances| {
            let step = see(SceneVisit::Top { index, node, depth, instances });
            if step != Step::Descend {
                return Ok(step);
            }
            for (i, instance) in instances.iter().enumerate() {
                let record = node.first as usize + i;
                let stopped = match see(SceneVisit::Instance { record, instance }) {
                    Step::Skip => false,
                    Step::Stop => true,
                    Step::Descend => {
                        let blas = instance.blas;
                        let tree = self.blas(blas as usize);
                        let tree = tree.ok_or(Malformed::BlasOutOfRange { instance: record, blas })?;
                        tree.visit(|at| see(SceneVisit::Tree { instance: Some(instance), at }))?
                    }
                };
                if stopped {
                    return Ok(Step::Stop);
                }
            }
            Ok(Step::Descend)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{BlasRecord, TriangleRecord};
    use bytemuck::Zeroable;

    /// Two trees, of one leaf and of two, under a tree of two leaves: instance 0 shows tree 1, instances 1 and 2 tree 0.
    struct Scene {
        nodes: [Node; 6],
        triangles: [TriangleRecord; 3],
        blases: [BlasRecord; 2],
        tlas_nodes: [Node; 4],
        instances: [InstanceRecord; 3],
    }

    impl Scene {
        fn new() -> Scene {
            let node = |first, count| Node { min: [0.0; 3], first, max: [1.0; 3], count };
            let unused = Node::zeroed();
            let tree = |node_offset, node_count, ref_offset, ref_count| BlasRecord {
                node_offset,
                node_count,
                ref_offset,
                ref_count,
                ..BlasRecord::zeroed()
            };
            let shows = |blas, id| InstanceRecord { blas, id, ..InstanceRecord::zeroed() };
            Scene {
                nodes: [node(0, 1), unused, node(2, 0), unused, node(0, 1), node(1, 1)],
                triangles: [TriangleRecord::zeroed(); 3],
                blases: [tree(0, 2, 0, 1), tree(2, 4, 1, 2)],
                tlas_nodes: [node(2, 0), unused, node(0, 1), node(1, 2)],
                instances: [shows(1, 7), shows(0, 8), shows(0, 9)],
            }
        }

        fn view(&self) -> View<'_> {
            let Scene { nodes, triangles, blases, tlas_nodes, instances } = self;
            View { nodes, triangles, geoms: &[], blases, tlas_nodes, instances }
        }
    }

    /// A word for each place.
    fn word(place: SceneVisit<'_>) -> String {
        match place {
            SceneVisit::Top { index, depth, instances, .. } => {
                format!("top {index} at {depth} over {}", instances.len())
            }
            SceneVisit::Instance { record, instance } => format!("instance {record} is {}", instance.id),
            SceneVisit::Tree { instance, at } => {
                let of = instance.map_or("world".to_owned(), |i| i.id.to_string());
                format!("{of}: {} with {}", at.index, at.triangles.len())
            }
        }
    }

    fn walked(view: &View<'_>, decide: impl Fn(&str) -> Step) -> (Result<bool, Malformed>, Vec<String>) {
        let mut seen = Vec::new();
        let result = view.visit(|place| {
            seen.push(word(place));
            decide(seen.last().unwrap())
        });
        (result, seen)
    }

    #[test]
    fn a_walk_of_two_levels_comes_to_every_place_in_order() {
        let scene = Scene::new();
        let (result, seen) = walked(&scene.view(), |_| Step::Descend);
        let all = [
            "top 0 at 0 over 0",
            "top 2 at 1 over 1",
            "instance 0 is 7",
            "7: 0 with 0",
            "7: 2 with 1",
            "7: 3 with 1",
            "top 3 at 1 over 2",
            "instance 1 is 8",
            "8: 0 with 1",
            "instance 2 is 9",
            "9: 0 with 1",
        ];
        assert_eq!(result, Ok(false));
        assert_eq!(seen, all);

        // Whatever is skipped hides what is below it and nothing else.
        let without = |skipped: &str, hidden: usize| {
            let (result, seen) = walked(&scene.view(), |place| match place == skipped {
                true => Step::Skip,
                false => Step::Descend,
            });
            let at = all.iter().position(|place| *place == skipped).unwrap();
            assert_eq!(result, Ok(false));
            assert_eq!(seen, [&all[..=at], &all[at + 1 + hidden..]].concat(), "{skipped}");
        };
        [(0, 10), (1, 4), (2, 3), (3, 2), (4, 0), (6, 4), (7, 1)].iter().for_each(|&(i, n)| without(all[i], n));
        for (i, last) in all.iter().enumerate() {
            let (result, seen) = walked(&scene.view(), |place| if place == *last { Step::Stop } else { Step::Descend });
            assert_eq!((result, seen.len()), (Ok(true), i + 1), "{last}");
        }
    }

    #[test]
    fn a_file_of_one_level_has_one_tree_in_the_world() {
        let scene = Scene::new();
        let view = View { tlas_nodes: &[], instances: &[], ..scene.view() };
        assert_eq!(walked(&view, |_| Step::Descend), (Ok(false), vec!["world: 0 with 1".to_owned()]));
        let empty = View { blases: &[], ..view };
        assert_eq!(walked(&empty, |_| Step::Descend), (Ok(false), vec![]));
    }

    #[test]
    fn records_that_are_no_tree_end_in_an_error() {
        let broken = |change: &dyn Fn(&mut Scene)| {
            let mut scene = Scene::new();
            change(&mut scene);
            walked(&scene.view(), |_| Step::Descend).0.unwrap_err()
        };
        assert_eq!(broken(&|s| s.instances[1].blas = 2), Malformed::BlasOutOfRange { instance: 1, blas: 2 });
        assert_eq!(broken(&|s| s.blases[0].ref_offset = 9), Malformed::BlasOutOfRange { instance: 1, blas: 0 });
        assert_eq!(broken(&|s| s.tlas_nodes[0].first = 3), Malformed::ChildOutOfRange { first: 3, nodes: 4 });
        assert_eq!(broken(&|s| s.tlas_nodes[3].count = 3), Malformed::LeafOutOfRange { first: 1, count: 3, refs: 3 });
        assert_eq!(broken(&|s| s.nodes[2].first = 3), Malformed::ChildOutOfRange { first: 3, nodes: 4 });
        assert_eq!(broken(&|s| s.tlas_nodes[2].count = 3), Malformed::NotATree { nodes: 4 });
        let none = Scene { blases: [BlasRecord { node_offset: 9, ..Scene::new().blases[0] }; 2], ..Scene::new() };
        let view = View { tlas_nodes: &[], instances: &[], ..none.view() };
        assert_eq!(walked(&view, |_| Step::Descend).0, Err(Malformed::BlasOutOfRange { instance: 0, blas: 0 }));
    }
}
