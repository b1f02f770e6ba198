//! Broken on purpose: whatever bytes a model holds, reading ends, in good time, in a scene or an error.

mod common;

use base64::Engine;
use bvhc::scene::{Degenerate, Format, Moment, ReadOptions, Seconds, read_bytes};
use std::panic::{AssertUnwindSafe, catch_unwind};

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0 0.5\nv 1 1 0 1 0 0\nv 0 1.5e0 0\nv .5 2 -1\nvt 0 0\nvn 0 0 1\ng wall\nusemtl red\n\
    f 1 2 3\nf -5/1/1 -4/1/1 -3//1 -2\nf 1 2 3 4 5\no roof\nl 1 2 3\np 1\nf 1 \\\n3 5\n";

const GLTF: &str = r#"{"asset":{"version":"2.0"},"extensionsRequired":["EXT_mesh_gpu_instancing","KHR_mesh_quantization"],
"buffers":[{"byteLength":96,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAECAgMAAwEAAAAAAAAAAAEAAAACAAAAAwAAAAAAgD8AAABAAABAQAAAgEAAAKBA"}],
"bufferViews":[{"buffer":0,"byteLength":48,"byteStride":12},{"buffer":0,"byteOffset":48,"byteLength":12},{"buffer":0,"byteOffset":60,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":4,"sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":2}}},
{"bufferView":1,"componentType":5121,"type":"SCALAR","count":6},{"bufferView":2,"byteOffset":0,"componentType":5125,"type":"SCALAR","count":4},
{"componentType":5126,"type":"VEC3","count":5,"sparse":{"count":2,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":2}}},
{"bufferView":0,"componentType":5120,"normalized":true,"type":"VEC3","count":4}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":4},{"attributes":{"POSITION":0},"indices":2,"mode":5},{"attributes":{"POSITION":4},"mode":6}]},{"primitives":[{"attributes":{"POSITION":3}}]}],
"nodes":[{"children":[1,2],"rotation":[0,0,1,0]},{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,1]},{"mesh":1,"scale":[2,2,2],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0,"SCALE":0}}}}],
"scenes":[{"nodes":[0]}],"scene":0}"#;

/// A skinned and morphed mesh, the same without skin, and a flattened one.
const POSED: &str = r#"{"asset":{"version":"2.0"},
"buffers":[{"byteLength":260,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEAAAABAAABAAAAAACAPwAAAAAAAAAAAAAAAAAAAD8AAAA/AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAACAvwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAgL8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8="}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12},{"buffer":0,"byteOffset":48,"byteLength":48},{"buffer":0,"byteOffset":96,"byteLength":128},{"buffer":0,"byteOffset":224,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},{"bufferView":1,"componentType":5121,"type":"VEC4","count":3},{"bufferView":2,"componentType":5126,"type":"VEC4","count":3},{"bufferView":3,"componentType":5126,"type":"MAT4","count":2},{"bufferView":4,"componentType":5126,"type":"VEC3","count":3}],
"meshes":[{"weights":[0.5],"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2,"JOINTS_1":1,"WEIGHTS_1":2},"targets":[{"POSITION":4}]}]}],
"skins":[{"joints":[1,3],"inverseBindMatrices":3},{"joints":[3,3]}],
"nodes":[{"children":[1,2],"scale":[2,2,2]},{"translation":[10,0,0]},{"mesh":0,"skin":0,"weights":[1]},{"rotation":[0,0,1,0]},{"mesh":0},{"mesh":0,"skin":1,"extensions":{"KHR_node_visibility":{"visible":true}}},{"mesh":0,"scale":[1,1,0]}],
"scenes":[{"nodes":[0,4,5,6]}]}"#;

/// What moves the nodes and the weights of that model, by every interpolation.
const ANIMATION: &str = r#""animations":[{"name":"A","channels":[{"sampler":0,"target":{"node":1,"path":"translation"}},
{"sampler":1,"target":{"node":3,"path":"rotation"}},{"sampler":2,"target":{"node":2,"path":"weights"}},{"sampler":3,"target":{"node":0,"path":"scale"}},
{"sampler":0,"target":{"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":"/nodes/9/scale"}}}}],
"samplers":[{"input":5,"output":0},{"input":5,"output":6,"interpolation":"LINEAR"},{"input":5,"output":5,"interpolation":"STEP"},
{"input":5,"output":7,"interpolation":"CUBICSPLINE"}]}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},{"bufferView":1,"componentType":5121,"type":"VEC4","count":3},{"bufferView":2,"componentType":5126,"type":"VEC4","count":3},{"bufferView":3,"componentType":5126,"type":"MAT4","count":2},{"bufferView":4,"componentType":5126,"type":"VEC3","count":3},
{"bufferView":4,"componentType":5126,"type":"SCALAR","count":3},{"bufferView":2,"componentType":5126,"type":"VEC4","count":3},{"bufferView":3,"componentType":5126,"type":"VEC3","count":9}],"#;

/// What stands in for a number in the text.
const NUMBERS: [&str; 18] = [
    "0",
    "-1",
    "1",
    "3",
    "255",
    "65535",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "99999999999999999999",
    "1e999",
    "-1e-999",
    "nan",
    "0.5",
    "1e38",
    "",
];

/// A linear congruential generator (Knuth's MMIX constants): the same mutations on every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

/// One to four changes: bytes flipped, cut, doubled or dropped, numbers replaced.
fn mutated(base: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = base.to_vec();
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            break;
        }
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(40)).min(bytes.len());
        match random.below(8) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = [0, 0xff, b'\n', b'\r', b'\\', b'"', b'{', b'-', b'/', b'#'][random.below(10)],
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let run = bytes[at..end].to_vec();
                bytes.splice(at..at, run);
            }
            _ => {
                // Replace the next number; in binary data, four bytes.
                let is_number = |b: &u8| b.is_ascii_digit() || matches!(b, b'-' | b'.');
                let Some(start) = bytes[at..].iter().position(is_number).map(|p| p + at) else { continue };
                let length = bytes[start..].iter().take_while(|b| is_number(b)).count();
                bytes.splice(start..start + length, NUMBERS[random.below(NUMBERS.len())].bytes());
            }
        }
    }
    bytes
}

fn glb() -> Vec<u8> {
    let json = GLTF.replacen(r#","uri":""#, r#","name":""#, 1).into_bytes();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((12 + 8 + json.len() as u32 + 8 + 96).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend(96u32.to_le_bytes());
    bytes.extend(b"BIN\0");
    let uri = GLTF.split("base64,").nth(1).and_then(|t| t.split('"').next()).unwrap();
    bytes.extend(base64::engine::general_purpose::STANDARD.decode(uri).unwrap());
    bytes
}

/// The small models by name.
fn bases() -> Vec<(String, Vec<u8>)> {
    let (before, rest) = POSED.split_once("\"accessors\":").unwrap();
    let (_, after) = rest.split_once("\n").unwrap();
    let moved = format!("{before}{ANIMATION}\n{after}").into_bytes();
    let bases = [
        ("a.obj", OBJ.into()),
        ("a.gltf", GLTF.into()),
        ("a.glb", glb()),
        ("posed.gltf", POSED.into()),
        (MOVED, moved),
    ];
    bases.map(|(name, base)| (name.to_owned(), base)).into()
}

/// The name of the model that is read at a moment of its animation.
const MOVED: &str = "moved.gltf";

fn moment(name: &str) -> Option<Moment> {
    (name == MOVED).then(|| Moment { time: Seconds::new(0.3), ..Moment::default() })
}

/// Read `rounds` mutations of each base; every one must end without a panic.
fn survive(bases: &[(String, Vec<u8>)], rounds: usize) {
    let policies = [Degenerate::Keep, Degenerate::Drop, Degenerate::Error];
    let (mut read, mut refused) = (0u64, 0u64);
    for (name, base) in bases {
        let format = if name.to_ascii_lowercase().ends_with("obj") { Format::Obj } else { Format::Gltf };
        for round in 0..rounds {
            let bytes = mutated(base, &mut Random(round as u64 * 7919 + 1));
            let (degenerate, moment) = (policies[round % 3], moment(name));
            let options = ReadOptions { degenerate, moment, max_memory: 64 << 20, ..ReadOptions::default() };
            let format = (round % 5 != 0).then_some(format);
            let kept = bytes.clone();
            match catch_unwind(AssertUnwindSafe(|| read_bytes(bytes, name, format, None, &options))) {
                Ok(Ok(scene)) => {
                    read += 1;
                    for mesh in &scene.meshes {
                        assert!(
                            mesh.triangles.iter().flatten().all(|v| (*v as usize) < mesh.positions.len()),
                            "{name} {round}"
                        );
                        assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()), "{name} {round}");
                    }
                }
                Ok(Err(error)) => {
                    refused += 1;
                    assert!(error.to_string().starts_with("cannot read "), "{name} {round}: {error}");
                }
                Err(_) => panic!("{name}, mutation {round}, panicked on:\n{}", String::from_utf8_lossy(&kept)),
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > 0 && refused > 0);
}

#[test]
fn small_models_survive_mutation() {
    let bases = bases();
    for (name, base) in &bases {
        let options = ReadOptions { moment: moment(name), ..ReadOptions::default() };
        let scene = read_bytes(base.clone(), name, None, None, &options).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.posed.is_some(), name == MOVED);
    }
    survive(&bases, 4000);
}

#[test]
fn every_truncation_of_a_small_model_ends() {
    for (name, base) in bases() {
        for length in 0..base.len() {
            let options = ReadOptions { moment: moment(&name), ..ReadOptions::default() };
            let _ = read_bytes(base[..length].to_vec(), &name, None, None, &options);
        }
    }
}

#[test]
fn corner_files_survive_mutation() {
    let Some(models) = common::models_dir() else { return };
    let names = [
        "obj_corner/trimesh/wallhole.obj",
        "obj_corner/tinyobjloader/issue-319-002.obj",
        "obj_corner/online3dviewer/lines_in_meshes.obj",
        "obj_corner/draco/deg_faces.obj",
        "gltf_corner/meshoptimizer/fuzz.glb",
        "gltf_corner/online3dviewer/SimpleSparseAccessor/glTF-Embedded/SimpleSparseAccessor.gltf",
        "gltf_corner/online3dviewer/Mesh_PrimitiveMode/Mesh_PrimitiveMode_11.gltf",
        "gltf_corner/gltf_transform/core/test/in/BoxVertexColors.glb",
        "gltf_corner/draco/Box/glTF_Binary/Box_Draco.glb",
    ];
    let load = |name: &&str| (name.to_string(), std::fs::read(models.join(name)).unwrap());
    survive(&names.iter().map(load).collect::<Vec<_>>(), 400);
}

#[test]
#[ignore = "long: 900,000 mutations"]
fn long_small_models_survive_many_mutations() {
    let bases = bases();
    survive(&bases, 300_000);
}
