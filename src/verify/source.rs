//! Whether a file was built from a model: the counts that must agree before its hits are judged by the model's triangles.

use crate::cache::{GeomRecord, View};
use crate::scene::{Part, Scene};
use std::fmt;

/// The file was built from something else.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OtherModel {
    #[error(
        "cannot judge the file by this model: the model has {model} meshes with triangles, and the file has {file} trees, so it was built from something else"
    )]
    Trees { model: usize, file: usize },
    #[error(
        "cannot judge the file by this model: the model has {model} instances, and the file has {file}, so it was built from something else"
    )]
    Instances { model: usize, file: usize },
    #[error(
        "cannot judge the file by this model: the model gives tree {tree} {model} parts, and the file has {file}, so it was built from something else"
    )]
    Parts { tree: usize, model: usize, file: usize },
    #[error(
        "cannot judge the file by this model: part {part} of tree {tree} has {model} in the model, and {file} in the file, so it was built from something else"
    )]
    Part { tree: usize, part: usize, model: PartCounts, file: PartCounts },
}

/// What is compared of a part: where it comes from, and how many of its triangles are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartCounts {
    pub source_mesh: u32,
    pub source_part: u32,
    pub kept: u32,
    pub all: u32,
}

impl fmt::Display for PartCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let PartCounts { source_mesh, source_part, kept, all } = self;
        write!(f, "{kept} of {all} triangles of part {source_part} of mesh {source_mesh}")
    }
}

/// Compare the numbers of trees, instances and parts, and each part's origin and number of triangles. Where vertices or matrices stand is left to
/// the rays.
///
/// `scene` is the model as read, without instances of empty meshes.
///
/// # Errors
/// The first number that differs.
pub fn is_of_model(view: &View<'_>, scene: &Scene) -> Result<(), OtherModel> {
    if view.tlas_nodes.is_empty() {
        // One tree over all instances, each with its mesh's parts.
        let (model, file) = (usize::from(!scene.instances.is_empty()), view.blases.len());
        if model != file {
            return Err(OtherModel::Trees { model, file });
        }
        let parts = scene.instances.iter().flat_map(|i| &scene.meshes[i.mesh as usize].parts);
        return compare_parts(0, &parts.collect::<Vec<_>>(), view.geoms);
    }
    let (model, file) = (scene.meshes.len(), view.blases.len());
    if model != file {
        return Err(OtherModel::Trees { model, file });
    }
    let (model, file) = (scene.instances.len(), view.instances.len());
    if model != file {
        return Err(OtherModel::Instances { model, file });
    }
    for (tree, mesh) in scene.meshes.iter().enumerate() {
        let low = view.geoms.partition_point(|g| (g.blas as usize) < tree);
        let high = view.geoms.partition_point(|g| (g.blas as usize) <= tree);
        let rows = view.geoms.get(low..high).unwrap_or_default();
        compare_parts(tree, &mesh.parts.iter().collect::<Vec<_>>(), rows)?;
    }
    Ok(())
}

fn compare_parts(tree: usize, parts: &[&Part], rows: &[GeomRecord]) -> Result<(), OtherModel> {
    if parts.len() != rows.len() {
        return Err(OtherModel::Parts { tree, model: parts.len(), file: rows.len() });
    }
    let counts =
        |source_mesh: u32, source_part: u32, kept: u32, all: u32| PartCounts { source_mesh, source_part, kept, all };
    for (number, (part, row)) in parts.iter().zip(rows).enumerate() {
        let model = counts(part.source_mesh, part.source_part, part.triangle_count, part.prim_count);
        let file = counts(row.source_mesh, row.source_part, row.kept_count, row.prim_count);
        if model != file {
            return Err(OtherModel::Part { tree, part: number, model, file });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Executor, Levels, NoProgress};
    use crate::cache::Image;
    use crate::compile::compile;
    use crate::trace::rays::grid::GridScene;

    fn build(scene: &Scene, levels: Levels) -> Image {
        let options = BuildOptions { levels, ..BuildOptions::default() };
        Image::new(
            &compile(scene.clone(), &options, &Executor::sequential(), &NoProgress).expect("a tree"),
            &Executor::sequential(),
        )
        .unwrap()
    }

    #[test]
    fn a_file_is_of_its_own_model_and_of_no_other() {
        for seed in 0..16 {
            let scene = GridScene::new(seed, 0).scene;
            for levels in [Levels::One, Levels::Two] {
                let image = build(&scene, levels);
                assert_eq!(is_of_model(&image.view(), &scene), Ok(()), "seed {seed}");
                let other = GridScene::new(seed + 4, 0).scene;
                let error = is_of_model(&image.view(), &other).expect_err("another scene");
                assert!(error.to_string().starts_with("cannot judge the file by this model: "), "{error}");
            }
        }
    }

    #[test]
    fn a_model_that_lost_something_is_told_by_what_it_lost() {
        let scene = GridScene::new(7, 0).scene;
        let image = build(&scene, Levels::Two);
        let mut fewer = scene.clone();
        fewer.instances.pop();
        assert!(matches!(is_of_model(&image.view(), &fewer), Err(OtherModel::Instances { .. })));
        let mut shorter = scene.clone();
        shorter.meshes[0].parts[0].triangle_count -= 1;
        assert!(matches!(is_of_model(&image.view(), &shorter), Err(OtherModel::Part { tree: 0, part: 0, .. })));
        let mut split = scene.clone();
        split.meshes[0].parts.push(Part::default());
        assert!(matches!(is_of_model(&image.view(), &split), Err(OtherModel::Parts { tree: 0, .. })));
        let none = Scene::default();
        assert!(matches!(is_of_model(&image.view(), &none), Err(OtherModel::Trees { model: 0, .. })));
    }
}
