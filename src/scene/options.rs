use super::animation::Moment;
use std::path::Path;

/// What happens to triangles without area. Triangles with NaN or infinite positions have no box and cannot stay: they are
/// dropped and counted under [`Keep`](Degenerate::Keep) and [`Drop`](Degenerate::Drop), refused under [`Error`](Degenerate::Error).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Degenerate {
    /// They stay, and are counted.
    Keep,
    /// They go, and are counted: no ray can hit them.
    #[default]
    Drop,
    /// The first one refuses the file.
    Error,
}

impl Degenerate {
    /// The policy's name, as users type it and files record it.
    pub const fn name(self) -> &'static str {
        match self {
            Degenerate::Keep => "keep",
            Degenerate::Drop => "drop",
            Degenerate::Error => "error",
        }
    }
}

/// Bits of a coordinate on a grid: 8 to 24.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexBits(u8);

impl VertexBits {
    /// From 8 to 24. More is what a number of 32 bits has.
    pub fn new(bits: u8) -> Option<VertexBits> {
        (8..=24).contains(&bits).then_some(VertexBits(bits))
    }

    /// The number.
    pub fn get(self) -> u8 {
        self.0
    }

    /// The largest number of so many bits.
    pub(super) fn largest(self) -> u32 {
        (1 << self.0) - 1
    }
}

impl std::str::FromStr for VertexBits {
    type Err = String;

    fn from_str(text: &str) -> Result<VertexBits, String> {
        text.parse().ok().and_then(VertexBits::new).ok_or_else(|| "a number from 8 to 24 is needed".to_owned())
    }
}

impl std::fmt::Display for VertexBits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// How a model file is read. [`ReadOptions::effective`] has those that change the result and belong in a build key; the others only decide
/// whether there is one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// What becomes of triangles without area.
    pub degenerate: Degenerate,
    /// Let a glTF name buffers outside its own folder: absolute paths, `..`, symbolic links and `file:` URIs.
    pub allow_outside: bool,
    /// The glTF scene to read; `None` takes the file's default, or its first, or all root nodes where it has none.
    pub scene: Option<u32>,
    /// The moment of an animation at which a glTF model is posed; `None` leaves it at rest. A model without animations has no moment.
    pub moment: Option<Moment>,
    /// glTF extensions that are read as if they were not in the file, even where it requires them. Data that stand only in a
    /// compressed form cannot be had that way.
    pub ignore_extensions: Vec<String>,
    /// Keep which vertices of the source each triangle has: [`Mesh::vertices`](super::Mesh::vertices).
    pub vertices: bool,
    /// Put the positions of each mesh on a grid of so many bits an axis, by which files of many frames become smaller: a corner moves by at most half a step of
    /// the grid, which is less than the longest side of the mesh's box over `2^(bits - 1)`. `None` leaves them where they are.
    pub vertex_bits: Option<VertexBits>,
    /// Keep what tells whether two models have the same polygons: [`Mesh::faces`](super::Mesh::faces). It changes nothing else.
    pub faces: bool,
    /// Most bytes that reading may hold at once, estimated before each allocation. No file can make the reader hold more.
    pub max_memory: u64,
}

impl ReadOptions {
    /// [`ReadOptions::max_memory`] unless another is given: 8 GiB.
    pub const DEFAULT_MAX_MEMORY: u64 = 8 << 30;

    /// Whether a glTF extension is to be read as if it were not in the file.
    pub(crate) fn ignores(&self, extension: &str) -> bool {
        self.ignore_extensions.iter().any(|e| e == extension)
    }
}

impl Default for ReadOptions {
    fn default() -> Self {
        ReadOptions {
            degenerate: Degenerate::default(),
            allow_outside: false,
            scene: None,
            moment: None,
            ignore_extensions: Vec::new(),
            vertices: false,
            vertex_bits: None,
            faces: false,
            max_memory: Self::DEFAULT_MAX_MEMORY,
        }
    }
}

/// The formats that can be read. A GLB is told from a `.gltf` by its first four bytes, whatever it is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ, without its material library.
    Obj,
    /// glTF 2.0, as JSON or as GLB.
    Gltf,
}

impl Format {
    /// By file name extension, in any case.
    pub fn from_extension(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "obj" => Some(Format::Obj),
            "gltf" | "glb" => Some(Format::Gltf),
            _ => None,
        }
    }

    /// By content: the GLB magic, a JSON object, or else text that has at least one OBJ statement.
    pub fn sniff(bytes: &[u8]) -> Option<Format> {
        let text = bytes.strip_prefix(BOM).unwrap_or(bytes).trim_ascii_start();
        if bytes.starts_with(b"glTF") || text.starts_with(b"{") {
            return Some(Format::Gltf);
        }
        let is_statement = |line: &[u8]| {
            let line = line.trim_ascii_start();
            [b"v ", b"v\t", b"f ", b"f\t", b"o ", b"g "].iter().any(|s| line.starts_with(*s))
        };
        let bytes = without_padding(bytes);
        let found = !bytes.contains(&0) && bytes.split(|&b| b == b'\n' || b == b'\r').any(is_statement);
        found.then_some(Format::Obj)
    }
}

pub(super) const BOM: &[u8] = b"\xef\xbb\xbf";

/// A text file without what programs leave behind its last line: NUL bytes, which pad blocks, and the end mark of DOS, with spaces
/// and line ends among them. Anywhere else a NUL belongs to no text.
pub(super) fn without_padding(bytes: &[u8]) -> &[u8] {
    let padding = |b: &u8| matches!(b, 0 | 0x1a) || b.is_ascii_whitespace();
    let end = bytes.iter().rposition(|b| !padding(b)).map_or(0, |last| last + 1);
    match bytes[end..].contains(&0) || bytes[end..].contains(&0x1a) {
        true => &bytes[..end],
        false => bytes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_bounded() {
        assert!([7, 25].map(VertexBits::new).iter().all(Option::is_none));
        assert_eq!("16".parse::<VertexBits>().unwrap().get(), 16);
        assert!(["", "x", "-8", "300"].iter().all(|text| text.parse::<VertexBits>().is_err()));
    }
}
