//! Who may use whom: every room of both crates uses those before it and none after, and no two modules of a folder use each other in a
//! circle.
//!
//! The sources are read as Rust, and every path that names a module of its own crate is followed, through `use` and re-exports, to the module
//! that it comes from. Code for tests alone may look upward: it is left out, as are the links of documentation.

mod graph;
mod sources;

use graph::{circles, uses};
use sources::Sources;
use std::collections::BTreeSet;
use std::path::Path;

/// The rooms of a crate in the table of `docs/architecture.md`, which lists them from the bottom up.
fn rooms_of(part: &str) -> Vec<String> {
    let page = std::fs::read_to_string(folder("docs/architecture.md")).expect("the page");
    let row = |line: &str| {
        let mut cells = line.strip_prefix("| ")?.split(" | ");
        let is_of_it = cells.next()? == part;
        let room = cells.next()?.strip_prefix('`')?.strip_suffix('`')?;
        is_of_it.then(|| room.to_string())
    };
    page.lines().filter_map(row).collect()
}

/// Folders that are one concept, too long for a file: the table of options, whose rows know the struct that is written out of them.
const KNOTS: [&str; 1] = ["build::recipe:"];

fn folder(of: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(of)
}

/// Everything that breaks the rules, a line each.
fn breaches(sources: &Sources, rooms: &[String]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let rank = |room: &str| rooms.iter().position(|r| r == room);
    for (from, to, path) in uses(sources) {
        let (Some(here), Some(there)) = (from.first(), to.first()) else { continue };
        match (rank(here), rank(there)) {
            (Some(a), Some(b)) if a >= b => continue,
            (Some(_), Some(_)) => {
                found.insert(format!("{} uses {path}, but {here} lies below {there}", from.join("::")))
            }
            (None, _) => found.insert(format!("{here} has no place in the table of rooms")),
            (_, None) => found.insert(format!("{there} has no place in the table of rooms")),
        };
    }
    for (name, module) in &sources.modules {
        found.extend(module.hidden.iter().map(|what| format!("{} takes {what}", name.join("::"))));
    }
    let circles = circles(sources).into_iter().filter(|circle| !KNOTS.iter().any(|knot| circle.starts_with(knot)));
    found.extend(circles.map(|circle| format!("a circle: {circle}")));
    found
}

#[test]
fn no_room_of_the_core_uses_one_above_it() {
    let sources = Sources::read(&folder("crates/bvhc-core/src"));
    assert!(sources.modules.len() > 40, "{} modules", sources.modules.len());
    let found = breaches(&sources, &rooms_of("core"));
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn no_room_uses_one_above_it() {
    let sources = Sources::read(&folder("src"));
    assert!(sources.modules.len() > 150, "{} modules", sources.modules.len());
    let found = breaches(&sources, &rooms_of("root"));
    assert!(found.is_empty(), "{found:#?}");
}

/// The executor alone knows threads: whoever is given a sequential one starts none.
#[test]
fn only_the_executor_knows_threads() {
    let name = concat!("ray", "on");
    let folders = ["src", "crates/bvhc-core/src", "tests", "examples", "samples", "benches/peers"];
    let mut seen = 0;
    for file in folders.iter().flat_map(|f| sources::files(&folder(f))) {
        let text = std::fs::read_to_string(&file).expect("UTF-8");
        let named = text.lines().any(|line| !line.trim_start().starts_with("//") && line.contains(name));
        let is_executor = file.ends_with("crates/bvhc-core/src/exec.rs");
        assert_eq!(named, is_executor, "{}", file.display());
        seen += 1;
    }
    assert!(seen > 200, "{seen} files");
    let manifest = std::fs::read_to_string(folder("Cargo.toml")).expect("UTF-8");
    assert!(!manifest.lines().any(|line| line.starts_with(name)), "the root crate depends on it past the core");
}

/// The rules are only as good as the eyes: a small crate with every kind of breach.
#[test]
fn breaches_are_seen() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = place.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    let of = |rooms: &[&str]| {
        breaches(&Sources::read(place.path()), &rooms.iter().map(|r| r.to_string()).collect::<Vec<_>>())
    };
    write("lib.rs", "mod low; mod high; pub use high::Thing;");
    write("high/mod.rs", "mod a; mod b; pub use a::Thing;");
    write("high/a.rs", "use crate::low::Low; pub struct Thing(Low);");
    write("high/b.rs", "use super::Thing; pub fn f(_: Thing) {}");
    write("low.rs", "//! [`crate::high`]\npub struct Low;\n#[cfg(test)] mod tests { use crate::high::Thing; }");
    assert_eq!(of(&["low", "high"]), BTreeSet::new());
    assert_eq!(of(&["high", "low"]).len(), 1);
    assert_eq!(of(&["low"]).len(), 1);

    // Upward: by use, by a re-export of the root, by a path in an expression, and in a macro's arguments.
    for text in [
        "use crate::{high::{a::Thing}};",
        "use crate::Thing as Other;",
        "pub fn f() -> usize { size_of::<super::high::Thing>() }",
        "pub fn f() { println!(\"{}\", crate::high::NUMBER); }",
        "#[derive(Serialize)] pub struct A { #[serde(with = \"crate::high::a\")] a: f32 }",
        "#[derive(Error)] pub enum A { #[error(fmt = crate::high::told)] B }",
    ] {
        write("low.rs", &format!("pub struct Low; {text}"));
        assert_eq!(of(&["low", "high"]).iter().filter(|b| b.contains("low lies below high")).count(), 1, "{text}");
    }

    // Forms in which a path upward could not be seen.
    for text in [
        "use crate::*;",
        "use super::*;",
        "use self::super::*;",
        "use crate as top;",
        "use crate::{self as top};",
        "use super as top;",
        "extern crate self as top;",
    ] {
        write("low.rs", &format!("pub struct Low; {text}"));
        let found = of(&["low", "high"]);
        assert_eq!(found.iter().filter(|b| b.starts_with("low takes")).count(), 1, "{text}: {found:?}");
    }

    // In a circle within a folder, through the folder's own re-export.
    write("low.rs", "pub struct Low;");
    write("high/a.rs", "use super::b::f; pub struct Thing;");
    let found = of(&["low", "high"]);
    assert!(found.len() == 1 && found.iter().all(|circle| circle.contains("a -> b -> a")), "{found:?}");
}
