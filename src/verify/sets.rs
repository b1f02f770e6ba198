use crate::trace::rays::RaySet;

/// The sets by the names that `--rays-from` takes.
pub const SETS: [(&str, RaySet); RaySet::ALL.len()] = {
    let mut table = [("", RaySet::Uniform); RaySet::ALL.len()];
    let mut i = 0;
    while i < table.len() {
        table[i] = (RaySet::ALL[i].name(), RaySet::ALL[i]);
        i += 1;
    }
    table
};

/// What `--rays-from` calls the set.
#[cfg(feature = "cli")]
pub fn set_name(set: RaySet) -> &'static str {
    set.name()
}

/// The set that `--rays-from` calls so.
#[cfg(feature = "cli")]
pub fn set_named(name: &str) -> Option<RaySet> {
    SETS.iter().find(|(n, _)| *n == name).map(|(_, set)| *set)
}
