/// When the tree of a mesh that moved is built anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefitPolicy {
    /// Whether trees are refitted at all.
    pub refit: Refit,
    /// A tree is built anew where refitting has raised its SAH cost to more than so many times what it was when it was built.
    pub rebuild_ratio: f32,
}

/// Whether trees are refitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
        RefitPolicy { refit: Refit::Auto, rebuild_ratio: RefitPolicy::REBUILD_RATIO }
    }
}

impl RefitPolicy {
    /// The default of [`RefitPolicy::rebuild_ratio`].
    pub const REBUILD_RATIO: f32 = 1.2;
    /// A tree that was built anew must be so much cheaper than the refitted one, or that is kept: what a mesh costs in a pose is not always the
    /// refit's fault.
    pub(super) const WORTHWHILE: f32 = 0.97;
    /// A tree that was not worth building anew is not tried again before its cost has grown by this factor.
    pub(super) const PATIENCE: f32 = 1.05;

    /// Whether a tree that costs so many times what it did is due to be built anew.
    pub(super) fn is_dear(&self, ratio: f32, borne: f32) -> bool {
        match self.refit {
            Refit::Never => true,
            Refit::Always => false,
            Refit::Auto => !(ratio <= self.rebuild_ratio.max(borne)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ratio_decides_and_what_was_borne_is_borne_again() {
        let policy = RefitPolicy { rebuild_ratio: 1.2, ..RefitPolicy::default() };
        assert!(!policy.is_dear(1.2, 0.0) && policy.is_dear(1.21, 0.0) && !policy.is_dear(1.3, 1.31));
        assert!(policy.is_dear(f32::NAN, 0.0));
        assert!(RefitPolicy { refit: Refit::Never, ..policy }.is_dear(1.0, 9.0));
        assert!(!RefitPolicy { refit: Refit::Always, ..policy }.is_dear(100.0, 0.0));
    }
}
