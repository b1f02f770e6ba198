//! A forest as glTF: five meshes stored once, hundreds of places, a hierarchy, and one mirrored tree.

use super::mesh::{Mesh, Random, Vec3, decimal, turn};
use base64::Engine;

/// What a mesh's primitives become in the binary buffer, and the JSON that describes it.
#[derive(Default)]
struct Writer {
    binary: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
    meshes: Vec<String>,
    nodes: Vec<String>,
}

/// The scene as (JSON without the buffer's `uri`, binary buffer).
pub fn scene() -> (String, Vec<u8>) {
    let mut out = Writer::default();
    out.mesh("ground", &[ground()]);
    out.mesh("fir", &[trunk(0.18, 1.6), fir()]);
    out.mesh("oak", &[trunk(0.3, 2.4), crown([0.0, 3.6, 0.0], 1.9, 28, 20, 7)]);
    out.mesh("rock", &[crown([0.0, 0.1, 0.0], 0.6, 16, 12, 11)]);
    out.mesh("mushroom", &[mushroom()]);

    // Plant groves: a group node each, turned and placed, with the trees below it, so that matrices must be multiplied.
    let mut random = Random(2);
    let mut groves = vec![out.node("\"name\":\"ground\",\"mesh\":0")];
    for row in 0..4 {
        for column in 0..4 {
            let children = grove(&mut out, &mut random);
            let (cos, sin) = turn(random.next() / 2.0);
            let [x, z] = [column, row].map(|i| decimal(-45.0 + 30.0 * f64::from(i)));
            groves.push(out.node(&format!(
                "\"name\":\"grove {row}{column}\",\"translation\":[{x},0,{z}],\"rotation\":[0,{},0,{}],\"children\":[{}]",
                decimal(sin),
                decimal(cos),
                join(&children)
            )));
        }
    }
    // The mirrored oak: a matrix with a negative determinant, in the clearing.
    groves
        .push(out.node("\"name\":\"mirrored oak\",\"mesh\":2,\"matrix\":[-1.5,0,0,0, 0,1.5,0,0, 0,0,1.5,0, 0,0,0,1]"));
    let root = out.node(&format!("\"name\":\"forest\",\"children\":[{}]", join(&groves)));
    out.finish(root)
}

/// Eighteen plants within 13 m of the grove's own origin.
fn grove(out: &mut Writer, random: &mut Random) -> Vec<usize> {
    (0..18)
        .map(|_| {
            let (mesh, name) = match (random.next() * 10.0).floor() as u32 {
                0..=4 => (1, "fir"),
                5..=6 => (2, "oak"),
                7..=8 => (3, "rock"),
                _ => (4, "mushroom"),
            };
            let [x, z] = [(); 2].map(|()| decimal(random.between(-13.0, 13.0)));
            let (cos, sin) = turn(random.next() / 2.0);
            let size = decimal(random.between(0.7, 1.4));
            let tall = decimal(random.between(0.7, 1.5));
            out.node(&format!(
                "\"name\":\"{name}\",\"mesh\":{mesh},\"translation\":[{x},0,{z}],\"rotation\":[0,{},0,{}],\"scale\":[{size},{tall},{size}]",
                decimal(sin),
                decimal(cos)
            ))
        })
        .collect()
}

fn ground() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.sheet(48, 48, false, |u, v| {
        let ((_, a), (b, _)) = (turn(3.0 * u + 0.7 * v), turn(2.0 * v - 0.4 * u));
        [-65.0 + 130.0 * u, -0.35 + 0.25 * a * b, 65.0 - 130.0 * v]
    });
    mesh
}

fn trunk(radius: f64, height: f64) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.lathe([0.0, -0.6, 0.0], &[(radius * 1.5, 0.0), (radius, 0.9), (radius * 0.6, height + 0.6)], 10);
    mesh
}

/// Seven skirts of drooping needles.
fn fir() -> Mesh {
    let mut mesh = Mesh::default();
    for skirt in 0..7 {
        let low = 0.9 + 0.75 * f64::from(skirt);
        let reach = 1.6 - 0.2 * f64::from(skirt);
        mesh.sheet(36, 4, true, |u, v| {
            let (cos, sin) = turn(u);
            let (_, jag) = turn(18.0 * u + 0.25);
            let radius = (reach * (1.0 - v) + 0.02) * (1.0 + 0.12 * jag * (1.0 - v));
            [radius * cos, low + 1.2 * v * v - 0.1 * jag * (1.0 - v), -radius * sin]
        });
    }
    mesh
}

/// A lumpy ball.
fn crown(centre: Vec3, radius: f64, segments: usize, rings: usize, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let lumps: Vec<[f64; 3]> = (0..6).map(|_| [(); 3].map(|()| random.next())).collect();
    let mut mesh = Mesh::default();
    mesh.sheet(segments, rings, true, |u, v| {
        let ((up, out), (cos, sin)) = (turn(0.5 * (0.002 + 0.996 * (1.0 - v))), turn(u));
        let mut r = radius;
        for (n, lump) in lumps.iter().enumerate() {
            let whole = (n % 3 + 1) as f64;
            let ((_, a), (_, b)) = (turn(whole * u + lump[0]), turn(whole * v + lump[1]));
            r += radius * 0.09 * lump[2] * a * b * out;
        }
        [centre[0] + r * out * cos, centre[1] + r * up, centre[2] - r * out * sin]
    });
    mesh
}

fn mushroom() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.lathe(
        [0.0, -0.2, 0.0],
        &[(0.06, 0.0), (0.05, 0.4), (0.22, 0.42), (0.26, 0.46), (0.2, 0.56), (0.1, 0.62), (0.01, 0.64)],
        18,
    );
    mesh
}

fn join(numbers: &[usize]) -> String {
    numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(",")
}

impl Writer {
    fn node(&mut self, members: &str) -> usize {
        self.nodes.push(format!("{{{members}}}"));
        self.nodes.len() - 1
    }

    /// One mesh, a primitive per part: `f32` positions and `u16` indices.
    fn mesh(&mut self, name: &str, parts: &[Mesh]) {
        let primitives: Vec<String> = parts
            .iter()
            .map(|part| {
                let rounded: Vec<[f32; 3]> =
                    part.positions.iter().map(|p| p.map(|c| ((c * 10_000.0 + 0.5).floor() / 10_000.0) as f32)).collect();
                let bound = |pick: fn(f32, f32) -> f32| {
                    let all = rounded.iter().copied().reduce(|a, b| [0, 1, 2].map(|i| pick(a[i], b[i])));
                    all.unwrap_or_default().map(|c| c.to_string()).join(",")
                };
                let (min, max) = (bound(f32::min), bound(f32::max));
                let bytes = rounded.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
                let view = self.view(bytes, 34962);
                self.accessors.push(format!(
                    "{{\"bufferView\":{view},\"componentType\":5126,\"count\":{},\"type\":\"VEC3\",\"min\":[{min}],\"max\":[{max}]}}",
                    rounded.len()
                ));
                let indices: Vec<u16> = part.faces.iter().flatten().map(|&i| i as u16).collect();
                let view = self.view(indices.iter().flat_map(|i| i.to_le_bytes()).collect(), 34963);
                self.accessors.push(format!(
                    "{{\"bufferView\":{view},\"componentType\":5123,\"count\":{},\"type\":\"SCALAR\"}}",
                    indices.len()
                ));
                let last = self.accessors.len() - 1;
                format!("{{\"attributes\":{{\"POSITION\":{}}},\"indices\":{last}}}", last - 1)
            })
            .collect();
        self.meshes.push(format!("{{\"name\":\"{name}\",\"primitives\":[{}]}}", primitives.join(",")));
    }

    fn view(&mut self, bytes: Vec<u8>, target: u32) -> usize {
        self.views.push(format!(
            "{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{},\"target\":{target}}}",
            self.binary.len(),
            bytes.len()
        ));
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn finish(self, root: usize) -> (String, Vec<u8>) {
        let lines = |name: &str, rows: &[String]| format!(" \"{name}\":[\n  {}\n ]", rows.join(",\n  "));
        let json = [
            " \"asset\":{\"version\":\"2.0\",\"generator\":\"bvhc samples\"}".to_string(),
            format!(" \"scene\":0,\n \"scenes\":[{{\"nodes\":[{root}]}}]"),
            lines("nodes", &self.nodes),
            lines("meshes", &self.meshes),
            lines("accessors", &self.accessors),
            lines("bufferViews", &self.views),
        ];
        (json.join(",\n"), self.binary)
    }
}

/// The text form, its buffer embedded as a data URI.
pub fn to_gltf(json: &str, binary: &[u8]) -> Vec<u8> {
    let data = base64::engine::general_purpose::STANDARD.encode(binary);
    let uri = format!("\"uri\":\"data:application/octet-stream;base64,{data}\"");
    format!("{{\n{json},\n \"buffers\":[{{\"byteLength\":{},{uri}}}]\n}}\n", binary.len()).into_bytes()
}

/// The binary container: a 12-byte header, the JSON chunk padded with spaces, the binary chunk.
pub fn to_glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = format!("{{\n{json},\n \"buffers\":[{{\"byteLength\":{}}}]\n}}", binary.len()).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut out = b"glTF".to_vec();
    for word in [2, total as u32, json.len() as u32] {
        out.extend(word.to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(&json);
    out.extend((binary.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}
