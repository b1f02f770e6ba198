//! Names of the options' values: one table each for printing, parsing and help.

use super::options::{Axes, Clip, HullBasis, Levels, Method, Preset, Purpose};
use super::registry::{METHODS, PRESETS};
use crate::build::error::BuildError;
use std::fmt;
use std::str::FromStr;

/// A closed set of values that users type by name.
pub trait Named: Copy + PartialEq + 'static {
    /// What the set is called in a message.
    const KIND: &'static str;

    /// Every value with its name, in the order in which help lists them.
    fn names() -> Vec<(Self, &'static str)>;

    /// The value's name. `?` for a value that [`Named::names`] leaves out, which is none of this crate's.
    fn name(self) -> &'static str {
        Self::names().into_iter().find(|(value, _)| *value == self).map_or("?", |(_, name)| name)
    }

    /// The value of that name; the error lists the choices and the nearest of them.
    fn parse(text: &str) -> Result<Self, BuildError> {
        let names = Self::names();
        match names.iter().find(|(_, name)| *name == text) {
            Some((value, _)) => Ok(*value),
            None => Err(unknown(Self::KIND, text, &names.iter().map(|(_, name)| *name).collect::<Vec<_>>())),
        }
    }
}

/// What is said of a name that is none of the choices.
pub(super) fn unknown(kind: &'static str, text: &str, choices: &[&str]) -> BuildError {
    let nearest = nearest(text, choices).map(str::to_string);
    BuildError::UnknownName { kind, name: text.to_string(), choices: choices.join(", "), nearest }
}

/// The choice that a word was most likely meant to be.
pub fn nearest<'a>(text: &str, choices: &[&'a str]) -> Option<&'a str> {
    let (distance, name) = choices.iter().map(|name| (edits(text, name), *name)).min()?;
    (distance <= 1 + name.len() / 3).then_some(name)
}

/// How many letters must be put in, taken out or replaced to turn one word into the other (Levenshtein). Long words are
/// cut.
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(32).collect(), b.chars().take(32).collect());
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replace = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

impl Named for Method {
    const KIND: &'static str = "method";
    fn names() -> Vec<(Self, &'static str)> {
        METHODS.iter().map(|row| (row.method, row.name)).collect()
    }
}

impl Named for Axes {
    const KIND: &'static str = "choice of axes";
    fn names() -> Vec<(Self, &'static str)> {
        vec![(Axes::All, "all"), (Axes::Longest, "longest")]
    }
}

impl Named for Clip {
    const KIND: &'static str = "way to clip";
    fn names() -> Vec<(Self, &'static str)> {
        vec![(Clip::Box, "box"), (Clip::Exact, "exact")]
    }
}

impl Named for HullBasis {
    const KIND: &'static str = "choice of basis";
    fn names() -> Vec<(Self, &'static str)> {
        vec![(HullBasis::Leaf, "leaf"), (HullBasis::Fit, "fit")]
    }
}

impl Named for Levels {
    const KIND: &'static str = "number of levels";
    fn names() -> Vec<(Self, &'static str)> {
        vec![(Levels::Auto, "auto"), (Levels::One, "one"), (Levels::Two, "two")]
    }
}

impl Named for Purpose {
    const KIND: &'static str = "purpose of rays";
    fn names() -> Vec<(Self, &'static str)> {
        vec![(Purpose::All, "all"), (Purpose::Camera, "camera"), (Purpose::Bake, "bake"), (Purpose::Physics, "physics")]
    }
}

impl Named for Preset {
    const KIND: &'static str = "preset";
    fn names() -> Vec<(Self, &'static str)> {
        PRESETS.iter().map(|row| (row.preset, row.name)).collect()
    }
}

macro_rules! display_and_parse {
    ($($set:ty),*) => {$(
        impl fmt::Display for $set {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.name())
            }
        }

        impl FromStr for $set {
            type Err = BuildError;

            fn from_str(text: &str) -> Result<Self, BuildError> {
                <$set>::parse(text)
            }
        }
    )*};
}

display_and_parse!(Method, Axes, Clip, HullBasis, Levels, Purpose, Preset);

#[cfg(test)]
mod tests {
    use super::*;

    fn round_trip<T: Named + fmt::Display + FromStr<Err = BuildError> + fmt::Debug>() {
        for (value, name) in T::names() {
            assert_eq!(value.to_string(), name);
            assert_eq!(name.parse::<T>().unwrap(), value);
        }
    }

    #[test]
    fn names_read_back() {
        round_trip::<Method>();
        round_trip::<Axes>();
        round_trip::<Clip>();
        round_trip::<HullBasis>();
        round_trip::<Levels>();
        round_trip::<Purpose>();
        round_trip::<Preset>();
    }

    #[test]
    fn a_near_miss_is_suggested_and_a_far_one_is_not() {
        let nearest = |text: &str| match text.parse::<Method>().unwrap_err() {
            BuildError::UnknownName { nearest, choices, .. } if choices.contains("binned, sbvh") => nearest,
            other => panic!("{other:?}"),
        };
        assert_eq!(nearest("bined").as_deref(), Some("binned"));
        assert_eq!(nearest("sbhv").as_deref(), Some("sbvh"));
        assert_eq!(nearest("octree"), None);
    }

    #[test]
    fn edit_distance() {
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("same", "same"), 0);
    }
}
