use serde::de::{self, Deserialize, Deserializer, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// A whole number of the JSON. It may be written as `100`, `100.0` or `1e2` (glTF 2.0, 2.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Whole<T>(pub T);

/// The number of an object in one of the document's lists.
pub(super) type Index = Whole<u32>;

impl<'de, T: TryFrom<u64>> Deserialize<'de> for Whole<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(WholeVisitor(PhantomData))
    }
}

struct WholeVisitor<T>(PhantomData<T>);

impl<T: TryFrom<u64>> Visitor<'_> for WholeVisitor<T> {
    type Value = Whole<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a whole number from 0 to 2^{} - 1", 8 * size_of::<T>())
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Whole<T>, E> {
        T::try_from(value).map(Whole).map_err(|_| E::invalid_value(de::Unexpected::Unsigned(value), &self))
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Whole<T>, E> {
        let is_whole = value.fract() == 0.0 && (0.0..2f64.powi(64)).contains(&value);
        if is_whole { self.visit_u64(value as u64) } else { Err(E::invalid_value(de::Unexpected::Float(value), &self)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_may_be_written_as_decimals() {
        for text in ["100", "100.0", "1e2", "1.0E+2", "10000e-2"] {
            assert_eq!(serde_json::from_str::<Index>(text).unwrap(), Whole(100), "{text}");
        }
        assert_eq!(serde_json::from_str::<Whole<u64>>("18446744073709551615").unwrap().0, u64::MAX);
        assert_eq!(serde_json::from_str::<Index>("-0.0").unwrap().0, 0);
        for text in ["-1", "0.5", "4294967296", "4294967296.0", "1e300", "-1.0", "\"1\"", "null", "[1]"] {
            assert!(serde_json::from_str::<Index>(text).is_err(), "{text}");
        }
    }
}
