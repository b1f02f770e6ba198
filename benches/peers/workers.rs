//! The peers: each a program behind a pipe, so that one graph of crates need not hold what excludes each other, and nothing of theirs runs beside ours.
//!
//! A worker is told the triangles once. A byte asks for a build by one of its settings; the answer is the build's own time and the tree.

use bvhc::scene::Mesh;
use bvhc::tree::{Node, Tree};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// A peer with its settings, in the order of the bytes that ask for them.
pub struct Family {
    pub name: &'static str,
    pub settings: &'static [&'static str],
    /// How it is started for one thread and for two; `None` where that form could not be had.
    pub forms: [Option<Form>; 2],
}

pub struct Form {
    program: PathBuf,
    arguments: Vec<String>,
}

/// The names that `--peers` takes.
pub const NAMES: [&str; 3] = ["embree", "obvhs", "bvh"];

/// Make the peers ready; what is not there is left out with a note on stderr.
pub fn families(wanted: &[String]) -> Vec<Family> {
    let is_wanted = |name: &&str| wanted.is_empty() || wanted.iter().any(|w| w == name);
    NAMES.into_iter().filter(is_wanted).filter_map(family).collect()
}

fn family(name: &'static str) -> Option<Family> {
    let form = |program: &Path, arguments: &[&str]| {
        Some(Form { program: program.to_path_buf(), arguments: arguments.iter().map(|a| a.to_string()).collect() })
    };
    match name {
        "embree" => {
            let Embree { program, library } = Embree::find()?;
            let library = library.to_string_lossy().into_owned();
            let forms = ["1", "2"].map(|threads| form(&program, &[&library, threads]));
            Some(Family { name, settings: &["low", "medium", "high"], forms })
        }
        "obvhs" => {
            let serial = build("obvhs_worker", "obvhs-serial", &[]).and_then(|p| form(&p, &[]));
            let parallel =
                build("obvhs_worker", "obvhs-parallel", &["--features", "parallel"]).and_then(|p| form(&p, &[]));
            let settings = &["fastest", "very_fast", "fast", "medium", "slow", "very_slow"];
            (serial.is_some() || parallel.is_some()).then_some(Family { name, settings, forms: [serial, parallel] })
        }
        _ => {
            let program = build("bvh_worker", "bvh", &[])?;
            Some(Family { name, settings: &["default"], forms: ["1", "2"].map(|threads| form(&program, &[threads])) })
        }
    }
}

/// Compile a worker's package; `None`, with the reason on stderr, where that fails.
fn build(package: &str, target: &str, features: &[&str]) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = root.join("target").join(target);
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--release", "--locked", "--quiet", "--manifest-path"]);
    cargo.arg(root.join("benches").join(package).join("Cargo.toml")).arg("--target-dir").arg(&folder).args(features);
    match cargo.status() {
        Ok(status) if status.success() => Some(folder.join("release").join(package)),
        other => {
            eprintln!("{target} is left out: its worker could not be built: {other:?}");
            None
        }
    }
}

/// Embree's worker and the library that it loads.
pub struct Embree {
    pub program: PathBuf,
    pub library: PathBuf,
}

impl Embree {
    /// `None`, with the reason on stderr, where one of them cannot be had.
    pub fn find() -> Option<Embree> {
        let library = embree_library()?;
        Some(Embree { program: build("embree_worker", "embree", &[])?, library })
    }
}

/// Embree 4's shared library: what `BVHC_EMBREE` names, or that of the Python package `embreex`, or one that the system's loader finds.
fn embree_library() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("BVHC_EMBREE") {
        let path = PathBuf::from(path);
        if path.is_file() {
            return Some(path);
        }
        eprintln!("embree is left out: BVHC_EMBREE names {}, which is no file", path.display());
        return None;
    }
    let is_embree = |name: &str| name.starts_with("libembree4") && name.contains(".so");
    let folders = python_folders().into_iter().map(|f| f.join("embreex.libs"));
    let system = ["/usr/lib/x86_64-linux-gnu", "/usr/local/lib", "/usr/lib64", "/usr/lib"].map(PathBuf::from);
    for folder in folders.chain(system) {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        let mut found: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        found.retain(|p| is_embree(&p.file_name().unwrap_or_default().to_string_lossy()));
        found.sort();
        if let Some(path) = found.into_iter().next() {
            return Some(path);
        }
    }
    eprintln!(
        "embree is left out: no libembree4 was found; `pip install embreex` brings one, or name it in BVHC_EMBREE"
    );
    None
}

/// Where Python keeps its packages.
fn python_folders() -> Vec<PathBuf> {
    let script = "import site, sysconfig; print(sysconfig.get_path('platlib')); print(site.getusersitepackages())";
    let output = Command::new("python3").args(["-c", script]).stderr(Stdio::null()).output();
    let text = output.map(|o| String::from_utf8_lossy(&o.stdout).into_owned()).unwrap_or_default();
    text.lines().map(PathBuf::from).collect()
}

/// A worker at work on one mesh.
pub struct Pipe {
    child: Child,
}

impl Pipe {
    pub fn open(form: &Form, threads: usize, mesh: &Mesh) -> std::io::Result<Pipe> {
        let mut command = Command::new(&form.program);
        command.args(&form.arguments).env("RAYON_NUM_THREADS", threads.to_string());
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let corners: Vec<[[f32; 3]; 3]> = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
        let input = child.stdin.as_mut().expect("a pipe was asked for");
        input.write_all(&(corners.len() as u32).to_ne_bytes())?;
        input.write_all(bytemuck::cast_slice(&corners))?;
        input.flush()?;
        Ok(Pipe { child })
    }

    /// Milliseconds, and the tree in our order of nodes.
    pub fn build(&mut self, setting: u8) -> std::io::Result<(f64, Tree)> {
        let input = self.child.stdin.as_mut().expect("a pipe was asked for");
        input.write_all(&[setting])?;
        input.flush()?;
        let output = self.child.stdout.as_mut().expect("a pipe was asked for");
        let mut milliseconds = [0; 8];
        output.read_exact(&mut milliseconds)?;
        let mut count = [0; 4];
        output.read_exact(&mut count)?;
        let mut nodes = vec![<Node as bytemuck::Zeroable>::zeroed(); u32::from_ne_bytes(count) as usize];
        output.read_exact(bytemuck::cast_slice_mut(&mut nodes))?;
        output.read_exact(&mut count)?;
        let mut refs = vec![0u32; u32::from_ne_bytes(count) as usize];
        output.read_exact(bytemuck::cast_slice_mut(&mut refs))?;
        Ok((f64::from_ne_bytes(milliseconds), canonical(&nodes, &refs)))
    }
}

impl Drop for Pipe {
    /// Closing its input ends the worker.
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        let _ = self.child.wait();
    }
}

/// Any tree of sibling pairs in our order: pairs in depth-first preorder, leaves likewise.
fn canonical(nodes: &[Node], refs: &[u32]) -> Tree {
    let Some(root) = nodes.first() else { return Tree::default() };
    let mut tree = Tree { nodes: vec![*root; 2], refs: Vec::with_capacity(refs.len()) };
    tree.nodes[1] = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
    let mut stack = vec![0usize];
    while let Some(at) = stack.pop() {
        let node = tree.nodes[at];
        if node.is_leaf() {
            tree.nodes[at].first = tree.refs.len() as u32;
            tree.refs.extend(&refs[node.first as usize..(node.first + node.count) as usize]);
        } else {
            let pair = tree.nodes.len();
            tree.nodes[at].first = pair as u32;
            tree.nodes.extend_from_slice(&nodes[node.first as usize..][..2]);
            stack.extend([pair + 1, pair]);
        }
    }
    tree
}
