//! What there is to say about an option: the columns of the table.

use super::options::{BuildOptions, Method, Preset};
use super::registry::METHODS;
use super::value::OptionValue;
use crate::build::error::BuildError;

/// A row of [`OPTIONS`](super::table::OPTIONS): all that parsing, help, documentation, META and the build key know about an option.
#[derive(Debug)]
pub struct OptionInfo {
    /// What users type and META names, such as `spatial-bins`.
    pub name: &'static str,
    /// Stands for the value in help, such as `N`.
    pub placeholder: &'static str,
    /// What values it takes.
    pub kind: Kind,
    pub(crate) readers: Readers,
    pub(crate) key: InKey,
    /// Whether it has a flag of its own.
    pub spelling: Spelling,
    /// One line without a full stop.
    pub help: &'static str,
    /// Further sentences: what it is good for, what the ends of its range mean.
    pub details: &'static str,
    pub(super) write: fn(&BuildOptions) -> String,
    /// False if the text is no value of the field's type; the field then keeps its own.
    pub(super) read: fn(&mut BuildOptions, &str) -> bool,
    pub(super) fits: fn(&BuildOptions, &Kind) -> bool,
}

/// The values that an option takes. Ranges include their ends.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Kind {
    /// A whole number from the first to the second.
    Count(u32, u32),
    /// A number from the first to the second; NaN is none.
    Real(f32, f32),
    /// `true` or `false`.
    Switch,
    /// One of these names.
    Choice(fn() -> Vec<&'static str>),
}

/// The methods whose trees depend on an option.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Readers {
    /// All of [`METHODS`].
    Every,
    /// Every method that is no search: what cuts before a build or improves its tree, which a search decides about itself.
    AllButSearches,
    /// Searches, and every other method where it adapts its tree to rays.
    WhereRaysDecide,
    /// These.
    Only(&'static [Method]),
}

/// When the build key and META name an option that the method reads. What does not change the output is no option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InKey {
    /// Wherever the method reads it.
    Always,
    /// Not where its value is 0 or false. A recipe without the step stays what it was before there was such a step.
    UnlessOff,
    /// Not where its value is the usual one, which is what builds did before there was such an option.
    UnlessUsual,
}

/// How the command line spells an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Spelling {
    /// `--name value`, and `-O name=value` as well.
    Flag,
    /// `-O name=value` alone: no preset, search or lesson turns it, and the file is of the same kind whatever it is.
    Setting,
}

/// The names of the methods that try several recipes.
fn searches() -> Vec<&'static str> {
    METHODS.iter().filter(|row| row.method.is_search()).map(|row| row.name).collect()
}

impl OptionInfo {
    /// Whether trees of this method depend on the option.
    pub fn is_read_by(&self, method: Method) -> bool {
        match self.readers {
            Readers::Every | Readers::WhereRaysDecide => true,
            Readers::AllButSearches => !method.is_search(),
            Readers::Only(methods) => methods.contains(&method),
        }
    }

    /// Whether the trees of these options depend on the option: the method reads it, and what else it is about is done.
    pub fn is_read_in(&self, options: &BuildOptions) -> bool {
        let decides =
            !matches!(self.readers, Readers::WhereRaysDecide) || options.method.is_search() || options.adapt > 0;
        decides && self.is_read_by(options.method)
    }

    /// The names of the methods that read it, in the order of [`METHODS`].
    pub(crate) fn reader_names(&self) -> Vec<&'static str> {
        METHODS.iter().filter(|row| self.is_read_by(row.method)).map(|row| row.name).collect()
    }

    /// The methods that read it, in words.
    pub fn readers_in_words(&self) -> String {
        match self.readers {
            Readers::Every => "every method".to_string(),
            Readers::AllButSearches => format!("every method but {}", searches().join(" and ")),
            Readers::WhereRaysDecide => format!("{}, and every other method with adapt", searches().join(" and ")),
            Readers::Only(_) => self.reader_names().join(", "),
        }
    }

    /// The value in these options, as text that two different values never share: floats in the shortest form that reads back
    /// to the same bits.
    pub fn value(&self, options: &BuildOptions) -> String {
        (self.write)(options)
    }

    /// The value in a preset.
    pub fn default_in(&self, preset: Preset) -> String {
        self.value(&BuildOptions::preset(preset))
    }

    /// Whether a build can honour the value in these options.
    pub fn is_valid(&self, options: &BuildOptions) -> bool {
        (self.fits)(options, &self.kind)
    }

    /// The value that text stands for, in its shortest form.
    ///
    /// # Errors
    /// The rule that the text breaks, as [`Kind::rule`] puts it.
    pub fn parse(&self, text: &str) -> Result<String, String> {
        let mut options = BuildOptions::default();
        if (self.read)(&mut options, text) && self.is_valid(&options) {
            return Ok(self.value(&options));
        }
        Err(self.kind.rule())
    }

    /// Put a value into the options.
    ///
    /// # Errors
    /// [`BuildError::Option`] if the text is no value of this option. The options are then as they were.
    pub fn set(&self, options: &mut BuildOptions, text: &str) -> Result<(), BuildError> {
        let value = self.parse(text).map_err(|_| self.refusal(text.to_string()))?;
        (self.read)(options, &value);
        Ok(())
    }

    /// What is said of a value that is none of this option's.
    pub(super) fn refusal(&self, value: String) -> BuildError {
        let (option, rule) = (self.name, self.kind.rule());
        BuildError::Option { option, value, rule, default: Some(self.default_in(Preset::Auto).to_string()) }
    }

    /// What is said of a value that the method would ignore.
    pub(super) fn not_read(&self, value: &str, method: Method) -> BuildError {
        BuildError::NotRead {
            option: self.name,
            value: value.to_string(),
            method: method.info().name,
            readers: match self.readers {
                Readers::WhereRaysDecide => self.readers_in_words(),
                _ => self.reader_names().join(", "),
            },
        }
    }

    /// Whether the build key names this option of these options, which the method must read.
    pub(super) fn is_named(&self, options: &BuildOptions) -> bool {
        match self.key {
            InKey::Always => true,
            InKey::UnlessOff => !["0", "false"].contains(&self.value(options).as_str()),
            InKey::UnlessUsual => self.value(options) != self.default_in(Preset::Auto),
        }
    }
}

impl Kind {
    /// The values in words: `2 to 256`, `all, longest`.
    pub fn range(&self) -> String {
        match *self {
            Kind::Count(least, most) => format!("{least} to {most}"),
            Kind::Real(least, most) => format!("{} to {}", least.write(), most.write()),
            Kind::Switch => "true, false".to_string(),
            Kind::Choice(names) => names().join(", "),
        }
    }

    /// The rule that a value has to obey, for a message.
    pub fn rule(&self) -> String {
        match *self {
            Kind::Count(least, most) => format!("it must be a whole number between {least} and {most}"),
            Kind::Real(least, most) => format!("it must be between {} and {}", least.write(), most.write()),
            Kind::Switch => "it must be true or false".to_string(),
            Kind::Choice(names) => format!("it must be one of {}", names().join(", ")),
        }
    }
}
