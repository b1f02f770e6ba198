//! Provenance, and the only place that touches bincode.
//!
//! The layout is written out in `format-spec/SPEC.md`, section 6, so that the crate can be replaced without a change of the format:
//! bincode 2.0.1 in its `legacy` configuration writes fixed-width little-endian integers, u64 lengths and no padding.

#[cfg(feature = "meta")]
use super::error::Limited;
use super::keys::{InputHash, Recipe};
use super::report::{Finding, Place};
use super::rules;
#[cfg(feature = "meta")]
use crate::layout::MAX_STRING_LEN;
use crate::layout::SectionKind;
#[cfg(feature = "meta")]
use bincode::config::{self, Config};

/// Most bytes that an encoded META may have.
pub const MAX_META_LEN: usize = 1 << 20;

/// What a file was made from and how: the content of the META section.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Meta {
    /// Name of the writing program.
    pub tool: String,
    /// Version of that program, such as `0.1.0`; the build key does not contain it.
    pub tool_version: String,
    /// Name of the build method.
    pub method: String,
    /// Revision of the method's output; see [`Recipe::builder_revision`].
    pub builder_revision: u32,
    /// See [`Recipe::options`].
    pub options: Vec<(String, String)>,
    /// The files that the tree was made from, in the order of first use, the model first.
    pub dependencies: Vec<Dependency>,
    /// What reading dropped or repaired, by name.
    pub read_counts: Vec<(String, u64)>,
    /// Why the writer chose what it chose, for people.
    pub notes: Vec<String>,
}

/// A file that a tree was made from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Dependency {
    /// [`Dependency::MODEL`] or [`Dependency::BUFFER`].
    pub role: u32,
    /// Relative to the model's folder, parts separated by `/`; of the model itself the file name.
    pub name: String,
    /// Bytes of the file when it was read.
    pub len: u64,
    /// BLAKE3 of the file's bytes when it was read.
    pub blake3: [u8; 32],
}

impl Dependency {
    /// Whether the name leads elsewhere than below the model's folder on some system, which it must not: it starts with `/` or with a drive, a
    /// letter and `:`, or has a `\`, which is a separator on Windows.
    pub fn is_absolute(&self) -> bool {
        let drive = |(drive, _): (&str, &str)| drive.len() == 1 && drive.starts_with(|c: char| c.is_ascii_alphabetic());
        self.name.starts_with('/') || self.name.contains('\\') || self.name.split_once(':').is_some_and(drive)
    }

    /// The model itself.
    pub const MODEL: u32 = 0;
    /// A file that the model names.
    pub const BUFFER: u32 = 1;
}

impl Meta {
    /// How the file was built, as far as the build key knows.
    pub fn recipe(&self) -> Recipe {
        Recipe { method: self.method.clone(), builder_revision: self.builder_revision, options: self.options.clone() }
    }

    /// The build key that follows from this META.
    pub fn build_key(&self) -> [u8; 32] {
        self.recipe().build_key(self.dependencies.iter().map(InputHash::from))
    }

    /// An option or a count that has the name of another, which none may: what it is, and its name.
    pub fn repeated(&self) -> Option<(&'static str, &str)> {
        fn repeated<T>(pairs: &[(String, T)]) -> Option<&str> {
            let mut names: Vec<&str> = pairs.iter().map(|(name, _)| name.as_str()).collect();
            names.sort_unstable();
            names.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
        }
        let option = repeated(&self.options).map(|name| ("option", name));
        option.or_else(|| repeated(&self.read_counts).map(|name| ("count", name)))
    }

    /// The section's bytes.
    ///
    /// # Errors
    /// Where a limit is exceeded.
    #[cfg(feature = "meta")]
    pub fn encode(&self) -> Result<Vec<u8>, Limited> {
        if let Some(long) = self.strings().find(|s| s.len() > MAX_STRING_LEN) {
            return Err(Limited::Format { what: "a string of META", found: long.len(), most: MAX_STRING_LEN });
        }
        let dependencies: Vec<_> = self.dependencies.iter().map(|d| (d.role, &d.name, d.len, d.blake3)).collect();
        let Meta { tool, tool_version, method, builder_revision, options, read_counts, notes, .. } = self;
        let layout = (tool, tool_version, method, builder_revision, options, dependencies, read_counts, notes);
        let too_large = |found| Limited::Format { what: "META", found, most: MAX_META_LEN };
        // Into a vector the encoder refuses nothing but what cannot be held.
        let bytes = bincode::encode_to_vec(layout, encoding()).map_err(|_| too_large(usize::MAX))?;
        if bytes.len() > MAX_META_LEN { Err(too_large(bytes.len())) } else { Ok(bytes) }
    }

    /// Read the one valid encoding: bytes that decode but would be written otherwise are refused.
    #[cfg(feature = "meta")]
    pub(super) fn decode(bytes: &[u8]) -> Result<Meta, Finding> {
        let fault = |expected: &str, actual: String| {
            Finding::new(&rules::E0206, Place::section(SectionKind::META), expected.into(), actual)
        };
        let (layout, consumed): (Layout, usize) = bincode::decode_from_slice(bytes, encoding())
            .map_err(|e| fault("it must follow its layout", format!("it does not: {}", reason(&e))))?;
        if consumed != bytes.len() {
            return Err(fault(&format!("it must end at byte {consumed}"), format!("it has {} bytes", bytes.len())));
        }
        let (tool, tool_version, method, builder_revision, options, dependencies, read_counts, notes) = layout;
        let dependency = |(role, name, len, blake3)| Dependency { role, name, len, blake3 };
        let dependencies = dependencies.into_iter().map(dependency).collect();
        let meta = Meta { tool, tool_version, method, builder_revision, options, dependencies, read_counts, notes };
        if let Some((what, name)) = meta.repeated() {
            return Err(fault(&format!("it must name each {what} once"), format!("it names {name:?} again")));
        }
        match meta.encode() {
            Ok(again) if again == bytes => Ok(meta),
            Ok(_) => Err(fault("it must be in its one encoding", "it is in another".into())),
            Err(limited) => Err(fault("it must keep the limits of its encoding", limited.to_string())),
        }
    }

    /// This build of the crate does not read META.
    #[cfg(not(feature = "meta"))]
    pub(super) fn decode(_bytes: &[u8]) -> Result<Meta, Finding> {
        let known = "the sections that traversal reads, since bvhc-core was built without its feature `meta`";
        Err(Finding::new(&rules::W0101, Place::section(SectionKind::META), known.into(), "META".into()))
    }

    #[cfg(feature = "meta")]
    fn strings(&self) -> impl Iterator<Item = &String> {
        [&self.tool, &self.tool_version, &self.method]
            .into_iter()
            .chain(self.options.iter().flat_map(|(name, value)| [name, value]))
            .chain(self.dependencies.iter().map(|d| &d.name))
            .chain(self.read_counts.iter().map(|(name, _)| name))
            .chain(&self.notes)
    }
}

/// What the section holds, field after field.
#[cfg(feature = "meta")]
type Layout = (
    String,
    String,
    String,
    u32,
    Vec<(String, String)>,
    Vec<(u32, String, u64, [u8; 32])>,
    Vec<(String, u64)>,
    Vec<String>,
);

impl From<&Dependency> for InputHash {
    fn from(d: &Dependency) -> InputHash {
        InputHash { role: d.role, len: d.len, blake3: d.blake3 }
    }
}

/// The limit also bounds what decoding may claim, so no length in the bytes sizes an allocation beyond it.
#[cfg(feature = "meta")]
fn encoding() -> impl Config {
    config::legacy().with_limit::<MAX_META_LEN>()
}

#[cfg(all(test, feature = "meta"))]
mod tests {
    use super::*;

    fn sample() -> Meta {
        let recipe = Recipe { method: "sbvh".into(), builder_revision: 3, options: vec![("bins".into(), "32".into())] };
        let input = Dependency { role: Dependency::MODEL, name: "b.obj".into(), len: 5, blake3: [9; 32] };
        Meta {
            tool: "bvhc".into(),
            tool_version: "1".into(),
            method: recipe.method,
            builder_revision: recipe.builder_revision,
            options: recipe.options,
            dependencies: vec![input],
            read_counts: vec![("x".into(), 7)],
            notes: vec!["why".into()],
        }
    }

    #[test]
    fn layout_is_the_one_of_the_specification() {
        let meta = sample();
        let mut want = Vec::new();
        let string = |out: &mut Vec<u8>, s: &str| {
            out.extend((s.len() as u64).to_le_bytes());
            out.extend(s.as_bytes());
        };
        string(&mut want, "bvhc");
        string(&mut want, "1");
        string(&mut want, "sbvh");
        want.extend(3u32.to_le_bytes());
        want.extend(1u64.to_le_bytes());
        string(&mut want, "bins");
        string(&mut want, "32");
        want.extend(1u64.to_le_bytes());
        want.extend(0u32.to_le_bytes());
        string(&mut want, "b.obj");
        want.extend(5u64.to_le_bytes());
        want.extend([9; 32]);
        want.extend(1u64.to_le_bytes());
        string(&mut want, "x");
        want.extend(7u64.to_le_bytes());
        want.extend(1u64.to_le_bytes());
        string(&mut want, "why");
        assert_eq!(meta.encode().unwrap(), want);
        assert_eq!(Meta::decode(&want).unwrap(), meta);
    }

    #[test]
    fn every_truncation_and_every_appended_byte_is_refused() {
        let bytes = sample().encode().unwrap();
        for len in 0..bytes.len() {
            assert_eq!(Meta::decode(&bytes[..len]).unwrap_err().rule.id, "E0206", "length {len}");
        }
        assert!(Meta::decode(&[&bytes[..], &[0]].concat()).is_err());
    }

    #[test]
    fn absurd_lengths_and_bad_text_are_refused_without_an_allocation() {
        let mut bytes = sample().encode().unwrap();
        bytes[..8].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(Meta::decode(&bytes).is_err());
        let mut bytes = sample().encode().unwrap();
        bytes[8] = 0xff; // the first letter of the tool's name
        assert!(Meta::decode(&bytes).is_err());
        assert!(Meta { notes: vec!["x".repeat(MAX_STRING_LEN + 1)], ..sample() }.encode().is_err());
        assert!(Meta { notes: vec!["x".repeat(4000); 300], ..sample() }.encode().is_err());
    }
}

/// What bincode found, in words: its own texts are those of a debugger.
#[cfg(feature = "meta")]
fn reason(error: &bincode::error::DecodeError) -> &'static str {
    use bincode::error::DecodeError;
    match error {
        DecodeError::Utf8 { .. } => "a text in it is not UTF-8",
        DecodeError::UnexpectedEnd { .. } => "it ends too early",
        DecodeError::LimitExceeded => "it would take more memory than it may",
        _ => "its bytes are none that a writer makes",
    }
}
