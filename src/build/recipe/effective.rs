//! What of the options decides a build.

use super::names::Named;
use super::options::{BuildOptions, Method};
use super::row::InKey;
use super::table::OPTIONS;
use crate::build::error::BuildError;

impl BuildOptions {
    /// The options that decide this build's output, as names and values in the order of the table: what META shows and the
    /// build key hashes, beside the method's name and revision.
    ///
    /// Those that the method does not read are left out. What is not done, a pass or cutting, is not named either.
    pub fn effective(&self) -> Vec<(String, String)> {
        let decisive = OPTIONS.iter().filter(|row| row.is_read_in(self) && row.is_named(self));
        decisive.map(|row| (row.name.to_string(), row.value(self))).collect()
    }

    /// The options that META names, read back: what a step is not named for is not done. Names that are no option are passed over, since META has
    /// those of reading too.
    ///
    /// # Errors
    /// [`BuildError::UnknownName`] for a method that is none, [`BuildError::Option`] for a value that its option does not take.
    pub fn recorded(method: &str, options: &[(String, String)]) -> Result<BuildOptions, BuildError> {
        let method = Method::parse(method)?;
        let mut read = BuildOptions { method, ..BuildOptions::default() };
        for row in OPTIONS.iter().filter(|row| row.is_read_by(method)) {
            match options.iter().find(|(name, _)| name == row.name) {
                Some((_, value)) => row.set(&mut read, value)?,
                None if row.key == InKey::UnlessOff => {
                    _ = row.set(&mut read, "0").or_else(|_| row.set(&mut read, "false"));
                }
                None => {}
            }
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::recipe::options::{Axes, Preset};
    use crate::build::recipe::registry::METHODS;

    #[test]
    fn what_is_recorded_is_read_back() {
        let presets = [Preset::Auto, Preset::Draft, Preset::Balanced, Preset::Best].map(BuildOptions::preset);
        let changed = BuildOptions {
            axes: Axes::Longest,
            reinsert: 3,
            presplit: 0.25,
            adapt: 2,
            max_leaf: 3,
            ..BuildOptions::default()
        };
        for base in presets.into_iter().chain([changed]) {
            for row in METHODS {
                let options = BuildOptions { method: row.method, ..base.clone() };
                let mut recorded = options.effective();
                recorded.push(("degenerate".into(), "keep".into()));
                let read = BuildOptions::recorded(row.name, &recorded).unwrap();
                assert_eq!((read.method, read.effective()), (row.method, options.effective()), "{}", row.name);
            }
        }
        assert!(matches!(BuildOptions::recorded("none", &[]), Err(BuildError::UnknownName { .. })));
        let bad = [("max-leaf".into(), "0".into())];
        assert!(matches!(BuildOptions::recorded("sweep", &bad), Err(BuildError::Option { option: "max-leaf", .. })));
    }
}
