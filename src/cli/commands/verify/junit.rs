//! JUnit's XML, which CI systems read: a suite for each file, a case for each device and set of rays.

use super::file::Verified;
use super::text;
use crate::cli::drawing;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::trace::rays::RaySet;
use crate::verify::{Counts, DeviceOutcome, Placed, set_name, write_ray};
use std::path::Path;
use std::time::Duration;

pub struct Suite {
    name: String,
    seconds: f64,
    cases: Vec<Case>,
}

struct Case {
    name: String,
    seconds: f64,
    trouble: Option<Trouble>,
}

struct Trouble {
    /// `failure` for a wrong verdict, `error` for none.
    element: &'static str,
    kind: String,
    message: String,
    detail: String,
}

pub fn suite(path: &Path, frame: Option<i32>, result: &Result<Verified, Failure>, spent: Duration) -> Suite {
    let cases = match result {
        Ok(verified) => {
            let placed = verified.placed.as_ref().map(placing);
            placed.into_iter().chain(verified.outcome.devices.iter().flat_map(cases)).collect()
        }
        Err(failure) => vec![not_done("open", failure, spent)],
    };
    let frame = frame.map_or_else(String::new, |number| format!(" frame {number}"));
    Suite { name: path.to_string_lossy().into_owned() + &frame, seconds: spent.as_secs_f64(), cases }
}

/// The suite of a run whose devices could not be opened, so that no file was.
pub fn without_devices(failure: &Failure, spent: Duration) -> Suite {
    Suite { name: "devices".to_string(), seconds: spent.as_secs_f64(), cases: vec![not_done("open", failure, spent)] }
}

/// A case without a verdict.
fn not_done(name: &str, failure: &Failure, spent: Duration) -> Case {
    let trouble = Trouble {
        element: "error",
        kind: failure.exit.name().to_string(),
        message: failure.action.clone(),
        detail: failure.to_text(str::to_string),
    };
    Case { name: name.to_string(), seconds: spent.as_secs_f64(), trouble: Some(trouble) }
}

/// Whether the triangles are where the model has them.
fn placing(placed: &Placed) -> Case {
    let trouble = (!placed.is_right()).then(|| Trouble {
        element: "failure",
        kind: "placing".to_string(),
        message: text::placing(placed).trim_end().to_string(),
        detail: String::new(),
    });
    Case { name: "placing".to_string(), seconds: 0.0, trouble }
}

fn cases(device: &DeviceOutcome) -> Vec<Case> {
    let case = |(set, counts): &(RaySet, Counts)| Case {
        name: format!("{} {}", device.name, set_name(*set)),
        seconds: counts.seconds + counts.any_seconds,
        trouble: (counts.mismatches() > 0).then(|| trouble(device, *set, counts)),
    };
    device.sets.iter().map(case).collect()
}

fn trouble(device: &DeviceOutcome, set: RaySet, counts: &Counts) -> Trouble {
    let (wrong, first) = (counts.mismatches(), device.first_mismatch.as_ref().filter(|m| m.set == set));
    let message = match first {
        Some(m) => format!("{wrong} of {} rays are wrong; the first: {} {}", counts.rays, device.name, m.class.words()),
        None => format!("{wrong} of {} rays are wrong", counts.rays),
    };
    let mut detail = String::new();
    if let Some(m) = first {
        let (ray, expected, got) = (write_ray(&m.ray), text::expected(&m.expected), text::got(&m.got));
        detail = format!("ray {ray}\nexpected {expected}\ngot {got}\n");
        if let Some(blame) = &m.blame {
            detail.push_str(&format!("to blame {blame}\n"));
        }
    }
    Trouble { element: "failure", kind: "mismatch".to_string(), message, detail }
}

pub fn write(path: &Path, suites: &[Suite]) -> Result<(), Failure> {
    drawing::put(path, "the report", document(suites).as_bytes())
}

fn document(suites: &[Suite]) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let sum = |of: fn(&Suite) -> usize| suites.iter().map(of).sum::<usize>();
    xml.push_str(&format!(
        "<testsuites name=\"bvhc verify\" {}>\n",
        totals(
            [sum(|s| s.cases.len()), sum(|s| s.count("failure")), sum(|s| s.count("error"))],
            suites.iter().map(|s| s.seconds).sum()
        )
    ));
    for suite in suites {
        let counts = [suite.cases.len(), suite.count("failure"), suite.count("error")];
        xml.push_str(&format!("  <testsuite name=\"{}\" {}>\n", escaped(&suite.name), totals(counts, suite.seconds)));
        for case in &suite.cases {
            xml.push_str(&format!(
                "    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3}\"",
                escaped(&suite.name),
                escaped(&case.name),
                case.seconds
            ));
            match &case.trouble {
                None => xml.push_str("/>\n"),
                Some(t) => xml.push_str(&format!(
                    ">\n      <{0} type=\"{1}\" message=\"{2}\">{3}</{0}>\n    </testcase>\n",
                    t.element,
                    escaped(&t.kind),
                    escaped(&t.message),
                    escaped(&t.detail)
                )),
            }
        }
        xml.push_str("  </testsuite>\n");
    }
    xml.push_str("</testsuites>\n");
    xml
}

fn totals([tests, failures, errors]: [usize; 3], seconds: f64) -> String {
    format!("tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" time=\"{seconds:.3}\"")
}

impl Suite {
    fn count(&self, element: &str) -> usize {
        self.cases.iter().filter(|c| c.trouble.as_ref().is_some_and(|t| t.element == element)).count()
    }
}

/// Text for an attribute or an element. XML 1.0 has no way to write most control characters, so they are shown as on a terminal.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' => out.push_str("&#10;"),
            '\u{fffe}' | '\u{ffff}' => out.extend(c.escape_unicode()),
            _ => out.push_str(&names::escape(c.encode_utf8(&mut [0; 4]))),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_xml_cannot_hold_is_escaped() {
        assert_eq!(escaped("a<b>&\"c\"\n\u{1b}[0m\u{0}"), "a&lt;b&gt;&amp;&quot;c&quot;&#10;\\u{1b}[0m\\u{0}");
    }

    #[test]
    fn counts_at_every_level_agree() {
        let trouble = |element| Some(Trouble { element, kind: "k".into(), message: "m".into(), detail: "d".into() });
        let case = |trouble| Case { name: "c".into(), seconds: 0.5, trouble };
        let suites = [
            Suite { name: "a&b".into(), seconds: 1.0, cases: vec![case(None), case(trouble("failure"))] },
            Suite { name: "c".into(), seconds: 2.0, cases: vec![case(trouble("error"))] },
        ];
        let xml = document(&suites);
        let all = "<testsuites name=\"bvhc verify\" tests=\"3\" failures=\"1\" errors=\"1\" time=\"3.000\">";
        assert!(xml.contains(all), "{xml}");
        assert!(xml.contains("<testsuite name=\"a&amp;b\" tests=\"2\" failures=\"1\" errors=\"0\" time=\"1.000\">"));
        assert!(xml.contains("<failure type=\"k\" message=\"m\">d</failure>"));
    }
}
