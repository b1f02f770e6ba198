//! The scene that a file holds, taken from the file alone.

use crate::cache::{NO_NODE, Names, TriangleRecord, View};
use crate::geom::{Affine, Point};
use crate::scene::{Instance, Mesh, Part, Scene};

/// Why a file's records are no scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotAScene {
    /// A row of `BLAS` names records beyond those of the file.
    #[error("cannot take the scene from the file: the ranges of tree {tree} lie outside the file's sections")]
    TreeOutOfRange {
        /// The row.
        tree: usize,
    },
    /// A triangle names a part that is none of its tree.
    #[error(
        "cannot take the scene from the file: a triangle of tree {tree} names row {geom} of GEOM, which is not a row of that tree"
    )]
    GeomOutOfRange {
        /// Row of `BLAS`.
        tree: usize,
        /// Row of `GEOM` that the triangle names.
        geom: u32,
    },
    /// No scene has such a triangle.
    #[error("cannot take the scene from the file: triangle {prim} of tree {tree} has a corner that is not finite")]
    NotFinite {
        /// Row of `BLAS`.
        tree: usize,
        /// Number of the triangle in its source mesh.
        prim: u32,
    },
    /// An instance names a tree that is not there, or has a number that is too large or another's.
    #[error(
        "cannot take the scene from the file: instance record {record} places tree {blas} as number {id}, but there are {trees} trees and {instances} instances, each numbered once"
    )]
    Instance {
        /// Record of `INST`.
        record: usize,
        /// The tree that it names.
        blas: u32,
        /// Its number.
        id: u32,
        /// Rows of `BLAS`.
        trees: usize,
        /// Records of `INST`.
        instances: usize,
    },
    /// An instance flattens its mesh.
    #[error(
        "cannot take the scene from the file: the matrix of instance record {record} has no inverse that f64 can tell"
    )]
    Singular {
        /// Record of `INST`.
        record: usize,
    },
}

/// The triangles of a file, each once, and its instances in the order of their numbers: what brute force needs when the model is
/// not at hand.
///
/// Triangles come back in source order. Copies of a triangle that spatial splits made count once if they are equal; copies that
/// differ are all kept, since a ray can hit each of them. A one-level file becomes a single instance at the identity.
///
/// # Errors
/// Where records name what is not there, which no file whose topology was checked does.
pub fn scene_of_file(view: &View<'_>, names: Names<'_>) -> Result<Scene, NotAScene> {
    let two_levels = !view.tlas_nodes.is_empty();
    let trees = if two_levels { view.blases.len() } else { view.blases.len().min(1) };
    let meshes = (0..trees).map(|tree| mesh_of_tree(view, names, tree)).collect::<Result<Vec<Mesh>, _>>()?;
    let instances = if two_levels {
        instances(view)?
    } else {
        let whole = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
        meshes.iter().map(|_| whole.clone()).collect()
    };
    Ok(Scene { meshes, instances, ..Scene::default() })
}

fn mesh_of_tree(view: &View<'_>, names: Names<'_>, tree: usize) -> Result<Mesh, NotAScene> {
    let records = view.blas(tree).ok_or(NotAScene::TreeOutOfRange { tree })?.triangles;
    let low = view.geoms.partition_point(|g| (g.blas as usize) < tree);
    let high = view.geoms.partition_point(|g| (g.blas as usize) <= tree);

    // Every triangle once, in the order of parts and numbers.
    let mut slots: Vec<&TriangleRecord> = records.iter().collect();
    let key = |t: &TriangleRecord| (t.geom, t.prim, t.corners().map(|p| p.map(f32::to_bits)));
    slots.sort_unstable_by_key(|t| key(t));
    slots.dedup_by_key(|t| key(t));
    let mut mesh = Mesh { name: names.get(low).unwrap_or_default().to_owned(), ..Mesh::default() };
    for triangle in &slots {
        let (geom, prim) = (triangle.geom, triangle.prim);
        if !(low..high).contains(&(geom as usize)) {
            return Err(NotAScene::GeomOutOfRange { tree, geom });
        }
        if !triangle.corners().iter().flatten().all(|c| c.is_finite()) {
            return Err(NotAScene::NotFinite { tree, prim });
        }
        mesh.triangles.push(add_corners(&mut mesh.positions, triangle.corners()));
        mesh.source_prims.push(prim);
    }

    // A part for each row of GEOM, empty ones included.
    let mut first = 0;
    for (row, geom) in view.geoms.iter().enumerate().take(high).skip(low) {
        let end = slots.partition_point(|t| t.geom as usize <= row);
        mesh.parts.push(Part {
            name: names.get(row).unwrap_or_default().to_owned(),
            material: String::new(),
            source_mesh: geom.source_mesh,
            source_part: geom.source_part,
            baked_node: Some(geom.baked_node).filter(|n| *n != NO_NODE),
            mirrored: false,
            first_triangle: first as u32,
            triangle_count: (end - first) as u32,
            first_prim: geom.first_prim,
            prim_count: geom.prim_count,
        });
        first = end;
    }
    Ok(mesh)
}

fn add_corners(positions: &mut Vec<Point>, corners: [Point; 3]) -> [u32; 3] {
    let first = positions.len() as u32;
    positions.extend(corners);
    [first, first + 1, first + 2]
}

fn instances(view: &View<'_>) -> Result<Vec<Instance>, NotAScene> {
    let mut slots: Vec<Option<Instance>> = vec![None; view.instances.len()];
    for (record, stored) in view.instances.iter().enumerate() {
        let (blas, id, trees, instances) = (stored.blas, stored.id, view.blases.len(), view.instances.len());
        let wrong = NotAScene::Instance { record, blas, id, trees, instances };
        let free = slots.get_mut(id as usize).filter(|slot| slot.is_none());
        let (Some(slot), true) = (free, (blas as usize) < trees) else { return Err(wrong) };
        let transform = Affine::from_f32(&stored.object_to_world);
        if transform.inverse().is_none() || !transform.is_invertible_in_f64() {
            return Err(NotAScene::Singular { record });
        }
        *slot = Some(Instance { mesh: blas, transform, node: stored.node, name: String::new() });
    }
    Ok(slots.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Executor, Levels, Method, NoProgress};
    use crate::cache::Image;
    use crate::compile::compile;
    use crate::trace::rays::grid::GridScene;

    fn build(scene: &Scene, method: Method, levels: Levels) -> Image {
        let options = BuildOptions { method, levels, split_budget: 2.0, ..BuildOptions::default() };
        Image::new(
            &compile(scene.clone(), &options, &Executor::sequential(), &NoProgress).expect("a tree"),
            &Executor::sequential(),
        )
        .unwrap()
    }

    fn stored(image: &Image) -> Result<Scene, NotAScene> {
        scene_of_file(&image.view(), Names::default())
    }

    #[test]
    fn the_scene_of_a_file_is_the_scene_that_it_was_built_from() {
        for seed in 0..24 {
            let scene = GridScene::new(seed, 0).scene;
            let levels = if scene.instances.len() > 1 { Levels::Two } else { Levels::One };
            let image = build(&scene, Method::Sbvh, levels);
            let back = stored(&image).expect("a scene");
            assert_eq!((back.meshes.len(), back.instances.len()), (scene.meshes.len(), scene.instances.len()));
            for (mesh, built) in back.meshes.iter().zip(&scene.meshes) {
                assert_eq!((mesh.triangles.len(), &mesh.parts), (built.triangles.len(), &built.parts));
                for i in 0..built.triangles.len() {
                    let number = (mesh.source_prim(i), mesh.corners(i));
                    assert_eq!(number, (built.source_prim(i), built.corners(i)), "seed {seed}");
                }
            }
            for (instance, built) in back.instances.iter().zip(&scene.instances) {
                assert_eq!((instance.mesh, instance.transform), (built.mesh, built.transform));
            }
        }
    }

    #[test]
    fn an_empty_file_is_an_empty_scene() {
        let scene = stored(&Image::default()).expect("a scene");
        assert!(scene.meshes.is_empty() && scene.instances.is_empty());
    }

    #[test]
    fn copies_of_a_triangle_that_differ_are_all_kept() {
        let mut image = build(&GridScene::new(0, 0).scene, Method::Binned, Levels::One);
        let mut copy = image.triangles[0];
        copy.v0[1] += 0.5;
        image.triangles.push(copy);
        image.blases[0].ref_count += 1;
        let (before, after) = (image.triangles.len(), stored(&image).expect("a scene").meshes[0].triangles.len());
        assert_eq!(after, before);
    }

    #[test]
    fn records_that_name_nothing_are_refused() {
        let good = build(&GridScene::new(3, 0).scene, Method::Binned, Levels::Two);
        let refused = |spoil: &dyn Fn(&mut Image)| {
            let mut image = good.clone();
            spoil(&mut image);
            let error = stored(&image).expect_err("spoilt");
            assert!(error.to_string().starts_with("cannot take the scene from the file: "), "{error}");
            error
        };
        let rows = good.geoms.len() as u32;
        assert!(matches!(refused(&|i| i.triangles[0].geom = rows), NotAScene::GeomOutOfRange { tree: 0, .. }));
        assert!(matches!(refused(&|i| i.triangles[0].v1[2] = f32::NAN), NotAScene::NotFinite { tree: 0, .. }));
        assert!(matches!(refused(&|i| i.blases[0].ref_count = u32::MAX), NotAScene::TreeOutOfRange { tree: 0 }));
        assert!(matches!(refused(&|i| i.instances[1].blas = 99), NotAScene::Instance { record: 1, blas: 99, .. }));
        assert!(matches!(refused(&|i| i.instances[1].id = i.instances[0].id), NotAScene::Instance { record: 1, .. }));
        assert!(matches!(refused(&|i| i.instances[0].object_to_world = [0.0; 12]), NotAScene::Singular { record: 0 }));
    }
}
