use super::extensions;
use super::present::placing_extensions;
use super::whole::{Index, Whole};
use crate::scene::source::Source;
use crate::scene::{Format, Resemblance, SceneError};
use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};
use serde_json::value::RawValue;
use std::collections::BTreeMap;

/// The part of a glTF file that says where triangles are; images, cameras and the like are skipped unread.
///
/// JSON numbers are doubles and are read as such.
#[derive(Deserialize)]
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
    pub scene: Option<Index>,
    /// Kept as text until a node uses one: a broken skin that nothing shows does no harm.
    #[serde(default)]
    skins: Vec<Box<RawValue>>,
    /// The name of each material, empty where it has none.
    #[serde(skip)]
    pub material_names: Vec<String>,
    /// The animations, kept as text until one is played.
    #[serde(skip)]
    pub animations: Vec<Box<RawValue>>,
    /// Extensions that may place geometry, that the file uses, and that are not honoured: because the caller said so, or because the file
    /// allows it.
    #[serde(skip)]
    pub ignored_extensions: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<Index>,
    pub byte_offset: Option<Whole<u64>>,
    pub component_type: Index,
    pub normalized: Option<bool>,
    pub count: Whole<u64>,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Sparse>,
}

/// Elements that replace some of an accessor's.
#[derive(Deserialize)]
pub(super) struct Sparse {
    pub count: Whole<u64>,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub buffer_view: Index,
    pub byte_offset: Option<Whole<u64>>,
    pub component_type: Index,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub buffer_view: Index,
    pub byte_offset: Option<Whole<u64>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub byte_length: Whole<u64>,
    pub uri: Option<String>,
    pub extensions: Option<ExtensionNames>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct View {
    pub buffer: Index,
    pub byte_offset: Option<Whole<u64>>,
    pub byte_length: Whole<u64>,
    pub byte_stride: Option<Whole<u64>>,
    pub extensions: Option<ExtensionNames>,
}

/// The extensions of an object of which only the names matter.
pub(super) type ExtensionNames = BTreeMap<String, IgnoredAny>;

/// A glTF scene.
#[derive(Deserialize)]
pub(super) struct SceneRoots {
    #[serde(default)]
    pub nodes: Vec<Index>,
}

#[derive(Deserialize)]
pub(super) struct Node {
    pub name: Option<String>,
    pub children: Option<Vec<Index>>,
    pub mesh: Option<Index>,
    pub skin: Option<Index>,
    pub matrix: Option<Box<[f64; 16]>>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    /// Of the mesh's morph targets; they go before the mesh's own weights.
    pub weights: Option<Vec<f64>>,
    pub extensions: Option<NodeExtensions>,
}

#[derive(Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<serde_json::Value>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
}

#[derive(Deserialize)]
pub(super) struct Visibility {
    pub visible: Option<bool>,
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
    /// Of the morph targets, where a node has none of its own.
    pub weights: Option<Vec<f64>>,
}

/// Values of `mode`.
pub(super) const TRIANGLES: u32 = 4;
pub(super) const TRIANGLE_STRIP: u32 = 5;
pub(super) const TRIANGLE_FAN: u32 = 6;

#[derive(Deserialize)]
pub(super) struct Primitive {
    /// Accessors by the names of vertex attributes.
    pub attributes: BTreeMap<String, Index>,
    pub indices: Option<Index>,
    pub material: Option<Index>,
    mode: Option<Index>,
    /// Accessors of displacements, by the names of the attributes that each morph target moves.
    pub targets: Option<Vec<BTreeMap<String, Index>>>,
    extensions: Option<ExtensionNames>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub inverse_bind_matrices: Option<Index>,
    #[serde(default)]
    pub joints: Vec<Index>,
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
        let looks_like_json = json.trim_ascii_start().first().is_none_or(|&b| b == b'{');
        if !looks_like_json {
            let obj = || (Format::sniff(json) == Some(Format::Obj)).then_some(Resemblance::Obj);
            if let Some(resembles) = Resemblance::of_stand_in(json).or_else(obj) {
                let (path, what) = (source.path.to_owned(), "the file".to_owned());
                return Err(SceneError::InPlaceOfData { path, what, resembles });
            }
            return Err(SceneError::malformed(source.path, "its text does not begin with a JSON object"));
        }

        // Check the version first: a glTF 1.0 file has other structures, and should not fail on one of them.
        let head = last_of_equal_keys(json, Head::read).map_err(|e| json_error(&e, source))?;
        check_version(head.asset, source)?;
        let read = |json: &[u8]| serde_json::from_slice::<Document>(json);
        let mut document = last_of_equal_keys(json, read).map_err(|e| json_error(&e, source))?;
        document.material_names = head.material_names;
        source.charge(head.animations.iter().map(|a| a.get().len() as u64).sum(), "its JSON")?;
        document.animations = head.animations;
        // What stands on nodes is followed whether the file lists it or not, and so are they who ignore it told.
        let mut used = head.extensions_used;
        let of_nodes = || document.nodes.iter().filter_map(|node| node.extensions.as_ref());
        let stands = [
            (extensions::INSTANCING, of_nodes().any(|e| e.instancing.is_some())),
            (extensions::VISIBILITY, of_nodes().any(|e| e.visibility.is_some())),
        ];
        used.extend(stands.into_iter().filter(|(_, stands)| *stands).map(|(name, _)| name.to_owned()));
        document.ignored_extensions = extensions::admit(&document.extensions_required, used, source)?;
        Ok(document)
    }

    pub fn requires(&self, extension: &str) -> bool {
        self.extensions_required.iter().any(|e| e == extension)
    }

    pub fn skin(&self, index: u32, source: &Source) -> Result<Skin, SceneError> {
        let Some(text) = self.skins.get(index as usize) else {
            let reason = format!("it uses skin {index}, but there are {}", self.skins.len());
            return Err(SceneError::malformed(source.path, reason));
        };
        read_text(text, &format!("skin {index}"), source)
    }

    /// An animation, as whoever plays it wants to see it. There must be one of that number.
    pub fn animation<T: DeserializeOwned>(&self, index: u32, source: &Source) -> Result<T, SceneError> {
        read_text(&self.animations[index as usize], &format!("animation {index}"), source)
    }

    /// The name of an animation, empty where it has none.
    pub fn animation_name(&self, index: u32) -> String {
        self.animations.get(index as usize).map(|a| read_or_default::<Named>(a).name).unwrap_or_default()
    }
}

impl Primitive {
    pub fn mode(&self) -> u32 {
        self.mode.map_or(TRIANGLES, |mode| mode.0)
    }

    /// The accessor of the positions, if it has such and is a surface.
    pub fn surface_positions(&self) -> Option<usize> {
        let is_surface = (TRIANGLES..=TRIANGLE_FAN).contains(&self.mode());
        self.attribute("POSITION").filter(|_| is_surface)
    }

    pub fn attribute(&self, name: &str) -> Option<usize> {
        self.attributes.get(name).map(|a| a.0 as usize)
    }

    pub fn has_extension(&self, name: &str) -> bool {
        self.extensions.as_ref().is_some_and(|e| e.contains_key(name))
    }
}

/// What is read before all else, or only as far as it can be read: a broken material says nothing about triangles.
struct Head {
    asset: Option<Asset>,
    material_names: Vec<String>,
    animations: Vec<Box<RawValue>>,
    extensions_used: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: Option<serde_json::Value>,
    min_version: Option<serde_json::Value>,
}

#[derive(Default, Deserialize)]
struct Named {
    #[serde(default)]
    name: String,
}

impl Head {
    fn read(json: &[u8]) -> Result<Head, serde_json::Error> {
        #[derive(Deserialize)]
        #[serde(rename_all = "camelCase")]
        struct Lists<'j> {
            asset: Option<Asset>,
            #[serde(borrow)]
            materials: Option<&'j RawValue>,
            #[serde(borrow)]
            animations: Option<&'j RawValue>,
            #[serde(borrow)]
            extensions_used: Option<&'j RawValue>,
        }
        let lists: Lists = serde_json::from_slice(json)?;
        // Some files have an extension that they do not list.
        let listed = elements(lists.extensions_used).map(read_or_default);
        let present = placing_extensions(json);
        Ok(Head {
            asset: lists.asset,
            material_names: elements(lists.materials).map(|m| read_or_default::<Named>(m).name).collect(),
            animations: elements(lists.animations).map(RawValue::to_owned).collect(),
            extensions_used: listed.chain(present).collect(),
        })
    }
}

/// Read an object that was kept as text.
fn read_text<T: DeserializeOwned>(text: &RawValue, of: &str, source: &Source) -> Result<T, SceneError> {
    let read = |json: &[u8]| serde_json::from_slice::<T>(json);
    last_of_equal_keys(text.get().as_bytes(), read)
        .map_err(|e| SceneError::malformed(source.path, format!("{of} is not that of a glTF file: {}", what(&e))))
}

/// The elements of a list, none where it is no list.
fn elements(list: Option<&RawValue>) -> impl Iterator<Item = &RawValue> {
    list.and_then(|l| serde_json::from_str::<Vec<&RawValue>>(l.get()).ok()).unwrap_or_default().into_iter()
}

fn read_or_default<'j, T: Deserialize<'j> + Default>(value: &'j RawValue) -> T {
    serde_json::from_str(value.get()).unwrap_or_default()
}

fn check_version(asset: Option<Asset>, source: &Source) -> Result<(), SceneError> {
    let Some(asset) = asset else {
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

/// Read a text in which a key may stand in one object more than once: the last one counts (glTF 2.0, 2.7). Such a text is rare, and seldom
/// can be read at once: what cannot is written anew with each key once, and read again.
fn last_of_equal_keys<T>(
    json: &[u8],
    read: impl Fn(&[u8]) -> Result<T, serde_json::Error>,
) -> Result<T, serde_json::Error> {
    read(json).or_else(|error| {
        let value = serde_json::from_slice::<serde_json::Value>(json);
        let unique = value.and_then(|value| serde_json::to_vec(&value));
        unique.and_then(|json| read(&json)).map_err(|_| error)
    })
}

fn json_error(error: &serde_json::Error, source: &Source) -> SceneError {
    let reason = format!("its JSON is not that of a glTF file: {}", what(error));
    match error.line() {
        0 => SceneError::malformed(source.path, reason),
        line => SceneError::malformed_line(source.path, line as u64, format!("{reason} (column {})", error.column())),
    }
}

/// What an error says, without its place and without most of a text that it cites: that may be a whole embedded buffer.
fn what(error: &serde_json::Error) -> String {
    const MOST: usize = 160;
    let text = error.to_string();
    let text = text.rsplit_once(" at line ").map_or(text.as_str(), |(what, _)| what);
    let is_payload = |text: &str| text.to_ascii_lowercase().contains("\"data:");
    match (text.split_once('"'), text.rsplit_once('"')) {
        (Some((before, _)), Some((_, after))) if text.len() > MOST || is_payload(text) => {
            format!("{before}\"…\"{after}")
        }
        _ => text.chars().take(MOST).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_structure_is_larger_than_is_charged_for_it() {
        let shown = [size_of::<Node>(), size_of::<Mesh>(), size_of::<Primitive>()];
        let stored = [size_of::<Accessor>(), size_of::<View>(), size_of::<Buffer>()];
        assert!(shown.iter().chain(&stored).all(|size| 2 * *size as u64 <= BYTES_PER_OBJECT), "{shown:?} {stored:?}");
    }
}
