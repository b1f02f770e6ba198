//! Numbers of bytes as people read them: one way for both crates and the program.
//!
//! Memory and files are told in binary units, as limits of memory are typed. What a rule of the format holds against another number is told in
//! bytes, and so are numbers in JSON.

use std::fmt;

/// A number of bytes, printed as `640 bytes`, `5.1 MiB`, `402 MiB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bytes(pub u128);

const UNITS: [&str; 6] = ["KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];

/// So many bytes, to be printed.
pub fn bytes(count: impl Into<u128>) -> Bytes {
    Bytes(count.into())
}

/// The texts of a need and of the limit that it exceeds. Where rounding would make them one, both are in bytes.
pub fn beyond(need: impl Into<u128>, limit: impl Into<u128>) -> [String; 2] {
    let sizes = [Bytes(need.into()), Bytes(limit.into())];
    let texts = sizes.map(|size| size.to_string());
    if texts[0] == texts[1] { sizes.map(Bytes::in_full) } else { texts }
}

impl Bytes {
    fn in_full(self) -> String {
        match self.0 {
            1 => "1 byte".to_owned(),
            count => format!("{count} bytes"),
        }
    }
}

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 < 1 << 10 {
            return f.pad(&self.in_full());
        }
        let (mut value, mut unit) = (self.0 as f64 / 1024.0, 0);
        // What rounds to 1024 is 1 of the next unit.
        while value >= 1023.5 && unit + 1 < UNITS.len() {
            value /= 1024.0;
            unit += 1;
        }
        let digits = usize::from(value < 99.95);
        f.pad(&format!("{value:.digits$} {}", UNITS[unit]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_two_or_three_digits() {
        for (count, text) in [
            (0, "0 bytes"),
            (1, "1 byte"),
            (640, "640 bytes"),
            (1023, "1023 bytes"),
            (1 << 10, "1.0 KiB"),
            (1_536, "1.5 KiB"),
            (102_348, "99.9 KiB"),
            (102_400, "100 KiB"),
            (1_048_063, "1023 KiB"),
            (1_048_064, "1.0 MiB"),
            (5_348_024, "5.1 MiB"),
            (8 << 30, "8.0 GiB"),
            (5 << 39, "2.5 TiB"),
            (1 << 60, "1.0 EiB"),
            (u128::from(u64::MAX) << 4, "256 EiB"),
        ] {
            assert_eq!(Bytes(count).to_string(), text);
        }
    }

    #[test]
    fn what_exceeds_a_limit_never_reads_as_the_limit() {
        assert_eq!(beyond(3u32 << 30, 2u32 << 30), ["3.0 GiB", "2.0 GiB"]);
        assert_eq!(beyond((8u64 << 30) + 1, 8u64 << 30), ["8589934593 bytes", "8589934592 bytes"]);
        assert_eq!(beyond(2u32, 1u32), ["2 bytes", "1 byte"]);
    }
}
