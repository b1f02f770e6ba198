//! Forged cache files of the folder of cases: which rules each breaks, as `check` and `stats` say it.

use super::{files_below, judge};
use crate::common::cases_dir;
use crate::{Place, Said, said};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Run a command that may not end; after 20 seconds it is ended, and has no exit code.
fn in_time(place: &Place, args: &str) -> Said {
    let mut command = place.command();
    command.args(args.split(' ')).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(20) {
            child.kill().unwrap();
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    said(child.wait_with_output().unwrap())
}

/// What each forged file breaks. The program's memory is limited by `forged::forged_files_are_refused_at_once_and_in_little_memory`.
const FORGED: [(&str, &[&str]); 11] = [
    ("ladder", &["E0404", "E0409"]),
    ("lad16", &["E0404", "E0409"]),
    ("lad20", &["E0404", "E0409"]),
    ("leafhuge", &["E0410"]),
    ("leafoverlap", &["E0409", "E0408"]),
    ("cycle", &["E0402"]),
    ("nanbox", &["E0412"]),
    ("infbox", &["E0412"]),
    ("bomb2", &["E0311"]),
    ("hole_small", &["E0425", "E0434"]),
    ("hole_big", &["E0425", "E0434"]),
];

#[test]
fn forged_files_break_the_rules_that_they_are_known_to_break() {
    let Some(cases) = cases_dir() else { return };
    let place = Place::new();
    let files = files_below(&cases.join("forged"));
    let stem = |file: &Path| file.file_stem().unwrap().to_str().unwrap().to_owned();
    for file in &files {
        assert!(FORGED.iter().any(|f| f.0 == stem(file)), "{} is not in the table", stem(file));
    }
    judge(
        &FORGED,
        |(name, _)| format!("forged/{name}.bvhc"),
        |(name, rules)| {
            let file = files.iter().find(|file| stem(file) == *name).expect("the file is in the folder");
            place.write("a.bvhc", std::fs::read(file).unwrap());
            for command in ["check a.bvhc", "stats a.bvhc"] {
                let said = in_time(&place, command);
                let text = format!("{}{}", said.out, said.err);
                assert_eq!(said.code, 1, "{command} of {name}: {text}");
                assert!(rules.iter().any(|rule| text.contains(rule)), "{command} of {name}: {text}");
            }
            assert!(in_time(&place, "stats a.bvhc").out.is_empty(), "figures of {name}");
        },
    );
}
