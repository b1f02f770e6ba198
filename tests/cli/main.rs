//! The program as a user meets it: every test runs the real binary in a folder of its own.

#[path = "../common/mod.rs"]
mod common;

mod accuracy;
mod again;
mod animations;
mod bounds;
mod build;
mod cases;
mod chart;
mod depfile;
mod determinism;
mod documents;
mod extensions;
mod forged;
mod frame_hits;
mod frame_lists;
mod frames;
mod hard_motions;
mod inputs;
mod inspect;
mod interrupt;
mod manners;
mod many;
mod nodes;
mod orient;
mod outputs;
mod patterns;
mod precision;
mod sequence_checks;
mod sequences;
mod snapshots;
mod source;
mod streams;
mod surfaces;
mod up_to_date;
mod verify;
mod view;

use assert_cmd::cargo::cargo_bin;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder that is gone after the test, and commands that run in it.
pub struct Place {
    dir: tempfile::TempDir,
}

/// What a finished command said.
pub struct Said {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl Default for Place {
    fn default() -> Place {
        Place { dir: tempfile::tempdir().unwrap() }
    }
}

impl Place {
    pub fn new() -> Place {
        Place::default()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub fn root(&self) -> &Path {
        self.dir.path()
    }

    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// The program, ready to be given arguments, with no `BVHC_*` or colour variable of the caller's.
    pub fn command(&self) -> Command {
        let mut command = Command::new(program());
        command.current_dir(self.root());
        for variable in ["BVHC_JOBS", "BVHC_COLOR", "BVHC_MAX_MEMORY", "NO_COLOR", "RUST_BACKTRACE"] {
            command.env_remove(variable);
        }
        command
    }

    /// Run with these arguments, split at spaces.
    pub fn run(&self, args: &str) -> Said {
        said(self.command().args(args.split_whitespace()).output().unwrap())
    }

    /// Run, and insist on success.
    pub fn ok(&self, args: &str) -> Said {
        let said = self.run(args);
        assert_eq!(said.code, 0, "bvhc {args}\n{}{}", said.out, said.err);
        said
    }

    /// Names in the folder, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.root()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

impl Said {
    /// stdout as JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}\n{}{}", self.out, self.err))
    }
}

/// The program under test: `BVHC_PROGRAM`, another build of it (`tests/cases_before.sh`), else the one that Cargo has built.
pub fn program() -> PathBuf {
    std::env::var_os("BVHC_PROGRAM").map_or_else(|| cargo_bin("bvhc"), PathBuf::from)
}

pub fn said(output: Output) -> Said {
    Said {
        code: output.status.code().unwrap_or(-1),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// A strip of `n` quads standing on a slope: an OBJ with 2·n triangles.
pub fn strip(n: usize) -> String {
    let mut text = String::new();
    for i in 0..=n {
        let x = i as f32;
        text.push_str(&format!("v {x} 0 {}\nv {x} 1 {}\n", x * 0.5, (i % 3) as f32));
    }
    for i in 0..n {
        let a = 2 * i + 1;
        text.push_str(&format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + 3, a + 3, a + 2));
    }
    text
}

/// One triangle in a glTF with an external buffer `NAME.bin`: the model and the buffer.
pub fn gltf(name: &str) -> (String, Vec<u8>) {
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bin = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "buffers":[{{"uri":"{name}.bin","byteLength":36}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}]}}"#
    );
    (json, bin)
}

/// The repository's folder.
pub fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}
