use std::num::NonZeroU32;

/// When the tree of a mesh that moved is built anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefitPolicy {
    /// Whether trees are refitted at all.
    pub refit: Refit,
    /// A tree is built anew where refitting has raised its SAH cost to more than so many times what it was when it was built.
    pub rebuild_ratio: f32,
    /// A tree is built anew after so many poses, whatever it costs, and no earlier one is taken again: what comes then needs no tree of before. `None`: never.
    pub keyframe_every: Option<NonZeroU32>,
}

/// Whether trees are refitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refit {
    /// As long as [`RefitPolicy::rebuild_ratio`] allows.
    #[default]
    Auto,
    /// Each frame's trees are built.
    Never,
    /// As long as the triangles are the same.
    Always,
}

impl Default for RefitPolicy {
    fn default() -> RefitPolicy {
        RefitPolicy { refit: Refit::Auto, rebuild_ratio: RefitPolicy::REBUILD_RATIO, keyframe_every: None }
    }
}

impl RefitPolicy {
    /// The default of [`RefitPolicy::rebuild_ratio`].
    pub const REBUILD_RATIO: f32 = 1.2;
}
