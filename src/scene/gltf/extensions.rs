//! Which glTF extensions are honoured, which are refused, and why: the one table that the reader and the documentation share.

use crate::scene::SceneError;
use crate::scene::source::Source;
use std::collections::BTreeSet;

pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
pub(super) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";
pub(super) const VISIBILITY: &str = "KHR_node_visibility";
pub(super) const ANIMATION_POINTER: &str = "KHR_animation_pointer";
const RTC: &str = "CESIUM_RTC";

/// What reading does with a glTF extension that a file requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// What it says about triangles is done.
    Honoured,
    /// The file is refused where data stand only in the extension's own form. Where the file also has plain data, they are read.
    Decoded,
    /// The file is refused: what the extension says about triangles is not done here.
    Refused,
    /// The file is read. An animation is refused if it is played and the extension moves triangles in it.
    Played,
    /// The file is read: the extension says nothing about where triangles are.
    Passed,
}

/// A row of the table of glTF extensions.
#[derive(Clone, Copy, Debug)]
pub struct Extension {
    /// The extension's name; with a `*` at its end, every name that begins so.
    pub name: &'static str,
    /// What reading does with a file that has it.
    pub treatment: Treatment,
    /// Why, as a phrase.
    pub why: &'static str,
}

const fn honoured(name: &'static str, why: &'static str) -> Extension {
    Extension { name, treatment: Treatment::Honoured, why }
}

const fn decoded(name: &'static str, why: &'static str) -> Extension {
    Extension { name, treatment: Treatment::Decoded, why }
}

const fn refused(name: &'static str, why: &'static str) -> Extension {
    Extension { name, treatment: Treatment::Refused, why }
}

const fn passed(name: &'static str, why: &'static str) -> Extension {
    Extension { name, treatment: Treatment::Passed, why }
}

const fn played(name: &'static str, why: &'static str) -> Extension {
    Extension { name, treatment: Treatment::Played, why }
}

const COMPRESSED: &str = "compressed triangles need a decoder; plain data beside them are read";
const SHADING: &str = "says how surfaces look, not where they are";
const METADATA: &str = "describes triangles and moves none";
const PLAYED: &str = "moves things only while something is played";
const POINTED: &str = "pointers to nodes and morph weights are not followed; those to all else move no triangles";

/// Every glTF extension that is known here. An extension that is not in the table is refused where a file requires it, by name.
pub const EXTENSIONS: &[Extension] = &[
    honoured("KHR_mesh_quantization", "integer positions and morph targets are read, normalized or not"),
    honoured(
        INSTANCING,
        "the mesh is placed once for each element; a skinned mesh stands where its joints put it, once",
    ),
    honoured(VISIBILITY, "a hidden node and all below it are left out and counted"),
    honoured("KHR_mesh_primitive_restart", "the highest index begins a new strip or fan"),
    honoured("EXT_mesh_primitive_restart", "the plain primitives are read; the groups only join the same triangles"),
    honoured("MSFT_lod", "the highest level of detail is read, as by a reader that does not know the extension"),
    decoded(DRACO, COMPRESSED),
    decoded(MESHOPT[0], COMPRESSED),
    decoded(MESHOPT[1], COMPRESSED),
    refused(
        RTC,
        "the centre stands in a coordinate system of the application's, so it cannot be added to the positions",
    ),
    refused(
        "AGI_articulations",
        "initial values of the stages move nodes; a file that requires it looks wrong without them",
    ),
    refused("KHR_accessor_float16", "half floats are not read"),
    refused("KHR_accessor_float64", "accessors of doubles are not read"),
    refused("KHR_gaussian_splatting*", "splats are not triangles"),
    refused("EXT_primitive_voxels", "voxels are not triangles"),
    refused("MPEG_accessor_timed", "positions come from a stream that changes"),
    refused("MPEG_buffer_circular", "positions come from a stream that changes"),
    refused("MPEG_mesh_linking", "another mesh moves the vertices"),
    refused("MPEG_scene_dynamic", "the nodes come from a stream that changes"),
    played(ANIMATION_POINTER, POINTED),
    passed("KHR_interactivity", PLAYED),
    passed("MPEG_animation_timing", PLAYED),
    passed("EXT_mesh_features", METADATA),
    passed("EXT_instance_features", METADATA),
    passed("EXT_feature_metadata", METADATA),
    passed("EXT_structural_metadata", METADATA),
    passed("EXT_mesh_manifold", METADATA),
    passed("EXT_mesh_primitive_edge_visibility", METADATA),
    passed("CESIUM_primitive_outline", METADATA),
    passed("FB_geometry_metadata", METADATA),
    passed("AGI_stk_metadata", METADATA),
    passed("GRIFFEL_bim_data", METADATA),
    passed("GODOT_single_root", METADATA),
    passed("KHR_node_hoverability", METADATA),
    passed("KHR_node_selectability", METADATA),
    passed("KHR_xmp", METADATA),
    passed("KHR_xmp_json_ld", METADATA),
    passed("KHR_techniques_webgl", "shaders are not run: vertices stand where nodes and joints put them"),
    passed("KHR_materials_*", SHADING),
    passed("EXT_materials_*", SHADING),
    passed("ADOBE_materials_*", SHADING),
    passed("NV_materials_*", SHADING),
    passed("MSFT_packing_*", SHADING),
    passed("KHR_texture_*", SHADING),
    passed("EXT_texture_*", SHADING),
    passed("MSFT_texture_*", SHADING),
    passed("MPEG_texture_*", SHADING),
    passed("EXT_image_*", SHADING),
    passed("KHR_lights_*", SHADING),
    passed("EXT_lights_*", SHADING),
    passed("KHR_audio_*", "is heard, not seen"),
    passed("MPEG_audio_*", "is heard, not seen"),
];

/// What the table says about an extension.
pub fn extension(name: &str) -> Option<&'static Extension> {
    EXTENSIONS.iter().find(|row| match row.name.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => row.name == name,
    })
}

/// Whether an extension may say where triangles are and is not honoured, so that its going unheeded must be told.
pub(super) fn may_place(name: &str) -> bool {
    extension(name).is_some_and(|row| row.treatment == Treatment::Refused)
}

/// Refuse a file that requires what is not done here, unless the caller ignores it. Otherwise say which extensions that may place
/// geometry go unheeded.
pub(super) fn admit(required: &[String], used: Vec<String>, source: &Source) -> Result<Vec<String>, SceneError> {
    let is_ignored = |name: &str| source.options.ignores(name);
    let mut unheeded = BTreeSet::new();
    for name in required {
        let found = extension(name);
        let is_read = found.is_some_and(|row| row.treatment != Treatment::Refused);
        match found {
            _ if is_ignored(name) => {
                if found.is_none_or(|row| !matches!(row.treatment, Treatment::Played | Treatment::Passed)) {
                    unheeded.insert(name.clone());
                }
            }
            _ if is_read => {}
            _ => return Err(refusal(name, found, source)),
        }
    }
    // What would have been done, had nobody said otherwise, is told as well.
    let is_undone =
        |name: &String| is_ignored(name) && extension(name).is_some_and(|row| row.treatment == Treatment::Honoured);
    unheeded.extend(used.into_iter().filter(|name| may_place(name) || is_undone(name)));
    Ok(unheeded.into_iter().collect())
}

fn refusal(name: &str, row: Option<&Extension>, source: &Source) -> SceneError {
    const UNKNOWN: &str = "whether it moves or changes triangles is not known here";
    let why = row.map_or(UNKNOWN, |row| row.why);
    SceneError::UnsupportedExtension { path: source.path.to_owned(), extension: name.to_owned(), why, ignorable: true }
}

/// The refusal of an animation in which pointers move triangles.
pub(super) fn moved_by_pointer(source: &Source) -> SceneError {
    SceneError::UnsupportedExtension {
        path: source.path.to_owned(),
        extension: ANIMATION_POINTER.to_owned(),
        why: "it moves nodes or morph weights in the animation",
        ignorable: true,
    }
}

/// The refusal of a compressed part, with the way out.
pub(super) fn compressed(extension: &str, source: &Source) -> SceneError {
    SceneError::UnsupportedExtension {
        path: source.path.to_owned(),
        extension: extension.to_owned(),
        why: "compressed triangles need a decoder",
        ignorable: false,
    }
}
