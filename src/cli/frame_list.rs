//! Which frames of a sequence a command is about: `--frame all`, one number or a list.

use super::Context;
use super::caches;
use super::exit::Exit;
use super::failure::Failure;
use super::names;
use super::outputs::Source;
use crate::cache::Sequence;
use crate::scene::frames::{Numbers, ranges};
use std::path::{Path, PathBuf};

/// As typed.
#[derive(Clone, Debug, PartialEq)]
pub enum FrameList {
    All,
    Some(Numbers),
}

impl FrameList {
    /// `all`, or numbers.
    pub fn parse(text: &str) -> Result<FrameList, String> {
        if text == "all" { Ok(FrameList::All) } else { text.parse().map(FrameList::Some) }
    }

    /// The number, where it is a single one that was typed.
    pub fn only(&self) -> Option<i32> {
        match self {
            FrameList::Some(numbers) if numbers.list().len() == 1 => numbers.list().first().copied(),
            _ => None,
        }
    }

    /// The frames of a sequence that are meant, in its order. `action` is what would be done with the file, for errors.
    ///
    /// # Errors
    /// Where one is not in the file.
    pub fn of(&self, sequence: &Sequence, path: &Path, action: &str) -> Result<Vec<i32>, Failure> {
        let there: Vec<i32> = sequence.frames().iter().map(|frame| frame.number).collect();
        let FrameList::Some(asked) = self else { return Ok(there) };
        let (chosen, absent): (Vec<i32>, Vec<i32>) =
            asked.list().iter().partition(|number| sequence.numbered(**number).is_some());
        if absent.is_empty() {
            return Ok(chosen);
        }
        Err(Failure::new(Exit::Usage, format!("cannot {action} {}", names::path(path)))
            .fact(format!("not in the file: frame {}; it has {}", ranges(&absent), ranges(&there)))
            .help("take those that are there: --frame all"))
    }

    /// What outputs are made of: each file, or each of its frames where several are meant.
    pub fn sources(
        list: Option<&FrameList>,
        files: &[PathBuf],
        action: &str,
        context: &Context,
    ) -> Result<Vec<Source>, Failure> {
        let mut sources = Vec::new();
        for path in files {
            let source = |frame, is_one_of_several| Source { path: path.clone(), frame, is_one_of_several };
            match list {
                None => sources.push(source(None, false)),
                Some(list) => match list.only() {
                    Some(number) => sources.push(source(Some(number), false)),
                    None => {
                        let sequence = caches::open_sequence(path, context)?;
                        sources.extend(list.of(&sequence, path, action)?.into_iter().map(|n| source(Some(n), true)));
                    }
                },
            }
        }
        Ok(sources)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_number_is_told_from_a_list() {
        let only = |text: &str| FrameList::parse(text).unwrap().only();
        assert_eq!([only("7"), only("-7"), only("7-9"), only("all")], [Some(7), Some(-7), None, None]);
        assert!(FrameList::parse("some").is_err());
    }
}
