use crate::scene::SceneError;
use crate::scene::source::Source;
use ::gltf::json::{Accessor, Buffer, Mesh, Node, buffer::View};

/// The part of a glTF file that says where triangles are. Materials, images, cameras, skins and animations are skipped
/// unread.
#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    #[serde(default)]
    pub extensions_required: Vec<String>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub buffer_views: Vec<View>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub scenes: Vec<SceneRoots>,
    pub scene: Option<u32>,
}

/// A glTF scene; unlike the `gltf` crate's, it may leave out its list of nodes, as the specification allows.
#[derive(serde::Deserialize)]
pub(super) struct SceneRoots {
    #[serde(default)]
    pub nodes: Vec<u32>,
}

/// What an object of the JSON takes in memory at most, its list's spare room included, and what any other value does. The
/// smallest node is `{},`: 3 bytes become some 400.
const BYTES_PER_OBJECT: u64 = 1024;
const BYTES_PER_VALUE: u64 = 32;

impl Document {
    pub fn parse(json: &[u8], source: &mut Source) -> Result<Document, SceneError> {
        let count = |byte: u8| json.iter().filter(|b| **b == byte).count() as u64;
        let structures = count(b'{') * BYTES_PER_OBJECT + (count(b',') + count(b'[')) * BYTES_PER_VALUE;
        source.charge(json.len() as u64 + structures, "its JSON")?;
        check_version(json, source)?;
        let document: Document = serde_json::from_slice(json).map_err(|e| json_error(&e, source))?;
        for extension in &document.extensions_required {
            if !is_known(extension) {
                return Err(SceneError::UnsupportedExtension {
                    path: source.path.to_owned(),
                    extension: extension.clone(),
                    advice: "export the model without it; whether it changes geometry is not known here",
                });
            }
        }
        Ok(document)
    }

    pub fn requires(&self, extension: &str) -> bool {
        self.extensions_required.iter().any(|e| e == extension)
    }
}

/// Read the version alone first: a glTF 1.0 file has other structures, and should not fail on one of them.
fn check_version(json: &[u8], source: &Source) -> Result<(), SceneError> {
    #[derive(serde::Deserialize)]
    struct Head {
        asset: Option<Version>,
    }
    #[derive(serde::Deserialize)]
    #[serde(rename_all = "camelCase")]
    struct Version {
        version: Option<serde_json::Value>,
        min_version: Option<serde_json::Value>,
    }
    if json.trim_ascii_start().first().is_some_and(|&b| b != b'{') {
        return Err(SceneError::malformed(source.path, "its text does not begin with a JSON object"));
    }
    let head: Head = serde_json::from_slice(json).map_err(|e| json_error(&e, source))?;
    let Some(asset) = head.asset else {
        return Err(SceneError::malformed(source.path, "it has no 'asset' object; every glTF file needs one"));
    };
    let as_text = |v: serde_json::Value| v.as_str().map_or_else(|| v.to_string(), str::to_owned);
    let Some(version) = asset.version.map(as_text) else {
        return Err(SceneError::malformed(
            source.path,
            "its 'asset' object has no 'version'; every glTF file needs one",
        ));
    };
    let unsupported = |version| Err(SceneError::UnsupportedVersion { path: source.path.to_owned(), version });
    if version.split('.').next() != Some("2") {
        return unsupported(version);
    }
    match asset.min_version.map(as_text) {
        Some(minimum) if minimum != "2.0" => unsupported(minimum),
        _ => Ok(()),
    }
}

fn json_error(error: &serde_json::Error, source: &Source) -> SceneError {
    let text = error.to_string();
    let reason = text.split(" at line ").next().unwrap_or_default();
    let reason = format!("its JSON is not that of a glTF file: {reason}");
    match error.line() {
        0 => SceneError::malformed(source.path, reason),
        line => SceneError::malformed_line(source.path, line as u64, format!("{reason} (column {})", error.column())),
    }
}

/// Required extensions that are read, that fail later where they are used, or that say nothing about where triangles are.
fn is_known(extension: &str) -> bool {
    const READ: [&str; 2] = ["KHR_mesh_quantization", "EXT_mesh_gpu_instancing"];
    const COMPRESSION: [&str; 3] = [DRACO, MESHOPT[0], MESHOPT[1]];
    const NO_GEOMETRY: [&str; 12] = [
        "ADOBE_materials_thin_transparency",
        "AGI_articulations",
        "CESIUM_RTC",
        "CESIUM_primitive_outline",
        "EXT_feature_metadata",
        "EXT_instance_features",
        "EXT_mesh_features",
        "EXT_structural_metadata",
        "KHR_animation_pointer",
        "KHR_techniques_webgl",
        "KHR_xmp",
        "KHR_xmp_json_ld",
    ];
    const NO_GEOMETRY_PREFIXES: [&str; 9] = [
        "KHR_materials_",
        "EXT_materials_",
        "MSFT_packing_",
        "KHR_texture_",
        "EXT_texture_",
        "MSFT_texture_",
        "KHR_lights_",
        "EXT_lights_",
        "EXT_image_",
    ];
    READ.contains(&extension)
        || COMPRESSION.contains(&extension)
        || NO_GEOMETRY.contains(&extension)
        || NO_GEOMETRY_PREFIXES.iter().any(|p| extension.starts_with(p))
}

pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
pub(super) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The refusal of a compressed part, with the way out.
pub(super) fn compressed(extension: &str, source: &Source) -> SceneError {
    SceneError::UnsupportedExtension {
        path: source.path.to_owned(),
        extension: extension.to_owned(),
        advice: "decode the model once, for example with: npx @gltf-transform/cli cp in.glb out.glb",
    }
}

#[test]
fn no_structure_is_larger_than_is_charged_for_it() {
    let largest = [size_of::<Node>(), size_of::<Accessor>(), size_of::<Mesh>(), size_of::<View>(), size_of::<Buffer>()];
    assert!(largest.into_iter().all(|size| 2 * size as u64 <= BYTES_PER_OBJECT), "{largest:?}");
}
