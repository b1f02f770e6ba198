//! What of the options decides a build.

use super::options::BuildOptions;
use super::table::OPTIONS;

impl BuildOptions {
    /// The options that decide this build's output, as names and values in the order of the table: what META shows and the
    /// build key hashes, beside the method's name and revision.
    ///
    /// Those that the method does not read are left out. What is not done, a pass or cutting, is not named either.
    pub fn effective(&self) -> Vec<(String, String)> {
        let decisive = OPTIONS.iter().filter(|row| row.is_read_by(self.method) && row.is_named(self));
        decisive.map(|row| (row.name.to_string(), row.value(self))).collect()
    }
}
