//! The types that an option's value can have, and their text.

use super::names::Named;
use super::options::{Axes, Clip, HullBasis, Levels, Purpose};
use super::row::Kind;

/// A type of values that stand in [`BuildOptions`](super::options::BuildOptions).
pub(super) trait OptionValue: Copy {
    fn write(self) -> String;
    fn read(text: &str) -> Option<Self>;
    /// False too if the kind is one of another type.
    fn fits(self, kind: &Kind) -> bool;
}

impl OptionValue for u32 {
    fn write(self) -> String {
        self.to_string()
    }

    fn read(text: &str) -> Option<u32> {
        text.parse().ok()
    }

    fn fits(self, kind: &Kind) -> bool {
        matches!(*kind, Kind::Count(least, most) if (least..=most).contains(&self))
    }
}

impl OptionValue for f32 {
    fn write(self) -> String {
        // Adding zero turns -0 into +0: they mean the same.
        (self + 0.0).to_string()
    }

    fn read(text: &str) -> Option<f32> {
        text.parse().ok()
    }

    fn fits(self, kind: &Kind) -> bool {
        matches!(*kind, Kind::Real(least, most) if (least..=most).contains(&self))
    }
}

impl OptionValue for bool {
    fn write(self) -> String {
        self.to_string()
    }

    fn read(text: &str) -> Option<bool> {
        text.parse().ok()
    }

    fn fits(self, kind: &Kind) -> bool {
        matches!(kind, Kind::Switch)
    }
}

/// The names of a closed set, for [`Kind::Choice`].
pub(super) fn names_of<T: Named>() -> Vec<&'static str> {
    T::names().into_iter().map(|(_, name)| name).collect()
}

macro_rules! choices {
    ($($set:ty),*) => {$(
        impl OptionValue for $set {
            fn write(self) -> String {
                self.name().to_string()
            }

            fn read(text: &str) -> Option<$set> {
                <$set>::parse(text).ok()
            }

            fn fits(self, kind: &Kind) -> bool {
                matches!(kind, Kind::Choice(names) if names().contains(&self.name()))
            }
        }
    )*};
}

choices!(Axes, Clip, HullBasis, Levels, Purpose);
