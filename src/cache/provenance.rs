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
        ("ignored_weights", report.ignored_weights),
        ("twice_placed_nodes", report.twice_placed_nodes),
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

/// A name that says nothing of the machine and leads nowhere else on any: of an absolute path or URI the last part, without what looks like a
/// drive. The scene reader gives such a name only where it knows no way from the model's folder, or where a file's own name has a `\` or begins like
/// a drive; the file is then not found again, and a cache that depends on it is always built anew.
fn relative_name(name: &str) -> String {
    let name = name.replace('\\', "/");
    let has_drive = |name: &str| name.as_bytes().get(1) == Some(&b':');
    if !(name.starts_with('/') || has_drive(&name) || name.starts_with("file:")) {
        return name;
    }
    let mut last = name.rsplit('/').next().unwrap_or_default();
    while has_drive(last) {
        last = last.get(2..).unwrap_or_default();
    }
    last.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_that_is_written_leads_elsewhere() {
        let is_written_as = |name: &str, want: &str| {
            let written = Dependency { name: relative_name(name), ..Dependency::default() };
            assert!(written.name == want && !written.is_absolute(), "{name:?} is written as {:?}", written.name);
        };
        is_written_as("parts/wing.bin", "parts/wing.bin");
        is_written_as("../wing.bin", "../wing.bin");
        is_written_as("/home/a/wing.bin", "wing.bin");
        is_written_as("file:///home/a/wing.bin", "wing.bin");
        is_written_as("C:\\a\\wing.bin", "wing.bin");
        // Names that a file may have on Unix.
        is_written_as("a\\wing.bin", "a/wing.bin");
        is_written_as("\\\\host\\share\\wing.bin", "wing.bin");
        is_written_as("c:wing.bin", "wing.bin");
        is_written_as("/home/c:d:wing.bin", "wing.bin");
        is_written_as("c:", "");
        is_written_as("wing:bin", "wing:bin");
    }
}
