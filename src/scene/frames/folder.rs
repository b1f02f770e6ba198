//! The files of a folder that a pattern of frames matches.

use super::numbers::MOST_NUMBERS;
use super::pattern::{Match, Pattern};
use std::collections::BTreeMap;

/// What a folder has of a pattern.
#[derive(Debug, Default)]
pub struct Folder {
    /// Names by frame number.
    pub files: BTreeMap<i32, String>,
    /// Names that would match with another number of digits, and that number.
    pub padded: BTreeMap<i32, (String, usize)>,
    /// The first name whose number is larger than that of any frame.
    pub beyond: Option<String>,
    /// The first number that two files have.
    pub twice: Option<(i32, [String; 2])>,
}

impl Folder {
    /// Look at the names in the pattern's folder.
    ///
    /// # Errors
    /// Where it cannot be listed.
    pub fn read(pattern: &Pattern) -> std::io::Result<Folder> {
        let mut names: Vec<String> = Vec::new();
        for entry in std::fs::read_dir(pattern.folder())? {
            // A name that is not Unicode cannot match, since patterns are.
            names.extend(entry?.file_name().into_string().ok());
        }
        names.sort_unstable();
        let mut folder = Folder::default();
        for name in names {
            match pattern.matches(&name) {
                Match::No => {}
                Match::Beyond => _ = folder.beyond.get_or_insert(name),
                Match::Padded(number, width) => _ = folder.padded.entry(number).or_insert((name, width)),
                Match::Frame(number) => {
                    if let Some(other) = folder.files.insert(number, name.clone()) {
                        folder.twice.get_or_insert((number, [other, name]));
                    }
                }
            }
        }
        Ok(folder)
    }

    /// The numbers from the first to the last frame, in the largest step that meets all of them; `None` where they are more than a sequence has.
    pub fn expected(&self) -> Option<Vec<i32>> {
        let numbers: Vec<i32> = self.files.keys().copied().collect();
        let steps = numbers.windows(2).map(|pair| i64::from(pair[1]) - i64::from(pair[0]));
        let Some(step) = steps.reduce(common_divisor) else { return Some(numbers) };
        let (first, last) = (numbers[0], numbers[numbers.len() - 1]);
        let count = (i64::from(last) - i64::from(first)) / step + 1;
        (count <= MOST_NUMBERS as i64).then(|| (0..count).map(|i| (i64::from(first) + i * step) as i32).collect())
    }
}

fn common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

/// Ascending numbers as a list of all their ranges, as [`Numbers`](super::Numbers) are written: `3,7-9`.
pub fn runs(numbers: &[i32]) -> String {
    runs_of(numbers).iter().map(text_of).collect::<Vec<_>>().join(",")
}

/// The first and the last of each run of numbers that follow each other.
fn runs_of(numbers: &[i32]) -> Vec<(i32, i32)> {
    let mut runs: Vec<(i32, i32)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some((_, last)) if last.checked_add(1) == Some(number) => *last = number,
            _ => runs.push((number, number)),
        }
    }
    runs
}

fn text_of(&(first, last): &(i32, i32)) -> String {
    if first == last { first.to_string() } else { format!("{first}-{last}") }
}

/// Ascending numbers as a list of a few ranges: `3, 7-9 and 12 more`.
pub fn ranges(numbers: &[i32]) -> String {
    const SHOWN: usize = 5;
    let runs = runs_of(numbers);
    let shown: Vec<String> = runs.iter().take(SHOWN).map(text_of).collect();
    let rest: i64 = runs.iter().skip(SHOWN).map(|(first, last)| i64::from(*last) - i64::from(*first) + 1).sum();
    if rest == 0 { shown.join(", ") } else { format!("{} and {rest} more", shown.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_may_have_a_step() {
        let expected = |numbers: &[i32]| {
            let files = numbers.iter().map(|n| (*n, String::new())).collect();
            Folder { files, ..Folder::default() }.expected()
        };
        let some = |numbers: &[i32]| Some(numbers.to_vec());
        assert_eq!(expected(&[1, 2, 4]), some(&[1, 2, 3, 4]));
        assert_eq!(expected(&[10, 20, 40]), some(&[10, 20, 30, 40]));
        assert_eq!(expected(&[-2, 0, 2]), some(&[-2, 0, 2]));
        assert_eq!(expected(&[5]), some(&[5]));
        assert_eq!(expected(&[1, 2, 2000]).map(|all| all.len()), Some(2000));
        assert_eq!(expected(&[1, 2, 1_000_000_000]), None);
        assert_eq!(expected(&[i32::MIN, 0, i32::MAX]), None);
    }

    #[test]
    fn missing_numbers_are_shown_as_ranges() {
        assert_eq!(ranges(&[3]), "3");
        assert_eq!(ranges(&[3, 4, 5, 9]), "3-5, 9");
        assert_eq!(ranges(&[1, 3, 5, 7, 9, 11, 12, 20]), "1, 3, 5, 7, 9 and 3 more");
        assert_eq!(ranges(&[i32::MAX]), i32::MAX.to_string());
    }
}
