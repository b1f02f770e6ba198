use crate::trace::rays::RaySet;

/// The sets by their names.
pub const SETS: [(&str, RaySet); RaySet::ALL.len()] = {
    let mut table = [("", RaySet::Uniform); RaySet::ALL.len()];
    let mut i = 0;
    while i < table.len() {
        table[i] = (RaySet::ALL[i].name(), RaySet::ALL[i]);
        i += 1;
    }
    table
};

/// The name of a set.
#[cfg(feature = "cli")]
pub fn set_name(set: RaySet) -> &'static str {
    set.name()
}

/// The set of this name.
#[cfg(feature = "cli")]
pub fn set_named(name: &str) -> Option<RaySet> {
    SETS.iter().find(|(n, _)| *n == name).map(|(_, set)| *set)
}
