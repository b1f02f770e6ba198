//! The catalogue of everything that a cache file can be found guilty of.
//!
//! A [`Rule`] has a number that never changes its meaning, a name, a severity, a headline, a template for the detail line,
//! the place in `format-spec/SPEC.md` that demands it, and three answers for people: what it means, how it happens, what to
//! do, which is a [`Remedy`] and leaves the words to the program. The checker ([`super::check`]) only *uses* rules. For each rule one file in `format-spec/vectors/invalid` breaks
//! it and nothing else; `tests/mutation` sees to that.
//!
//! | numbers | about | asked at level |
//! |---|---|---|
//! | `E01xx` | container: header, section table, tiling | quick |
//! | `E02xx` | hashes and decompression | hash |
//! | `E03xx` | counts that must agree with each other | tree |
//! | `E04xx` | trees, boxes and triangles | tree |
//! | `E05xx` | instances | tree |
//! | `E06xx` | agreement with the source model | source |
//! | `E07xx` | files of many frames | tree |
//!
//! `Wxxxx` are warnings: legal, traversable, yet not what this tool writes.

mod container;
mod counts;
mod hashes;
mod instances;
mod remedy;
mod sequence;
mod source;
mod trees;

pub use container::*;
pub use counts::*;
pub use hashes::*;
pub use instances::*;
pub use remedy::Remedy;
pub use sequence::*;
pub use source::*;
pub use trees::*;

/// Whether a finding makes a file invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Severity {
    /// The file is invalid: a reader may refuse it, and what is traced in it may be wrong.
    Error,
    /// The file is valid and can be traced, yet is not what this library's writer makes.
    Warning,
}

/// One thing that must hold of a cache file.
#[derive(Debug)]
#[non_exhaustive]
pub struct Rule {
    /// `E` or `W` and four digits. A number keeps its meaning for ever and is never given to another rule.
    pub id: &'static str,
    /// The number for people: kebab-case, unique.
    pub name: &'static str,
    /// What is wrong, in one line without figures.
    pub headline: &'static str,
    /// The line with figures: `{expected}` and `{actual}` are filled in by the checker.
    pub detail: &'static str,
    /// Heading of `format-spec/SPEC.md` that demands it, as a link anchor.
    pub spec: &'static str,
    /// What it means for somebody who holds such a file.
    pub meaning: &'static str,
    /// How a file comes to be like this.
    pub cause: &'static str,
    /// What to do about it.
    pub remedy: Remedy,
}

impl PartialEq for Rule {
    fn eq(&self, other: &Rule) -> bool {
        self.id == other.id
    }
}

impl Eq for Rule {}

impl Rule {
    /// Told by the first letter of the number, so the two cannot disagree.
    pub fn severity(&self) -> Severity {
        if self.id.starts_with('E') { Severity::Error } else { Severity::Warning }
    }

    /// The detail line for these two values.
    pub fn describe(&self, expected: &str, actual: &str) -> String {
        self.detail.replace("{expected}", expected).replace("{actual}", actual)
    }

    /// The committed file that breaks this rule, relative to the repository, with `/`.
    pub fn vector(&self) -> String {
        format!("format-spec/vectors/invalid/{}-{}.bvhc", self.id, self.name)
    }

    /// Whether a file with this finding is of a kind that this version cannot read, rather than broken.
    pub fn is_unsupported(&self) -> bool {
        ["E0103", "E0104", "E0107", "E0113", "E0114", "E0115", "E0128"].contains(&self.id)
    }
}

/// Every rule in the order of its number, warnings behind the errors of their hundred.
pub fn all() -> impl Iterator<Item = &'static Rule> {
    [container::ALL, hashes::ALL, counts::ALL, trees::ALL, instances::ALL, source::ALL, sequence::ALL]
        .into_iter()
        .flatten()
        .copied()
}

/// The rule with this number (in any case) or this name.
pub fn find(id_or_name: &str) -> Option<&'static Rule> {
    all().find(|r| r.id.eq_ignore_ascii_case(id_or_name) || r.name == id_or_name)
}

/// The cause of what no damage to a hashed file can bring about.
const FOREIGN_WRITER: &str = "Hashes are not signatures: a writer that is wrong, or somebody who means harm, can hash anything. Damage in storage is found by its hash before this rule is asked.";

/// Write one `static` for each rule and the list `ALL` of them.
macro_rules! rules {
    ($($id:ident $name:literal, $headline:literal, $detail:literal, $spec:literal,
        means $meaning:literal, because $cause:expr, remedy $remedy:ident;)*) => {
        $(
            #[doc = concat!("`", $name, "`: ", $headline, ".")]
            pub static $id: super::Rule = super::Rule {
                id: stringify!($id), name: $name, headline: $headline, detail: $detail, spec: $spec,
                meaning: $meaning, cause: $cause, remedy: super::Remedy::$remedy,
            };
        )*
        pub(super) static ALL: &[&super::Rule] = &[$(&$id),*];
    };
}
use rules;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_ascend_and_names_are_unique() {
        let numbers: Vec<String> = all().map(|r| r.id[1..].to_string() + &r.id[..1]).collect();
        assert!(
            numbers.is_sorted_by(|a, b| a[..2] < b[..2] || (a[..2] == b[..2] && (a[4..] < b[4..] || a < b))),
            "{numbers:?}"
        );
        let mut names: Vec<&str> = all().map(|r| r.name).collect();
        names.sort_unstable();
        assert!(names.is_sorted_by(|a, b| a < b), "a name is used twice: {names:?}");
    }

    #[test]
    fn texts_are_whole_sentences_and_details_carry_both_values() {
        for r in all() {
            assert!(r.id.len() == 5 && (r.id.starts_with('E') || r.id.starts_with('W')), "{}", r.id);
            assert!(r.name.bytes().all(|b| b.is_ascii_lowercase() || b == b'-' || b.is_ascii_digit()), "{}", r.name);
            assert!(r.detail.contains("{expected}") && r.detail.contains("{actual}"), "{}: {}", r.id, r.detail);
            for text in [r.meaning, r.cause, &r.remedy.to_string()] {
                assert!(text.ends_with('.') && text.len() > 20, "{}: {text}", r.id);
            }
            assert!(!r.headline.ends_with('.'), "{}", r.id);
            assert_eq!(find(&r.id.to_lowercase()), Some(r));
            assert_eq!(find(r.name), Some(r));
        }
        assert!(find("E9999").is_none());
    }

    /// Which commands and flags there are is the program's to say.
    #[test]
    fn texts_name_no_command_and_no_flag() {
        let commands = ["build", "check", "convert", "explain", "info", "stats", "verify"].map(|c| format!("bvhc {c}"));
        let plain = |text: &str| !text.contains("--") && commands.iter().all(|c| !text.contains(c));
        for r in all() {
            for text in [r.headline, r.detail, r.meaning, r.cause] {
                assert!(plain(text), "{}: {text}", r.id);
            }
        }
        for remedy in Remedy::ALL {
            assert!(plain(&remedy.to_string()), "{remedy}");
        }
        assert!(!plain("see bvhc check FILE") && !plain("add --force"));
    }

    #[test]
    #[cfg_attr(target_family = "wasm", ignore = "there are no files")]
    fn every_anchor_is_a_heading_of_the_specification() {
        let spec = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../format-spec/SPEC.md")).unwrap();
        let slug = |heading: &str| -> String {
            let kept = heading.trim().to_lowercase();
            kept.chars()
                .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
                .map(|c| if c == ' ' { '-' } else { c })
                .collect()
        };
        let headings: Vec<String> =
            spec.lines().filter(|l| l.starts_with('#')).map(|l| slug(l.trim_start_matches('#'))).collect();
        for r in all() {
            assert!(headings.iter().any(|h| h == r.spec), "{}: SPEC.md has no heading #{}", r.id, r.spec);
        }
    }
}
