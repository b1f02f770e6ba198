//! Which extensions a glTF file has, wherever they stand.

use super::extensions;
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::collections::BTreeSet;
use std::fmt;

/// The names of the extensions in a JSON document that [may place triangles](extensions::may_place), from its root down to nodes, accessors
/// and primitives. What stands in `extras` is the application's own. Of a document that ends early, those up to there.
pub(super) fn placing_extensions(json: &[u8]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    // Most documents have none, and this is many times faster than going through the text's structure.
    const KEY: &[u8] = b"extensions\"";
    if !json.windows(KEY.len()).any(|text| text == KEY) {
        return found;
    }
    let search = Search { found: &mut found, in_extensions: false };
    // Whoever reads the document says what is wrong with it.
    let _ = search.deserialize(&mut serde_json::Deserializer::from_slice(json));
    found
}

/// Looks into one value and all that it holds; extensions may be nested.
struct Search<'f> {
    found: &'f mut BTreeSet<String>,
    /// The value is an `extensions` object, whose keys are names.
    in_extensions: bool,
}

impl<'de> DeserializeSeed<'de> for Search<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Search<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("any value")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            if !self.in_extensions && key == "extras" {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let in_extensions = !self.in_extensions && key == "extensions";
            map.next_value_seed(Search { found: self.found, in_extensions })?;
            if self.in_extensions && extensions::may_place(&key) {
                self.found.insert(key);
            }
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        while seq.next_element_seed(Search { found: self.found, in_extensions: false })?.is_some() {}
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }
}
