//! Lists of frame numbers: `1001-1100`, `1-100x5`, `1,5,10-20`, `-10--1`.

use std::collections::BTreeSet;
use std::str::FromStr;

/// Most numbers of a list, which is held as single numbers; no sequence has as many frames.
pub const MOST_NUMBERS: usize = 1 << 20;

/// Numbers of frames in ascending order, each once, and at least one: `7`, `1-100`, `1-100x5` for every fifth, or several with commas.
///
/// ```
/// use bvhc::scene::frames::Numbers;
///
/// let numbers: Numbers = "1,5,10-20x5".parse()?;
/// assert_eq!(numbers.list(), [1, 5, 10, 15, 20]);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbers(Vec<i32>);

impl Numbers {
    /// The numbers.
    pub fn list(&self) -> &[i32] {
        &self.0
    }
}

impl FromStr for Numbers {
    type Err = String;

    fn from_str(text: &str) -> Result<Numbers, String> {
        let mut numbers = BTreeSet::new();
        for part in text.split(',') {
            let (first, last, step) = range(part).ok_or_else(|| {
                format!("'{part}' is no range of frames; write 7, 1-100, 1-100x5, or several with commas; no number is beyond {}", i32::MAX)
            })?;
            if last < first {
                return Err(format!("the range {part} ends before it begins"));
            }
            if step == 0 {
                return Err(format!("the range {part} makes steps of 0; the smallest step is 1"));
            }
            let count = (i64::from(last) - i64::from(first)) / i64::from(step) + 1;
            if count + numbers.len() as i64 > MOST_NUMBERS as i64 {
                return Err(format!("there are more than {MOST_NUMBERS} frames in it"));
            }
            numbers.extend((first..=last).step_by(step as usize));
        }
        Ok(Numbers(numbers.into_iter().collect()))
    }
}

/// `7`, `1-100` or `1-100x5`: the first and last number and the step.
fn range(text: &str) -> Option<(i32, i32, u32)> {
    let (ends, step) = match text.split_once('x') {
        Some((ends, step)) => (ends, digits(step)?.parse().ok()?),
        None => (text, 1),
    };
    // The dash between both ends is the first one that does not begin a number.
    let Some(dash) = ends.get(1..)?.find('-').map(|i| i + 1) else {
        let one = number(ends)?;
        return (step == 1 && !text.contains('x')).then_some((one, one, 1));
    };
    Some((number(&ends[..dash])?, number(&ends[dash + 1..])?, step))
}

fn number(text: &str) -> Option<i32> {
    digits(text.strip_prefix('-').unwrap_or(text))?;
    text.parse().ok()
}

fn digits(text: &str) -> Option<&str> {
    (!text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())).then_some(text)
}

/// The longest list of ranges at the end of a text, if it has a range of more than one number: what stands before it, and the list.
///
/// A dash before the first number is its sign only after a point, an underscore or nothing: `run-1-9` is `run-` and `1-9`.
pub fn split_list(text: &str) -> Option<(&str, &str)> {
    let bytes = text.as_bytes();
    let mut start = bytes.len();
    while start > 0 && (bytes[start - 1].is_ascii_digit() || matches!(bytes[start - 1], b'-' | b',' | b'x')) {
        start -= 1;
    }
    let is_sign = |at: usize| at == 0 || matches!(bytes[at - 1], b'.' | b'_');
    (start..text.len())
        .filter(|&at| bytes[at].is_ascii_digit() || (bytes[at] == b'-' && is_sign(at)))
        .filter(|&at| at == 0 || !bytes[at - 1].is_ascii_digit())
        .map(|at| text.split_at(at))
        .find(|(_, list)| list[1..].contains(['-', ',']) && list.split(',').all(|part| range(part).is_some()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_ranges_with_steps_and_signs() {
        let list = |text: &str| text.parse::<Numbers>().unwrap().0;
        assert_eq!(list("7"), [7]);
        assert_eq!(list("1,5,9-11"), [1, 5, 9, 10, 11]);
        assert_eq!(list("1-10x4"), [1, 5, 9]);
        assert_eq!(list("-10--8"), [-10, -9, -8]);
        assert_eq!(list("-1-1"), [-1, 0, 1]);
        assert_eq!(list("5,1-3,2"), [1, 2, 3, 5], "ascending, each once");
        assert_eq!(list("0007-0009"), [7, 8, 9]);
        assert_eq!(list("2147483646-2147483647"), [i32::MAX - 1, i32::MAX]);
    }

    #[test]
    fn what_is_no_list_is_refused() {
        for (text, reason) in [
            ("", "'' is no range"),
            ("a", "'a' is no range"),
            ("1-", "'1-' is no range"),
            ("1,,2", "'' is no range"),
            ("1-2-3", "is no range"),
            ("1x2", "'1x2' is no range"),
            ("+1", "'+1' is no range"),
            ("1-2147483648", "is no range"),
            ("9-1", "ends before it begins"),
            ("1-9x0", "steps of 0"),
            ("1-9x99999999999", "is no range"),
            ("0-1048576", "more than 1048576 frames"),
        ] {
            let error = text.parse::<Numbers>().unwrap_err();
            assert!(error.contains(reason), "{text}: {error}");
        }
        assert_eq!("0-1048575".parse::<Numbers>().unwrap().0.len(), MOST_NUMBERS);
    }

    #[test]
    fn a_list_stands_at_the_end_of_a_name() {
        for (text, expected) in [
            ("run.1-9", Some(("run.", "1-9"))),
            ("run-1-9", Some(("run-", "1-9"))),
            ("run.-9--1", Some(("run.", "-9--1"))),
            ("-9--1", Some(("", "-9--1"))),
            ("run.1,3,7-9x2", Some(("run.", "1,3,7-9x2"))),
            ("box1-9", Some(("box", "1-9"))),
            ("run.v2", None),
            ("run.12", None),
            ("run-", None),
            ("", None),
        ] {
            assert_eq!(split_list(text), expected, "{text}");
        }
    }
}
