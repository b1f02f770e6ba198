//! Scenes that are more than triangles in one place.

use super::{hostile, scene_of};
use crate::geom::Affine;
use crate::scene::{Instance, Scene};

/// A cloud, and vertices far away that no triangle has.
pub fn strewn(count: usize) -> Scene {
    let mut scene = scene_of(&hostile::cloud(count));
    scene.meshes.iter_mut().for_each(|mesh| mesh.positions.extend([[1e9; 3], [-1e9; 3]]));
    scene
}

/// A cloud beside its mirror image and beside itself sheared.
pub fn mirrored(count: usize) -> Scene {
    let mut scene = scene_of(&hostile::cloud(count));
    let rows: [[[f64; 4]; 3]; 2] = [
        [[-1.0, 0.0, 0.0, 4.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        [[1.0, 0.5, 0.0, 8.0], [0.0, 1.0, 0.25, 0.0], [0.0, 0.0, 2.0, 0.0]],
    ];
    let of = |rows| Instance { mesh: 0, transform: Affine { rows }, node: 0, name: String::new() };
    scene.instances.extend(rows.map(of));
    scene
}
