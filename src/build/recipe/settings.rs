//! Options as a user types them, put on top of a preset.

use super::names::unknown;
use super::options::{BuildOptions, Method, Preset};
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
                return Err(not_read(ignored, named));
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
        Ok(options)
    }
}

fn not_read(setting: &Setting, method: Method) -> BuildError {
    BuildError::NotRead {
        option: setting.option.name,
        value: setting.value.clone(),
        method: method.info().name,
        readers: setting.option.reader_names().join(", "),
    }
}
