//! A file name with a place for the number of a frame: `heli.%04d.obj`, `heli.####.obj`, `heli.@.obj`, `heli.1001-1100#.obj`.

use super::numbers::{Numbers, split_list};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A file name with a place for the number of a frame: where it stands, and how many digits it has at least.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    /// 1: as many digits as the number needs.
    width: usize,
    after: String,
    /// The list that stands in the name itself.
    pub numbers: Option<Numbers>,
}

/// A file name against a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Match {
    /// It is the name of this frame.
    Frame(i32),
    /// It would be, with another number of digits: this one.
    Padded(i32, usize),
    /// Its number is larger than that of any frame.
    Beyond,
    /// It is no name of a frame.
    No,
}

/// A number is never printed with more digits.
const WIDEST: usize = 10;

/// Why a name is not the pattern that it seems to be.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NoPattern {
    /// It is not UTF-8, and patterns are.
    NotUtf8,
    /// It has so many places for a number, and one is needed.
    Places(usize),
    /// Its numbers would have so many digits, more than any has.
    Digits(usize),
    /// The list of numbers in it is none, for this reason.
    List(String),
    /// Its place pads numbers by spaces.
    Spaces {
        /// The place, as it stands there.
        place: String,
        /// The path with a place that pads by zeros.
        fixed: PathBuf,
    },
    /// Its place is in the name of a folder.
    InFolder,
}

impl std::fmt::Display for NoPattern {
    /// What completes "as a pattern …".
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            NoPattern::NotUtf8 => f.write_str("it is not UTF-8, and patterns are"),
            NoPattern::Places(count) => write!(f, "it has {count} places for a frame number, and one is needed"),
            NoPattern::Digits(width) => {
                write!(f, "its frame numbers would have {width} digits; they have at most {WIDEST}")
            }
            NoPattern::List(reason) => f.write_str(reason),
            NoPattern::Spaces { place, .. } => {
                write!(f, "it has {place}, which pads numbers by spaces; they are padded by zeros, or not at all")
            }
            NoPattern::InFolder => f.write_str(
                "its place for a frame number is in the name of a folder, and only the name of the file can have one",
            ),
        }
    }
}

impl std::error::Error for NoPattern {}

impl Pattern {
    /// `None` for a name without a place for a number. Only the last part of a path may have one.
    ///
    /// # Errors
    /// Why the name is not the pattern that it seems to be.
    pub fn parse(path: &Path) -> Option<Result<Pattern, NoPattern>> {
        let file_name = path.file_name()?;
        let Some(name) = file_name.to_str() else {
            let seems = seems_pattern(&file_name.to_string_lossy());
            return seems.then_some(Err(NoPattern::NotUtf8));
        };
        let found = [printf(name), runs(name, '#'), runs(name, '@')].into_iter().find(|places| !places.is_empty());
        let Some(places) = found else { return not_quite(path, name).map(Err) };
        let (start, end, width) = match places[..] {
            [one] => one,
            _ => return Some(Err(NoPattern::Places(places.len()))),
        };
        if width > WIDEST {
            return Some(Err(NoPattern::Digits(width)));
        }
        let (mut before, after) = (&name[..start], &name[end..]);
        let mut numbers = None;
        if let Some((rest, list)) = split_list(before) {
            match list.parse() {
                Ok(list) => (before, numbers) = (rest, Some(list)),
                Err(reason) => return Some(Err(NoPattern::List(reason))),
            }
        }
        // `%%` stands for a percent sign where the other place is one of printf's, as it does there.
        let text = |part: &str| if name[start..].starts_with('%') { part.replace("%%", "%") } else { part.to_string() };
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Some(Ok(Pattern { folder, before: text(before), width, after: text(after), numbers }))
    }

    /// The pattern whose frames these files are, in the last number of their names that tells them apart; `None` where there is none.
    pub fn of_files(paths: &[&Path]) -> Option<Pattern> {
        let (folder, name) = (paths.first()?.parent()?, paths.first()?.file_name()?.to_str()?);
        let is_digit = |at: usize| name.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
        let starts = (0..name.len()).rev().filter(|at| is_digit(*at) && !at.checked_sub(1).is_some_and(is_digit));
        let patterns = starts.flat_map(|start| {
            let end = start + name[start..].bytes().take_while(u8::is_ascii_digit).count();
            [end - start, 1].map(|width| Pattern {
                folder: folder.to_path_buf(),
                before: name[..start].to_owned(),
                width,
                after: name[end..].to_owned(),
                numbers: None,
            })
        });
        let number = |pattern: &Pattern, path: &Path| match pattern.matches(path.file_name()?.to_str()?) {
            Match::Frame(number) if path.parent() == Some(folder) => Some(number),
            _ => None,
        };
        patterns.into_iter().find(|pattern| {
            let numbers: Option<BTreeSet<i32>> = paths.iter().map(|path| number(pattern, path)).collect();
            numbers.is_some_and(|numbers| numbers.len() == paths.len())
        })
    }

    /// The folder that the files lie in, as a path that can be read.
    pub fn folder(&self) -> &Path {
        if self.folder.as_os_str().is_empty() { Path::new(".") } else { &self.folder }
    }

    /// The path of a frame, padded as C's `printf` does.
    pub fn path(&self, number: i32) -> PathBuf {
        let width = self.width;
        self.file(&format!("{}{number:0width$}{}", self.before, self.after))
    }

    /// The path of a file of this name.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The pattern as it is written, with `printf`'s place.
    pub fn text(&self) -> String {
        self.with_width(self.width)
    }

    /// The same pattern for numbers of so many digits.
    pub fn with_width(&self, width: usize) -> String {
        let place = if width == 1 { "%d".to_string() } else { format!("%0{width}d") };
        let text = |part: &str| part.replace('%', "%%");
        self.file(&format!("{}{place}{}", text(&self.before), text(&self.after))).display().to_string()
    }

    /// Compare the name of a file in the folder.
    pub fn matches(&self, name: &str) -> Match {
        let middle = name.strip_prefix(self.before.as_str()).and_then(|rest| rest.strip_suffix(self.after.as_str()));
        let Some(middle) = middle else { return Match::No };
        let digits = middle.strip_prefix('-').unwrap_or(middle);
        if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
            return Match::No;
        }
        let Ok(number) = middle.parse::<i32>() else { return Match::Beyond };
        let is_plain = digits.len() == 1 || !digits.starts_with('0');
        // Some programs count the sign as one of the digits, as `printf` does, and some do not.
        let is_padded = digits.len() == self.width || (middle.len() == self.width && digits.len() < middle.len());
        if is_padded || (is_plain && digits.len() > self.width) {
            Match::Frame(number)
        } else {
            Match::Padded(number, if is_plain { 1 } else { digits.len() })
        }
    }
}

/// What a path without a place in its last part was meant to be, where it seems to be a pattern all the same.
fn not_quite(path: &Path, name: &str) -> Option<NoPattern> {
    if let Some((place, padded)) = padded_by_spaces(name) {
        let fixed = path.with_file_name(name.replacen(&place, &padded, 1));
        return Some(NoPattern::Spaces { place, fixed });
    }
    let folder = path.parent()?.to_string_lossy();
    seems_pattern(&folder).then_some(NoPattern::InFolder)
}

/// Whether a text has what is hardly anything but a place for a number; a lone `#` or `@` may be part of any name.
fn seems_pattern(text: &str) -> bool {
    let is_run = |mark| runs(text, mark).iter().any(|(start, end, _)| end - start > 1);
    !printf(text).is_empty() || is_run('#') || is_run('@')
}

/// `%4d`, and `%04d` in its place.
fn padded_by_spaces(name: &str) -> Option<(String, String)> {
    name.match_indices('%').find_map(|(at, _)| {
        let rest = &name[at + 1..];
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        let is_place = digits > 0 && !rest.starts_with('0') && rest[digits..].starts_with('d');
        is_place.then(|| (format!("%{}d", &rest[..digits]), format!("%0{}d", &rest[..digits])))
    })
}

/// Places of `%d` and `%04d`: start, end and width.
fn printf(name: &str) -> Vec<(usize, usize, usize)> {
    let mut places = Vec::new();
    let mut at = 0;
    while let Some(found) = name[at..].find('%') {
        let start = at + found;
        let rest = &name[start + 1..];
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        if rest[digits..].starts_with('d') && (digits == 0 || rest.starts_with('0')) {
            places.push((start, start + digits + 2, rest[..digits].parse().unwrap_or(1).max(1)));
        }
        // The second of two percent signs begins nothing.
        at = start + if rest.starts_with('%') { 2 } else { 1 };
    }
    places
}

/// Runs of `#` or `@`. A lone `#` has four digits, and a lone `@` as many as it needs.
fn runs(name: &str, mark: char) -> Vec<(usize, usize, usize)> {
    let mut places: Vec<(usize, usize, usize)> = Vec::new();
    for (at, _) in name.match_indices(mark) {
        match places.last_mut() {
            Some((_, end, width)) if *end == at => (*end, *width) = (at + 1, *width + 1),
            _ => places.push((at, at + 1, 1)),
        }
    }
    if mark == '#' {
        places.iter_mut().filter(|(_, _, width)| *width == 1).for_each(|(_, _, width)| *width = 4);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Pattern {
        Pattern::parse(Path::new(text)).unwrap().unwrap()
    }

    #[test]
    fn files_tell_the_pattern_that_they_are_frames_of() {
        let text = |names: &[&str]| {
            let paths: Vec<&Path> = names.iter().map(Path::new).collect();
            Pattern::of_files(&paths).map(|pattern| pattern.text())
        };
        assert_eq!(text(&["in/a2.0009.obj", "in/a2.0010.obj"]).as_deref(), Some("in/a2.%04d.obj"));
        assert_eq!(text(&["h9.obj", "h10.obj", "h1.obj"]).as_deref(), Some("h%d.obj"));
        assert_eq!(text(&["h1_v2.obj", "h2_v2.obj"]).as_deref(), Some("h%d_v2.obj"));
        assert_eq!(text(&["50%_1.obj", "50%_2.obj"]).as_deref(), Some("50%%_%d.obj"));
        for none in
            [&["a.obj", "b.obj"][..], &["a1.obj", "b2.obj"], &["in/a1.obj", "on/a2.obj"], &["a7.obj", "a07.obj"], &[]]
        {
            assert_eq!(text(none), None, "{none:?}");
        }
    }

    #[test]
    fn every_way_to_write_a_place_gives_the_path_of_a_frame() {
        for (text, number, path) in [
            ("a/heli.%04d.obj", 7, "a/heli.0007.obj"),
            ("heli.%d.obj", 7, "heli.7.obj"),
            ("heli%03d", 1234, "heli1234"),
            ("heli.#.obj", 7, "heli.0007.obj"),
            ("heli.##.obj", 7, "heli.07.obj"),
            ("heli.@.obj", 7, "heli.7.obj"),
            ("heli.@@@.obj", 7, "heli.007.obj"),
            ("heli%04d.obj", -2, "heli-002.obj"),
            ("50%%.%02d.obj", 1, "50%.01.obj"),
            ("a#b.%02d.obj", 1, "a#b.01.obj"),
            ("mail@home.##.obj", 1, "mail@home.01.obj"),
        ] {
            assert_eq!(parse(text).path(number), Path::new(path), "{text}");
        }
        assert_eq!(parse("a/heli.%04d.obj").with_width(1), Path::new("a/heli.%d.obj").display().to_string());
    }

    #[test]
    fn names_without_a_place_are_no_patterns() {
        for text in ["heli.obj", "50%.obj", "50%%.obj", "a.%s.obj", "a#1/b.obj", "a@b/c.obj", "%%04d.obj", ".."] {
            assert_eq!(Pattern::parse(Path::new(text)), None, "{text}");
        }
        for text in ["%d.%d.obj", "#.#.obj", "a@b@.obj", "a.%099d.obj", "a.9-1#.obj"] {
            assert!(Pattern::parse(Path::new(text)).unwrap().is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_not_quite_a_pattern_is_told() {
        let spaces = NoPattern::Spaces { place: "%4d".into(), fixed: "in/a.%04d.obj".into() };
        for (text, why, fact) in [
            ("in/a.%4d.obj", Some(spaces), "%4d, which pads numbers by spaces"),
            ("in.%04d/a.obj", Some(NoPattern::InFolder), "name of a folder"),
            ("####/a.obj", Some(NoPattern::InFolder), "name of a folder"),
            ("a.%d.%d.obj", Some(NoPattern::Places(2)), "2 places"),
            ("a.%099d.obj", Some(NoPattern::Digits(99)), "99 digits"),
            ("a.9-1#.obj", None, "ends before it begins"),
        ] {
            let refused = Pattern::parse(Path::new(text)).unwrap().unwrap_err();
            assert!(refused.to_string().contains(fact), "{text}: {refused}");
            assert!(why.is_none_or(|why| why == refused), "{text}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn patterns_are_utf_8() {
        use std::os::unix::ffi::OsStrExt;
        let parse = |name: &[u8]| Pattern::parse(Path::new(std::ffi::OsStr::from_bytes(name)));
        assert_eq!(parse(b"caf\xe9.%04d.obj"), Some(Err(NoPattern::NotUtf8)));
        assert_eq!(parse(b"caf\xe9.obj"), None);
    }

    #[test]
    fn a_list_may_stand_before_the_place() {
        let pattern = parse("anim.1001-1003%04d.obj");
        assert_eq!(pattern.numbers.as_ref().map(Numbers::list), Some(&[1001, 1002, 1003][..]));
        assert_eq!(pattern.path(1002), Path::new("anim.1002.obj"));
        assert_eq!(parse("anim-1-3#.obj").path(2), Path::new("anim-0002.obj"));
        assert_eq!(parse("v2.#.obj").numbers, None);
    }

    #[test]
    fn names_match_by_number_and_padding() {
        let padded = parse("neg%04d.obj");
        for (name, expected) in [
            ("neg0001.obj", Match::Frame(1)),
            ("neg10000.obj", Match::Frame(10000)),
            ("neg-0002.obj", Match::Frame(-2)),
            ("neg-002.obj", Match::Frame(-2)),
            ("neg1.obj", Match::Padded(1, 1)),
            ("neg007.obj", Match::Padded(7, 3)),
            ("neg00007.obj", Match::Padded(7, 5)),
            ("neg.obj", Match::No),
            ("neg+001.obj", Match::No),
            ("neg00x1.obj", Match::No),
            ("pos0001.obj", Match::No),
            ("neg0001.glb", Match::No),
            ("neg99999999999.obj", Match::Beyond),
            ("neg-.obj", Match::No),
        ] {
            assert_eq!(padded.matches(name), expected, "{name}");
        }
        let plain = parse("f.%d.obj");
        assert_eq!(plain.matches("f.10.obj"), Match::Frame(10));
        assert_eq!(plain.matches("f.0.obj"), Match::Frame(0));
        assert_eq!(plain.matches("f.-3.obj"), Match::Frame(-3));
        assert_eq!(plain.matches("f.010.obj"), Match::Padded(10, 3));
    }
}
