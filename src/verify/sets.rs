use crate::trace::rays::RaySet;

/// The sets by the names that `--rays-from` takes.
pub const SETS: [(&str, RaySet); 7] = [
    ("uniform", RaySet::Chords),
    ("axes", RaySet::AxisAligned),
    ("vertices", RaySet::Vertices),
    ("edges", RaySet::EdgeMidpoints),
    ("surface", RaySet::Surface),
    ("bounce", RaySet::Bounce),
    ("occlusion", RaySet::Occlusion),
];

pub fn set_name(set: RaySet) -> &'static str {
    SETS.iter().find(|(_, s)| *s == set).map_or("", |(name, _)| name)
}

pub fn set_named(name: &str) -> Option<RaySet> {
    SETS.iter().find(|(n, _)| *n == name).map(|(_, set)| *set)
}
