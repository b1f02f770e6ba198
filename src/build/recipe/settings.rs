//! Options as a user gives them, and none ignored in silence: typed on top of a preset, or as the fields of [`BuildOptions`].

use super::names::unknown;
use super::options::{BuildOptions, Method, Preset};
use super::registry::PRESETS;
use super::row::OptionInfo;
use super::table::{OPTIONS, option};
use crate::build::error::BuildError;

/// A valid value for one option.
#[derive(Clone, Debug)]
pub struct Setting {
    option: &'static OptionInfo,
    value: String,
}

impl Setting {
    /// # Errors
    /// [`BuildError::UnknownName`] if there is no such option, [`BuildError::Option`] if it does not take the value.
    pub fn new(name: &str, value: &str) -> Result<Setting, BuildError> {
        let Some(option) = option(name) else {
            return Err(unknown("option", name, &OPTIONS.iter().map(|row| row.name).collect::<Vec<_>>()));
        };
        match option.parse(value) {
            Ok(value) => Ok(Setting { option, value }),
            Err(_) => Err(option.refusal(value.to_string())),
        }
    }

    /// The row of the option that is set.
    pub fn option(&self) -> &'static OptionInfo {
        self.option
    }

    /// The value in its shortest form.
    pub fn value(&self) -> &str {
        &self.value
    }
}

impl BuildOptions {
    /// A preset, another method if one is named, and settings on top.
    ///
    /// A search reads few options, since it decides about the others itself. Where no method is named and the preset's is a search that
    /// does not read every setting, the settings are taken for a recipe of their own, and the method is [`Method::Sbvh`].
    ///
    /// # Errors
    /// [`BuildError::NotRead`] for a setting that the method does not read, so that none is ignored in silence;
    /// [`BuildError::Option`] for an option that is set twice.
    pub fn with_settings(
        preset: Preset,
        method: Option<Method>,
        settings: &[Setting],
    ) -> Result<BuildOptions, BuildError> {
        let mut options = BuildOptions::preset(preset);
        let ignored_by = |method| settings.iter().find(|setting| !setting.option.is_read_by(method));
        let named = method.unwrap_or(options.method);
        options.method = named;
        if let Some(ignored) = ignored_by(named) {
            // No method was named, so one may be chosen; if it ignores something too, what was asked for is to blame.
            let may_choose = method.is_none() && named.is_search();
            if let Some(ignored) = if may_choose { ignored_by(Method::Sbvh) } else { Some(ignored) } {
                return Err(ignored.option.not_read(&ignored.value, named));
            }
            options.method = Method::Sbvh;
        }

        for (i, setting) in settings.iter().enumerate() {
            if let Some(earlier) = settings[..i].iter().find(|earlier| earlier.option.name == setting.option.name) {
                return Err(BuildError::Option {
                    option: setting.option.name,
                    value: setting.value.clone(),
                    rule: format!("it is set to {} already", earlier.value),
                    default: None,
                });
            }
            setting.option.set(&mut options, &setting.value)?;
        }
        match settings.iter().find(|setting| !setting.option.is_read_in(&options)) {
            Some(ignored) => Err(ignored.option.not_read(&ignored.value, options.method)),
            None => Ok(options),
        }
    }

    /// Refuse a value that the method does not read, so that none is ignored in silence.
    ///
    /// A field has some value always. One that a preset has may have come with the others of that preset and passes; any other was put there
    /// to do something.
    ///
    /// # Errors
    /// [`BuildError::NotRead`] with the first such option.
    pub fn refuse_unread(&self) -> Result<(), BuildError> {
        for row in OPTIONS.iter().filter(|row| !row.is_read_in(self)) {
            let value = row.value(self);
            if PRESETS.iter().all(|known| row.default_in(known.preset) != value) {
                return Err(row.not_read(&value, self.method));
            }
        }
        Ok(())
    }
}
