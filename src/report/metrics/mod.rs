//! The figures of a file by name, how they changed between two files, and conditions on that.

mod sequences;

use super::file::FileReport;
use super::frames::SequenceReport;
use super::rays::RayReport;
use serde::Serialize;

/// A figure that two files can be compared by.
#[derive(Debug)]
pub struct Metric<R: 'static> {
    /// What conditions call it.
    pub name: &'static str,
    /// Its formula and unit, in words.
    pub about: &'static str,
    value: fn(&R) -> Option<f64>,
}

impl<R> Metric<R> {
    /// What it is in a file; nothing where it was not measured.
    pub fn of(&self, report: &R) -> Option<f64> {
        (self.value)(report)
    }
}

/// What is known of a file by figures that have names.
pub trait Measured: Sized + 'static {
    /// All of them, in the order of the table.
    fn metrics() -> &'static [Metric<Self>];
}

impl Measured for FileReport {
    fn metrics() -> &'static [Metric<FileReport>] {
        &METRICS
    }
}

/// The names of all figures, of still files and then those that only sequences have.
pub fn metric_names() -> Vec<&'static str> {
    let mut names: Vec<&str> = METRICS.iter().map(|metric| metric.name).collect();
    let others = SequenceReport::metrics().iter().map(|metric| metric.name);
    names.extend(others.filter(|name| METRICS.iter().all(|metric| metric.name != *name)));
    names
}

fn of_rays(report: &FileReport, of: impl Fn(&RayReport) -> f64) -> Option<f64> {
    report.rays.as_ref().map(of)
}

/// Those of still files.
static METRICS: [Metric<FileReport>; 18] = [
    Metric { name: "triangles", about: "distinct triangles", value: |r| Some(r.blas.triangles as f64) },
    Metric { name: "references", about: "triangles in leaves", value: |r| Some(r.blas.references as f64) },
    Metric { name: "duplication", about: "references / triangles - 1", value: |r| Some(r.blas.duplication) },
    Metric { name: "nodes", about: "nodes in use, of trees over triangles", value: |r| Some(r.blas.nodes as f64) },
    Metric { name: "leaves", about: "leaves, of trees over triangles", value: |r| Some(r.blas.leaves as f64) },
    Metric { name: "refs-per-leaf", about: "references / leaves", value: |r| Some(r.blas.references_per_leaf) },
    Metric {
        name: "largest-leaf",
        about: "references in the largest leaf",
        value: |r| Some(r.blas.leaf_sizes.last().map_or(0.0, |(size, _)| f64::from(*size))),
    },
    Metric {
        name: "depth",
        about: "steps from a root to its deepest leaf",
        value: |r| Some(f64::from(r.blas.max_depth)),
    },
    Metric { name: "sah", about: "surface area heuristic, in triangle tests", value: |r| Some(r.blas.sah) },
    Metric {
        name: "epo",
        about: "end-point overlap, in triangle tests",
        value: |r| r.epo.as_ref().map(|epo| epo.value),
    },
    Metric {
        name: "overlap",
        about: "area that siblings share / parent's area, the mean over inner nodes",
        value: |r| Some(r.blas.mean_sibling_overlap),
    },
    Metric {
        name: "empty",
        about: "volume in neither child / parent's volume, the mean over inner nodes",
        value: |r| Some(r.blas.mean_empty_share),
    },
    Metric { name: "file-bytes", about: "bytes of the file", value: |r| Some(r.file_len as f64) },
    Metric { name: "ray-cost", about: "1.2 x visits + tests", value: |r| of_rays(r, |rays| rays.cost) },
    Metric { name: "visits", about: "inner nodes a ray", value: |r| of_rays(r, |rays| rays.mean(|s| s.visits)) },
    Metric { name: "tests", about: "triangle tests a ray", value: |r| of_rays(r, |rays| rays.mean(|s| s.tests)) },
    Metric { name: "leaf-visits", about: "leaves a ray", value: |r| of_rays(r, |rays| rays.mean(|s| s.leaves)) },
    Metric {
        name: "leaf-variability",
        about: "standard deviation over rays of leaves a ray",
        value: |r| of_rays(r, |rays| rays.mean(|s| s.leaf_variability)),
    },
];

/// A figure of two files.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The metric's name.
    pub metric: &'static str,
    /// In the first file.
    pub before: f64,
    /// In the second.
    pub after: f64,
    /// after − before.
    pub change: f64,
    /// after / before − 1; 0 where both are 0, nothing where only the first is.
    pub relative: Option<f64>,
}

impl Change {
    /// Of all metrics that were measured in both files.
    pub fn all<R: Measured>(before: &R, after: &R) -> Vec<Change> {
        R::metrics().iter().filter_map(|metric| Change::of(metric, before, after)).collect()
    }

    fn of<R>(metric: &Metric<R>, before: &R, after: &R) -> Option<Change> {
        let (before, after) = (metric.of(before)?, metric.of(after)?);
        let change = after - before;
        let relative = if before != 0.0 { Some(change / before) } else { (change == 0.0).then_some(0.0) };
        Some(Change { metric: metric.name, before, after, change, relative })
    }
}

/// What is compared with a condition's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The value in the second file: `depth > 40`.
    After,
    /// By how much it changed: `sah > +0.5`.
    Change,
    /// By what share it changed: `ray-cost > +2%`.
    Relative,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    Less,
    AtMost,
    Greater,
    AtLeast,
}

/// A condition under which a comparison is a failure.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// As it was written.
    pub text: String,
    /// What it is about.
    pub metric: &'static str,
    side: Side,
    order: Order,
    bound: f64,
}

/// Why a text is no condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoCondition {
    /// It is not a name, one of `>`, `>=`, `<`, `<=`, and a number.
    Form,
    /// No metric has this name.
    Metric,
    /// A share has no sign, so that it may be meant of the second file's value or of the change.
    Sign,
}

impl Condition {
    /// Read `METRIC > NUMBER`: with a sign before the number it is about the change from the first file to the second, with `%` behind it, too, about the
    /// change as a share of the first, and with neither about the value in the second. `>=`, `<` and `<=` do as well.
    ///
    /// # Errors
    /// Where the text has another form, a share has no sign, and where no metric has the name.
    pub fn parse(text: &str) -> Result<Condition, NoCondition> {
        let at = text.find(['<', '>']).ok_or(NoCondition::Form)?;
        let (name, rest) = (text[..at].trim(), &text[at..]);
        let orders = [(">=", Order::AtLeast), ("<=", Order::AtMost), (">", Order::Greater), ("<", Order::Less)];
        let found = orders.into_iter().find_map(|(sign, order)| Some((order, rest.strip_prefix(sign)?.trim())));
        let (order, number) = found.ok_or(NoCondition::Form)?;
        let named = metric_names().into_iter().find(|metric| metric.eq_ignore_ascii_case(name));
        let metric = named.ok_or(NoCondition::Metric)?;
        let is_signed = number.starts_with(['+', '-']);
        let (digits, side) = match number.strip_suffix('%') {
            Some(_) if !is_signed => return Err(NoCondition::Sign),
            Some(digits) => (digits.trim(), Side::Relative),
            None => (number, if is_signed { Side::Change } else { Side::After }),
        };
        let bound = digits.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or(NoCondition::Form)?;
        let bound = if side == Side::Relative { bound / 100.0 } else { bound };
        Ok(Condition { text: text.trim().to_string(), metric, side, order, bound })
    }

    /// Whether it holds; nothing where its metric was not measured. A change from 0 to anything is more than every share.
    pub fn judge(&self, changes: &[Change]) -> Option<Verdict> {
        let change = changes.iter().find(|change| change.metric == self.metric)?;
        let value = match self.side {
            Side::After => change.after,
            Side::Change => change.change,
            Side::Relative => change.relative.unwrap_or(f64::INFINITY * change.change.signum()),
        };
        let holds = match self.order {
            Order::Less => value < self.bound,
            Order::AtMost => value <= self.bound,
            Order::Greater => value > self.bound,
            Order::AtLeast => value >= self.bound,
        };
        let finite = value.is_finite().then_some(value);
        Some(Verdict { condition: self.text.clone(), metric: self.metric, of: self.side, value: finite, holds })
    }
}

/// A condition that was asked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// As it was written.
    pub condition: String,
    /// What it is about.
    pub metric: &'static str,
    /// What of it.
    pub of: Side,
    /// What was held against the condition's number, shares as 0.02 for 2 %; nothing for a share of 0.
    pub value: Option<f64>,
    /// Whether the condition holds, which is the failure.
    pub holds: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(metric: &'static str, before: f64, after: f64) -> Vec<Change> {
        let relative = if before != 0.0 { Some(after / before - 1.0) } else { (after == 0.0).then_some(0.0) };
        vec![Change { metric, before, after, change: after - before, relative }]
    }

    fn holds(text: &str, before: f64, after: f64) -> bool {
        let condition = Condition::parse(text).unwrap();
        condition.judge(&change(condition.metric, before, after)).unwrap().holds
    }

    #[test]
    fn a_sign_asks_for_the_change_and_percent_for_its_share() {
        assert!(holds("ray-cost > +2%", 100.0, 102.5) && !holds("ray-cost > +2%", 100.0, 101.5));
        assert!(holds("ray-cost>+2%", 100.0, 102.5) && holds("sah < -5 %", 100.0, 90.0));
        assert!(
            holds("sah > +0.5", 10.0, 10.6) && !holds("sah > +0.5", 10.0, 10.5) && holds("sah >= +0.5", 10.0, 10.5)
        );
        assert!(
            holds("depth > 40", 41.0, 41.0) && !holds("depth > 40", 50.0, 40.0) && holds("depth <= 40", 50.0, 40.0)
        );
        assert_eq!(Condition::parse("sah > 2%"), Err(NoCondition::Sign));
        // From nothing to something is more than any share; nothing to nothing is no change.
        assert!(holds("duplication > +1000%", 0.0, 0.1) && !holds("duplication > +0%", 0.0, 0.0));
    }

    #[test]
    fn what_is_no_condition_is_told_apart_from_unknown_names() {
        for bad in ["", "sah", "sah > ", "sah = 3", "sah > x", "sah > 3 4", "sah > inf", "> 3 <"] {
            assert!(Condition::parse(bad).is_err(), "{bad}");
        }
        assert_eq!(Condition::parse("speed > +2%"), Err(NoCondition::Metric));
        assert_eq!(Condition::parse("sah > many"), Err(NoCondition::Form));
    }

    #[test]
    fn what_was_not_measured_is_not_judged() {
        assert_eq!(Condition::parse("epo > 3").unwrap().judge(&change("sah", 1.0, 2.0)), None);
        let names: std::collections::BTreeSet<_> = metric_names().into_iter().collect();
        assert_eq!(names.len(), metric_names().len());
        assert!(names.len() > METRICS.len() && SequenceReport::metrics().iter().all(|m| names.contains(m.name)));
    }
}
