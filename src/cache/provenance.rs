//! What a file says of how it was made.

use super::keys::Recipe;
use super::{Dependency, Meta};
use crate::scene::{InputFile, ReadReport};

/// Provenance as this crate writes it.
pub fn provenance(recipe: Recipe, inputs: &[InputFile], report: &ReadReport) -> Meta {
    let dependencies = inputs.iter().enumerate().map(|(i, input)| Dependency {
        role: if i == 0 { Dependency::MODEL } else { Dependency::BUFFER },
        name: relative_name(&input.name),
        len: input.len,
        blake3: input.blake3,
    });
    let always = [
        ("degenerate_triangles", report.degenerate_triangles),
        ("non_finite_triangles", report.non_finite_triangles),
        ("unreferenced_positions", report.unreferenced_positions),
        ("skipped_primitives", report.skipped_primitives),
        ("singular_instances", report.singular_instances),
    ];
    // Few models have any of these, and files of the others do not name them.
    let seldom = [
        ("out_of_range_triangles", report.out_of_range_triangles),
        ("unknown_statements", report.unknown_statements),
        ("out_of_range_instances", report.out_of_range_instances),
        ("unplayed_animations", report.unplayed_animations),
        ("unknown_channels", report.unknown_channels),
        ("unposed_skins", report.unposed_skins),
        ("uninstanced_skins", report.uninstanced_skins),
        ("mirrored_skins", report.mirrored_skins),
        ("unweighted_vertices", report.unweighted_vertices),
        ("unapplied_morph_weights", report.unapplied_morph_weights),
        ("absent_materials", report.absent_materials),
        ("hidden_nodes", report.hidden_nodes),
    ];
    let read_counts = always.into_iter().chain(seldom.into_iter().filter(|(_, count)| *count > 0));
    Meta {
        tool: "bvhc".into(),
        tool_version: env!("CARGO_PKG_VERSION").into(),
        method: recipe.method,
        builder_revision: recipe.builder_revision,
        options: recipe.options,
        dependencies: dependencies.collect(),
        read_counts: read_counts.map(|(name, count)| (name.into(), count)).collect(),
        notes: Vec::new(),
    }
}

/// A name that says nothing of the machine: of an absolute path or URI the last part. The scene reader gives such a name only where
/// it knows no way from the model's folder; the file is then not found again, and a cache that depends on it is always built anew.
fn relative_name(name: &str) -> String {
    let name = name.replace('\\', "/");
    let drive = name.as_bytes().get(1) == Some(&b':');
    if name.starts_with('/') || drive || name.starts_with("file:") {
        return name.rsplit('/').next().unwrap_or_default().to_owned();
    }
    name
}
