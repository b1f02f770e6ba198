//! Is a cache up to date? Told by content, without parsing the model: META lists the files that the tree was made from, so
//! hashing those and comparing recipes is enough. Times and paths play no part.

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use bvhc_core::cache::parts::is_known_codec;

use super::keys::{InputHash, Recipe};
use super::{CacheError, Dependency, Head, Meta, OpenOptions};
use crate::exec::Executor;
use crate::layout::{SectionEntry, SectionKind};
use crate::scene::asks_for_vertices;

/// What [`freshness`] found.
#[derive(Debug)]
pub enum Freshness {
    /// The cache is what a build would write, its codec aside.
    Fresh {
        /// The cache's header, table and META.
        head: Box<Head>,
        /// The files that it depends on, as reached from the working directory, the model first.
        inputs: Vec<PathBuf>,
    },
    /// It must be built.
    Stale(Staleness),
}

/// Why a cache must be built (again). The text completes "stale: …".
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Staleness {
    /// There is no file.
    Missing,
    /// There is a file, but it is no cache, damaged, or of another version: the reader's words.
    Unreadable(String),
    /// The file does not say what it was made from.
    NoMeta,
    /// It was built by another method.
    Method {
        /// The method that META names.
        from: String,
        /// The method that is asked for.
        to: String,
    },
    /// The method, or the reading of models, gives another result now.
    BuilderRevision {
        /// The revision that META states.
        from: u32,
        /// This version's revision.
        to: u32,
    },
    /// `None`: the option is not there.
    Option {
        /// The option, as META names it.
        name: String,
        /// Its value in META.
        from: Option<String>,
        /// The value that is asked for.
        to: Option<String>,
    },
    /// A file that META lists is not there.
    InputMissing {
        /// Its name, relative to the model's folder.
        name: String,
    },
    /// A file that META lists has another length or hash.
    InputChanged {
        /// Its name, relative to the model's folder.
        name: String,
    },
    /// META says that the file has a section, and another program left it out.
    Section {
        /// Its type.
        kind: SectionKind,
    },
    /// A section of a kind that is known here, in a layout, under a number or by a codec that is not: readers of this version pass it over.
    Layout {
        /// Its type.
        kind: SectionKind,
        /// Its number among those of its type.
        ordinal: u32,
        /// Its layout version.
        schema: u16,
        /// How it is stored.
        codec: u8,
    },
    /// Everything that META says agrees, but the key in the header is another.
    Key,
}

impl fmt::Display for Staleness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |value: &Option<String>| value.clone().unwrap_or("unset".into());
        match self {
            Staleness::Missing => write!(f, "missing"),
            Staleness::Unreadable(why) => write!(f, "{}", why.lines().next().unwrap_or_default()),
            Staleness::NoMeta => write!(f, "the file does not say what it was built from"),
            Staleness::Method { from, to } => write!(f, "method {from} → {to}"),
            Staleness::BuilderRevision { from, to } => write!(f, "builder revision {from} → {to}"),
            Staleness::Option { name, from, to } => write!(f, "option {name} {} → {}", text(from), text(to)),
            Staleness::InputMissing { name } => write!(f, "{name} cannot be read"),
            Staleness::InputChanged { name } => write!(f, "{name} changed"),
            Staleness::Section { kind } => write!(f, "the section {kind} is missing"),
            Staleness::Layout { kind, ordinal, schema, codec } => {
                write!(
                    f,
                    "the section {kind} {ordinal} has schema {schema} and codec {codec}, which this version does not write"
                )
            }
            Staleness::Key => write!(f, "the build key is another"),
        }
    }
}

/// Hold the cache at `path` against what a build of `model` by `recipe` would write.
///
/// Reads the cache's header and META, and every byte of the inputs whose length is unchanged; costs what hashing them costs.
pub fn freshness(path: &Path, model: &Path, recipe: &Recipe, exec: &Executor) -> Freshness {
    match compare(path, model, recipe, exec) {
        Ok((head, inputs)) => Freshness::Fresh { head: Box::new(head), inputs },
        Err(why) => Freshness::Stale(why),
    }
}

/// [`freshness`] for a model that is in memory and names no other files.
pub fn freshness_of_bytes(path: &Path, model: &[u8], recipe: &Recipe, exec: &Executor) -> Freshness {
    match compare_bytes(path, model, recipe, exec) {
        Ok(head) => Freshness::Fresh { head: Box::new(head), inputs: Vec::new() },
        Err(why) => Freshness::Stale(why),
    }
}

fn compare_bytes(path: &Path, model: &[u8], recipe: &Recipe, exec: &Executor) -> Result<Head, Staleness> {
    let head = read_head(path)?;
    let meta = meta_of(&head)?;
    compare_recipe(meta, recipe)?;
    is_understood(&head)?;
    has_what_was_asked(&head, recipe)?;
    let blake3 = exec.hash(model);
    let input = InputHash { role: Dependency::MODEL, len: model.len() as u64, blake3 };
    let same = |d: &Dependency| (d.role, d.len, d.blake3) == (input.role, input.len, input.blake3);
    if !matches!(&meta.dependencies[..], [only] if same(only)) {
        return Err(Staleness::InputChanged { name: "the model".into() });
    }
    if recipe.build_key(vec![input]) == head.header.build_key { Ok(head) } else { Err(Staleness::Key) }
}

fn read_head(path: &Path) -> Result<Head, Staleness> {
    Head::read(path, &OpenOptions::default()).map_err(|error| match error {
        CacheError::Io { source, .. } if source.kind() == io::ErrorKind::NotFound => Staleness::Missing,
        CacheError::Io { ref source, .. } => Staleness::Unreadable(format!("{error}: {source}")),
        error => Staleness::Unreadable(error.to_string()),
    })
}

/// META, or why there is none.
fn meta_of(head: &Head) -> Result<&Meta, Staleness> {
    let why = || head.meta_error.clone().map_or(Staleness::NoMeta, Staleness::Unreadable);
    head.meta.as_ref().ok_or_else(why)
}

fn compare(path: &Path, model: &Path, recipe: &Recipe, exec: &Executor) -> Result<(Head, Vec<PathBuf>), Staleness> {
    let head = read_head(path)?;
    let meta = meta_of(&head)?;
    compare_recipe(meta, recipe)?;
    is_understood(&head)?;
    has_what_was_asked(&head, recipe)?;

    // Hash the inputs in the order of the key.
    let folder = model.parent().unwrap_or(Path::new(""));
    let (mut inputs, mut hashes) = (Vec::new(), Vec::new());
    for dependency in &meta.dependencies {
        let input =
            if dependency.role == Dependency::MODEL { model.to_owned() } else { beside(folder, &dependency.name)? };
        hashes.push(InputHash { role: dependency.role, ..unchanged(dependency, &input, exec)? });
        inputs.push(input);
    }
    if recipe.build_key(hashes) != head.header.build_key {
        return Err(Staleness::Key);
    }
    Ok((head, inputs))
}

fn compare_recipe(meta: &Meta, recipe: &Recipe) -> Result<(), Staleness> {
    if meta.method != recipe.method {
        return Err(Staleness::Method { from: meta.method.clone(), to: recipe.method.clone() });
    }
    if meta.builder_revision != recipe.builder_revision {
        return Err(Staleness::BuilderRevision { from: meta.builder_revision, to: recipe.builder_revision });
    }
    let value = |options: &[(String, String)], name: &str| {
        options.iter().find(|(n, _)| n == name).map(|(_, value)| value.clone())
    };
    for (name, _) in recipe.options.iter().chain(&meta.options) {
        let (from, to) = (value(&meta.options, name), value(&recipe.options, name));
        if from != to {
            return Err(Staleness::Option { name: name.clone(), from, to });
        }
    }
    Ok(())
}

/// A section that readers of this version pass over is none that a build would write. Kinds that are not known here are other programs' own.
fn is_understood(head: &Head) -> Result<(), Staleness> {
    let is_other = |s: &&SectionEntry| {
        let known_codec = is_known_codec(s);
        s.kind.rule().is_some_and(|rule| s.schema != rule.schema || s.ordinal >= rule.ordinals || !known_codec)
    };
    match head.sections.iter().find(is_other) {
        Some(&SectionEntry { kind, ordinal, schema, codec, .. }) => {
            Err(Staleness::Layout { kind, ordinal, schema, codec })
        }
        None => Ok(()),
    }
}

/// Sections that may be left out may have been left out by another program, which copied META as it was.
fn has_what_was_asked(head: &Head, recipe: &Recipe) -> Result<(), Staleness> {
    let has = |kind| head.sections.iter().any(|s| s.kind == kind && s.elem_count > 0);
    if asks_for_vertices(&recipe.options) && has(SectionKind::TRIS) && !has(SectionKind::VERT) {
        return Err(Staleness::Section { kind: SectionKind::VERT });
    }
    Ok(())
}

/// Where a dependency lies. META is a file's word: a name that leads to the root of the file system is not followed.
fn beside(folder: &Path, name: &str) -> Result<PathBuf, Staleness> {
    let relative = Path::new(name);
    if relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir | Component::ParentDir)) {
        return Ok(folder.join(relative));
    }
    Err(Staleness::InputMissing { name: name.to_owned() })
}

/// Length and hash of a file, if they are what META says; the file is not read where its length tells already.
fn unchanged(dependency: &Dependency, path: &Path, exec: &Executor) -> Result<InputHash, Staleness> {
    let missing = |_| Staleness::InputMissing { name: dependency.name.clone() };
    let changed = || Staleness::InputChanged { name: dependency.name.clone() };
    let metadata = std::fs::metadata(path).map_err(missing)?;
    if !metadata.is_file() || metadata.len() != dependency.len {
        return Err(changed());
    }
    let (len, blake3) = hash_file(path, exec).map_err(missing)?;
    if (len, blake3) != (dependency.len, dependency.blake3) {
        return Err(changed());
    }
    Ok(InputHash { role: dependency.role, len, blake3 })
}

/// Length and BLAKE3 of a file, read in pieces and hashed on all threads. Not mapped: another program may be rewriting it.
pub fn hash_file(path: &Path, exec: &Executor) -> io::Result<(u64, [u8; 32])> {
    let mut file = File::open(path)?;
    let mut hasher = blake3::Hasher::new();
    let size = file.metadata()?.len().clamp(1, 4 << 20) as usize;
    let mut piece = vec![0; size];
    let mut len = 0;
    loop {
        let n = match file.read(&mut piece) {
            Ok(0) => return Ok((len, *hasher.finalize().as_bytes())),
            Ok(n) => n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(e) => return Err(e),
        };
        exec.update_hash(&mut hasher, &piece[..n]);
        len += n as u64;
    }
}
