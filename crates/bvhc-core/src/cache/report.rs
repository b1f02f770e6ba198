use std::collections::BTreeMap;
use std::fmt;

#[cfg(feature = "serde")]
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::rules::{self, Rule, Severity};
use crate::layout::{SectionEntry, SectionKind};
use crate::size;

/// Where something was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// `None`: the header, the table or the file as a whole.
    pub section: Option<SectionKind>,
    /// The section's number, which only sequences have others of than 0.
    pub ordinal: u16,
    /// The BLAS that the record belongs to, in a sequence the pose, and the record's number in that tree.
    pub tree: Option<(u32, u64)>,
    /// The record's number in the section, or the entry's number in the table.
    pub index: Option<u64>,
    /// Byte in the file; `None` where the section is compressed or nothing is a file yet.
    pub offset: Option<u64>,
}

impl Place {
    /// The file as a whole.
    pub fn file() -> Place {
        Place::default()
    }

    /// A byte of the header or the table, counted from the start of the file.
    pub fn byte(offset: u64) -> Place {
        Place { offset: Some(offset), ..Place::default() }
    }

    /// A section as a whole.
    pub fn section(kind: SectionKind) -> Place {
        Place { section: Some(kind), ..Place::default() }
    }

    /// A section of the table as a whole.
    pub fn of(entry: &SectionEntry) -> Place {
        // Sections that a rule is about have numbers below 65,536.
        Place { ordinal: u16::try_from(entry.ordinal).unwrap_or(u16::MAX), ..Place::section(entry.kind) }
    }

    /// A record, numbered from the start of its section.
    pub fn record(kind: SectionKind, index: u64) -> Place {
        Place { section: Some(kind), index: Some(index), ..Place::default() }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.section, self.index) {
            (Some(kind), Some(index)) if self.ordinal > 0 => write!(f, "{kind} {}[{index}]", self.ordinal)?,
            (Some(kind), None) if self.ordinal > 0 => write!(f, "{kind} {}", self.ordinal)?,
            (Some(kind), Some(index)) => write!(f, "{kind}[{index}]")?,
            (Some(kind), None) => write!(f, "{kind}")?,
            (None, Some(index)) => write!(f, "entry {index}")?,
            (None, None) => write!(f, "file")?,
        }
        if let Some((tree, record)) = self.tree {
            write!(f, " (tree {tree}, record {record})")?;
        }
        match self.offset {
            Some(offset) => write!(f, " @{offset:#x}"),
            None => Ok(()),
        }
    }
}

/// One breach of one rule.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Finding {
    /// The rule that is broken; its severity says whether the file is invalid.
    pub rule: &'static Rule,
    /// As exactly as the check knows it.
    pub place: Place,
    /// What the rule demands, as its detail line takes it.
    pub expected: String,
    /// What was found.
    pub actual: String,
}

impl Finding {
    /// A breach of a rule with both values of its detail line.
    pub fn new(rule: &'static Rule, place: Place, expected: String, actual: String) -> Finding {
        Finding { rule, place, expected, actual }
    }

    /// The rule's detail line with both values.
    pub fn detail(&self) -> String {
        self.rule.describe(&self.expected, &self.actual)
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:<22} {}: {}", self.rule.id, self.rule.name, self.place, self.detail())
    }
}

#[cfg(feature = "serde")]
impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_struct("Finding", 9)?;
        out.serialize_field("id", self.rule.id)?;
        out.serialize_field("name", self.rule.name)?;
        out.serialize_field("severity", &self.rule.severity())?;
        out.serialize_field("section", &self.place.section.map(|kind| kind.to_string()))?;
        out.serialize_field("ordinal", &self.place.ordinal)?;
        out.serialize_field("tree", &self.place.tree.map(|(tree, _)| tree))?;
        out.serialize_field("index", &self.place.index)?;
        out.serialize_field("offset", &self.place.offset)?;
        out.serialize_field("detail", &self.detail())?;
        out.end()
    }
}

/// At least so many parts that were not looked into are listed.
const MOST_SKIPPED: usize = 20;

/// What a check found. Findings stand in a fixed order whatever the number of threads: level by level, section by section, record
/// by record.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// At most `max_issues` for each rule; [`Report::counts`] has them all.
    pub findings: Vec<Finding>,
    /// Parts of the file that were not looked into although the level asks for it, and why: whole sentences.
    pub not_checked: Vec<String>,
    /// Parts that were not looked into beyond those that are listed.
    also_not_checked: u64,
    /// Bytes that the sections take and may take, where these are more.
    over_limit: Option<(u128, u64)>,
    tallies: BTreeMap<&'static str, Tally>,
    max_issues: usize,
}

#[derive(Clone, Copy, Debug)]
struct Tally {
    rule: &'static Rule,
    total: u64,
    stored: usize,
}

impl Report {
    /// A report without findings, which stores at most `max_issues` of each rule.
    pub fn new(max_issues: usize) -> Report {
        Report { max_issues, ..Report::default() }
    }

    /// Neither an error nor a warning.
    pub fn is_clean(&self) -> bool {
        self.tallies.is_empty()
    }

    /// No errors: the file may be traced. Warnings do not matter.
    pub fn is_valid(&self) -> bool {
        self.errors() == 0
    }

    /// Breaches of rules whose severity is an error, stored or not.
    pub fn errors(&self) -> u64 {
        self.total(Severity::Error)
    }

    /// Breaches of rules whose severity is a warning, stored or not.
    pub fn warnings(&self) -> u64 {
        self.total(Severity::Warning)
    }

    fn total(&self, severity: Severity) -> u64 {
        self.tallies.values().filter(|t| t.rule.severity() == severity).map(|t| t.total).sum()
    }

    /// Every rule that was broken and how often, stored or not, in the order of rule numbers.
    pub fn counts(&self) -> impl Iterator<Item = (&'static Rule, u64)> + '_ {
        self.tallies.values().map(|t| (t.rule, t.total))
    }

    /// How many breaches of this rule there are, stored or not.
    pub fn count(&self, rule: &Rule) -> u64 {
        self.tallies.get(rule.id).map_or(0, |t| t.total)
    }

    /// Breaches that were counted but not stored.
    pub fn truncated(&self) -> u64 {
        self.tallies.values().map(|t| t.total - t.stored as u64).sum()
    }

    /// Whether every error says that the file is of a kind that this version cannot read, and none that it is broken.
    pub fn is_unsupported(&self) -> bool {
        !self.is_valid()
            && self.tallies.values().all(|t| t.rule.severity() == Severity::Warning || t.rule.is_unsupported())
    }

    /// Count a breach, and describe it if there is room: `values` gives the expected and the actual value.
    pub fn add(&mut self, rule: &'static Rule, place: Place, values: impl FnOnce() -> (String, String)) {
        let tally = self.tallies.entry(rule.id).or_insert(Tally { rule, total: 0, stored: 0 });
        tally.total += 1;
        if tally.stored < self.max_issues {
            tally.stored += 1;
            let (expected, actual) = values();
            self.findings.push(Finding::new(rule, place, expected, actual));
        }
    }

    /// Count a breach that somebody else found.
    pub fn add_finding(&mut self, found: Finding) {
        self.add(found.rule, found.place, || (found.expected, found.actual));
    }

    /// Say that part of the file is not looked into, and why. Beyond some tens it is only counted: a file may have millions of trees.
    pub fn skip(&mut self, what: impl Into<String>) {
        if self.not_checked.len() < self.max_issues.max(MOST_SKIPPED) {
            self.not_checked.push(what.into());
        } else {
            self.also_not_checked += 1;
        }
    }

    /// Say that something is not looked into because the machine has not got the memory: an error, since nobody knows whether it is sound.
    ///
    /// `what` begins a sentence, such as `The vertices of tree 3`.
    pub fn starve(&mut self, place: Place, what: &str) {
        self.add(&rules::E0127, place, || ("the memory that is free".into(), "the check takes more".into()));
        self.skip(format!("{what}: there is not enough memory."));
    }

    /// Say that the sections take `needed` bytes of memory, and that the limit that somebody set is below that. `actual` says it in words.
    pub(super) fn exceed(&mut self, needed: u128, limit: u64, actual: impl FnOnce(String) -> String) {
        self.add(&rules::E0127, Place::file(), || {
            let [needed, limit] = size::beyond(needed, limit);
            (limit, actual(needed))
        });
        self.over_limit.get_or_insert((needed, limit));
    }

    /// Bytes that the sections take and may take, where the limit keeps them from being read.
    pub(super) fn over_limit(&self) -> Option<(u128, u64)> {
        self.over_limit
    }

    /// Say how many parts were only counted. For the end of a check.
    pub(super) fn tell_skipped(&mut self) {
        let more = std::mem::take(&mut self.also_not_checked);
        if more > 0 {
            self.not_checked.push(format!("And {more} more of the same."));
        }
    }

    /// Append what a later part of the file was found guilty of.
    pub fn append(&mut self, later: Report) {
        for finding in later.findings {
            let tally =
                self.tallies.entry(finding.rule.id).or_insert(Tally { rule: finding.rule, total: 0, stored: 0 });
            if tally.stored < self.max_issues {
                tally.stored += 1;
                self.findings.push(finding);
            }
        }
        for (id, t) in later.tallies {
            self.tallies.entry(id).or_insert(Tally { total: 0, stored: 0, ..t }).total += t.total;
        }
        later.not_checked.into_iter().for_each(|what| self.skip(what));
        self.also_not_checked += later.also_not_checked;
        self.over_limit = self.over_limit.or(later.over_limit);
    }
}
