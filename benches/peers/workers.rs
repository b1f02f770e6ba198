//! The peers: each a program behind a pipe, so that one graph of crates need not hold what excludes each other, and nothing of theirs runs beside ours.
//!
//! How they are spoken to says `bvhc::report::tradeoff::Pipe`.

use bvhc::report::tradeoff::{PEERS, Worker};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A peer with its settings, in the order of the bytes that ask for them.
pub struct Family {
    pub name: &'static str,
    pub settings: &'static [&'static str],
    /// How it is started for one thread and for two; `None` where that form could not be had.
    pub forms: [Option<Worker>; 2],
}

/// The names that `--peers` takes.
pub const NAMES: [&str; 4] = [PEERS[0].0, PEERS[1].0, PEERS[2].0, PEERS[3].0];

/// The peers of `--peers`, ready: all where none is named, none where that is `none`.
pub fn asked(wanted: &[String]) -> Result<Vec<Family>, String> {
    let is = |name: &str, of: &&String| of.eq_ignore_ascii_case(name);
    if let Some(unknown) = wanted.iter().find(|w| !is("none", w) && !NAMES.iter().any(|name| is(name, w))) {
        return Err(format!("no peer is called {unknown}; there are {}, and none", NAMES.join(", ")));
    }
    Ok(if wanted.iter().any(|w| is("none", &w)) { Vec::new() } else { families(wanted) })
}

/// Make the peers ready; what is not there is left out with a note on stderr.
fn families(wanted: &[String]) -> Vec<Family> {
    let is_wanted = |name: &&str| wanted.is_empty() || wanted.iter().any(|w| w.eq_ignore_ascii_case(name));
    NAMES.into_iter().filter(is_wanted).filter_map(family).collect()
}

fn family(name: &'static str) -> Option<Family> {
    let form = |program: &Path, arguments: &[&str]| Worker::of(name, program, arguments);
    let settings = PEERS.iter().find(|(of, _)| *of == name).map(|(_, settings)| *settings)?;
    match name {
        "embree" => {
            let Embree { program, library } = Embree::find()?;
            let library = library.to_string_lossy().into_owned();
            let forms = ["1", "2"].map(|threads| form(&program, &[&library, threads]));
            Some(Family { name, settings, forms })
        }
        // On one thread or on all, as they were compiled.
        "obvhs" | "tinybvh" => {
            let (package, target) = (format!("{name}_worker"), |form: &str| format!("{name}-{form}"));
            let serial = build(&package, &target("serial"), &[]).and_then(|p| form(&p, &[]));
            let parallel = build(&package, &target("parallel"), &["--features", "parallel"]);
            let parallel = parallel.and_then(|p| form(&p, &[]));
            (serial.is_some() || parallel.is_some()).then_some(Family { name, settings, forms: [serial, parallel] })
        }
        _ => {
            let program = build("bvh_worker", "bvh", &[])?;
            Some(Family { name, settings, forms: ["1", "2"].map(|threads| form(&program, &[threads])) })
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
