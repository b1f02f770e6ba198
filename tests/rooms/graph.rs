//! From paths to modules that use each other.

use super::sources::{Name, Sources};
use std::collections::{BTreeMap, BTreeSet};

/// Which module uses which, and the path by which it does. A module's own items and what its folder's own file holds are no use.
pub fn uses(sources: &Sources) -> BTreeSet<(Name, Name, String)> {
    let mut found = BTreeSet::new();
    for (from, module) in &sources.modules {
        for path in &module.paths {
            let Some(to) = absolute(sources, from, path).and_then(|path| origin(sources, path)) else { continue };
            if to != *from {
                found.insert((from.clone(), to, path.join("::")));
            }
        }
    }
    found
}

/// A path from the crate's root; `None` for one that leads into another crate.
fn absolute(sources: &Sources, from: &Name, path: &[String]) -> Option<Name> {
    let (first, rest) = path.split_first()?;
    let (mut base, mut rest) = (from.clone(), rest);
    match first.as_str() {
        "crate" => base.clear(),
        "self" => {}
        "super" => {
            base.pop();
            while let [next, after @ ..] = rest
                && next == "super"
            {
                base.pop();
                rest = after;
            }
        }
        child => {
            base.push(child.to_string());
            if !sources.modules.contains_key(&base) {
                return None;
            }
        }
    }
    base.extend_from_slice(rest);
    Some(base)
}

/// The module that holds what a path names, re-exports followed; `None` where they lead into another crate.
fn origin(sources: &Sources, mut path: Name) -> Option<Name> {
    // Longer chains than this there are none.
    for _ in 0..16 {
        let known = (0..=path.len()).rev().find(|n| sources.modules.contains_key(&path[..*n]))?;
        let (module, rest) = (path[..known].to_vec(), path[known..].to_vec());
        let Some(next) = rest.first() else { return Some(module) };
        let Some(stands_for) = sources.modules[&module].reexports.get(next) else { return Some(module) };
        path = absolute(sources, &module, stands_for)?;
        path.extend_from_slice(&rest[1..]);
    }
    None
}

/// In every folder: modules that use each other, directly or through others in the folder. One circle for each module in one.
pub fn circles(sources: &Sources) -> Vec<String> {
    // By folder: which of its members uses which other.
    let mut folders: BTreeMap<Name, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for (from, to, _) in uses(sources) {
        let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
        if let (Some(a), Some(b)) = (from.get(common), to.get(common)) {
            folders.entry(from[..common].to_vec()).or_default().entry(a.clone()).or_default().insert(b.clone());
        }
    }
    let mut found = BTreeSet::new();
    for (folder, members) in &folders {
        for start in members.keys() {
            if let Some(way) = way_back(members, start) {
                // Named once, from its first member on.
                if way.iter().min() == Some(start) {
                    found.insert(format!("{}: {}", folder.join("::"), way.join(" -> ")));
                }
            }
        }
    }
    found.into_iter().collect()
}

/// The shortest way from a member to itself.
fn way_back(members: &BTreeMap<String, BTreeSet<String>>, start: &String) -> Option<Vec<String>> {
    let mut ways = vec![vec![start.clone()]];
    let mut seen = BTreeSet::new();
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in ways {
            for next in way.last().and_then(|last| members.get(last)).into_iter().flatten() {
                let longer_way = [way.as_slice(), std::slice::from_ref(next)].concat();
                if next == start {
                    return Some(longer_way);
                }
                if seen.insert(next.clone()) {
                    longer.push(longer_way);
                }
            }
        }
        ways = longer;
    }
    None
}
