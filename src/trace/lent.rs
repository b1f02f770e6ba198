//! A tree in memory as traversal reads it, without what only a file needs.

use crate::cache::{BlasRecord, TriangleRecord, View, triangle_record};
use crate::exec::Executor;
use crate::scene::Mesh;
use crate::tree::{Node, Tree};
use bytemuck::Zeroable;

/// One tree over a mesh in world space: its own nodes, and copies of the triangles in their order. What [`Image::of_tree`](crate::cache::Image::of_tree) is for a file,
/// at the cost of the triangles alone: it knows no names, depth, SAH or flags.
#[derive(Debug)]
pub struct Lent<'a> {
    nodes: &'a [Node],
    triangles: Vec<TriangleRecord>,
    blases: [BlasRecord; 1],
}

impl<'a> Lent<'a> {
    /// Copies the triangles that the tree refers to. The tree must be one over this mesh.
    pub fn new(mesh: &Mesh, tree: &'a Tree, exec: &Executor) -> Lent<'a> {
        let record = |i: usize| triangle_record(mesh, tree.refs[i] as usize, 0, 0);
        let triangles = exec.generate(tree.refs.len(), record);
        let blas = BlasRecord {
            node_count: tree.nodes.len() as u32,
            ref_count: tree.refs.len() as u32,
            prim_count: mesh.triangles.len() as u32,
            ..BlasRecord::zeroed()
        };
        Lent { nodes: &tree.nodes, triangles, blases: [blas] }
    }

    /// What traversal reads: one BLAS, no TLAS, no parts.
    pub fn view(&self) -> View<'_> {
        View {
            nodes: self.nodes,
            triangles: &self.triangles,
            geoms: &[],
            blases: &self.blases,
            tlas_nodes: &[],
            instances: &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, NoProgress, Preset, initial_tree};
    use crate::cache::Image;
    use crate::geom::Ray;
    use crate::scene::Part;
    use crate::trace::closest_hit;

    #[test]
    fn rays_get_the_same_answers_as_from_an_image() {
        let positions = (0..600u32).map(|i| [i % 7, i % 11, i % 13].map(|c| c as f32 - 4.0)).collect();
        let triangles = (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let part = |first| Part {
            first_triangle: first,
            triangle_count: 100,
            first_prim: first,
            prim_count: 100,
            ..Part::default()
        };
        let mesh = Mesh { positions, triangles, parts: vec![part(0), part(100)], ..Mesh::default() };
        let options = BuildOptions::preset(Preset::Balanced);
        let tree = initial_tree(&mesh, &options, &Executor::sequential(), &NoProgress).unwrap();
        let (lent, image) = (
            Lent::new(&mesh, &tree, &Executor::sequential()),
            Image::of_tree(&mesh, &tree, &Executor::sequential()).unwrap(),
        );
        let mut hits = 0;
        for i in 0..500u32 {
            let ray = Ray::new([i % 5, i % 3, i % 17].map(|c| c as f32 * 0.37), [1.0, (i % 9) as f32 - 4.0, 0.3]);
            let [a, b] = [lent.view(), image.view()].map(|view| closest_hit(&view, &ray).unwrap());
            assert_eq!(a, b);
            hits += usize::from(a.is_some());
        }
        assert!(hits > 100, "{hits}");
    }
}
