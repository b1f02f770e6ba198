//! What clap says only in part: why two flags do not go together.

use super::exit::Exit;
use super::failure::Failure;
use clap::ArgMatches;
use clap::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::parser::ValueSource;

/// Why a flag does not go with some others. In what helps, `{other}` is the other flag that was typed.
struct Conflict {
    flag: &'static str,
    others: &'static [&'static str],
    why: &'static str,
    help: &'static str,
}

const OTHER: &str = "leave out {other}";
const TAKE_OUT: &str = "take a frame out as a still file: bvhc convert FILE -o STILL --frame N";

const CONFLICTS: [Conflict; 35] = [
    row("--quiet", &["--verbose"], "one asks for fewer words and the other for more", "leave out --quiet"),
    // build
    row("--fps", &["--time"], "a clip is played as many frames, or posed at one time", "leave out --time"),
    row("--play", &["--time"], "a clip is played as many frames, or posed at one time", "leave out --time"),
    row(
        "--at-rest",
        &["--clip", "--time", "--fps", "--play"],
        "one leaves a model at rest and the other poses it by a clip",
        OTHER,
    ),
    row("--keyframe-every", &["--trees"], "keyframes imply --trees first", "leave out --trees"),
    row("--flatten", &["--levels"], "--flatten is short for --levels one", "leave out --flatten"),
    row(
        "--depfile-dir",
        &["--depfile"],
        "one names a file and the other a folder for all of them",
        "leave out --depfile",
    ),
    row(
        "--depfile-dir",
        &["--depfile-target"],
        "each depfile has the target that is its output",
        "leave out --depfile-target",
    ),
    // stats, info, explain
    row("--csv", &["--json"], "both are forms of what is printed", "leave out --csv"),
    row("--frames", &["--epo", "--depths"], "the frames of a sequence are told by a row each", OTHER),
    row(
        "--csv",
        &["--depths"],
        "a line of comma-separated values is told of each file, and of no depth",
        "leave out --csv",
    ),
    row("--compare", &["--csv"], "what changed is told as text or as --json", OTHER),
    row(
        "--compare",
        &["--frames", "--depths"],
        "what changed is told a figure a row, of a sequence over all its frames",
        OTHER,
    ),
    row("--field", &["--sections", "--json"], "--field prints one value and nothing else", OTHER),
    row("--list", &["ID"], "--list shows every rule", "leave out --list"),
    // chart, convert
    row(
        "--stability",
        &["MODEL", "--recipe", "--peer"],
        "the scenes that builders fail on are built by a list of recipes",
        OTHER,
    ),
    row(
        "--stability",
        &["--degenerate", "--allow-outside", "--scene", "--clip", "--time", "--ignore-extension"],
        "its scenes are made, and no file is read",
        OTHER,
    ),
    row(
        "--stability",
        &["--accuracy-rays"],
        "the hits of one arithmetic are judged there, by a share of --rays",
        OTHER,
    ),
    row("--markdown", &["--json"], "both are forms of what is printed", "leave out --markdown"),
    row("--drop-meta", &["--frame"], "a frame is taken out with META of its own", "leave out --drop-meta"),
    row("--strip-unknown", &["--frame"], "a frame is taken out with known sections alone", "leave out --strip-unknown"),
    // view
    row("--html", &["--output", "--tree", "--terminal"], "a run makes a page, a picture or an outline", OTHER),
    row(
        "--html",
        &["--shade", "--size", "--samples", "--scale", "--boxes"],
        "whoever reads the page chooses that in the browser",
        OTHER,
    ),
    row(
        "--no-browser",
        &["--output", "--html", "--tree", "--terminal", "--json"],
        "a browser is started for a page that is served, and nothing else is",
        "leave out --no-browser",
    ),
    row(
        "--serve",
        &["--output", "--html", "--tree", "--terminal"],
        "a run serves a page or makes something else",
        OTHER,
    ),
    row(
        "--serve",
        &["--shade", "--size", "--samples", "--scale", "--boxes", "--json"],
        "whoever reads the page chooses that in the browser",
        OTHER,
    ),
    row("--tree", &["--output", "--terminal"], "a run makes a picture or an outline", OTHER),
    row("--terminal", &["--json"], "a picture and a document would be printed in one place", "leave out --terminal"),
    row(
        "--tree",
        &["--shade", "--camera", "--up", "--size", "--samples", "--scale", "--boxes"],
        "an outline is text, and that is about pictures",
        OTHER,
    ),
    row("--compare", &["--tree", "--root"], "two files are compared as pictures of all that is in them", OTHER),
    // verify
    row(
        "--list-devices",
        &[
            "FILE",
            "--source",
            "--frame",
            "--device",
            "--rays",
            "--seed",
            "--rays-from",
            "--any-hit",
            "--reference",
            "--judge",
            "--junit",
            "--ray",
        ],
        "devices are listed, and nothing is traced",
        OTHER,
    ),
    row(
        "--frame",
        &["--source"],
        "each frame is verified against its own triangles; a model is one moment of them",
        TAKE_OUT,
    ),
    row("--frame", &["--ray", "--accuracy"], "that is asked of still files", TAKE_OUT),
    row(
        "--ray",
        &["--rays", "--seed", "--rays-from", "--any-hit", "--reference", "--judge", "--junit"],
        "one ray is given and told of, and no others are made",
        OTHER,
    ),
    row(
        "--accuracy",
        &[
            "--device",
            "--list-devices",
            "--require-device",
            "--rays-from",
            "--any-hit",
            "--reference",
            "--judge",
            "--device-timeout",
            "--junit",
            "--ray",
        ],
        "arithmetics are compared on the CPU, by rays of their own",
        OTHER,
    ),
];

/// Flags that only another one reads: the command, the flag, and the other one. clap asks for the other only where nothing that was typed conflicts with it.
const READ_ONLY_WITH: [(&str, &str, &str); 7] = [
    ("build", "--exit-code", "--dry-run"),
    ("build", "--depfile-target", "--depfile"),
    ("stats", "--against-fresh", "--frames"),
    ("stats", "--svg", "--frames"),
    ("stats", "--fail-if", "--compare"),
    ("view", "--depth", "--tree"),
    ("verify", "--svg", "--accuracy"),
];

/// Refuse a flag whose partner was not typed, where clap does not.
pub fn without_partner(matches: &ArgMatches) -> Result<(), Failure> {
    let Some((command, matches)) = matches.subcommand() else { return Ok(()) };
    let is_typed = |flag: &str| {
        let definition = super::command();
        let command = definition.find_subcommand(command);
        let arg = command.and_then(|c| c.get_arguments().find(|arg| arg.get_long() == flag.strip_prefix("--")));
        arg.is_some_and(|arg| matches.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine))
    };
    let alone = READ_ONLY_WITH.iter().find(|(of, flag, other)| *of == command && is_typed(flag) && !is_typed(other));
    alone.map_or(Ok(()), |(_, flag, other)| {
        Err(Failure::new(Exit::Usage, format!("cannot take {flag} without {other}"))
            .fact(format!("nothing but {other} reads it"))
            .help(format!("leave out {flag}, or add {other}")))
    })
}

const fn row(flag: &'static str, others: &'static [&'static str], why: &'static str, help: &'static str) -> Conflict {
    Conflict { flag, others, why, help }
}

/// What is said instead of clap's own words, if there is more to say.
pub fn instead_of(error: &Error) -> Option<Failure> {
    if error.kind() == ErrorKind::ArgumentConflict { conflict(error) } else { None }
}

fn conflict(error: &Error) -> Option<Failure> {
    let words = |kind| match error.get(kind) {
        Some(ContextValue::String(one)) => vec![name(one)],
        Some(ContextValue::Strings(several)) => several.iter().map(|one| name(one)).collect(),
        _ => Vec::new(),
    };
    let typed = words(ContextKind::InvalidArg).into_iter().next()?;
    let other = words(ContextKind::PriorArg).into_iter().next().unwrap_or_else(|| typed.clone());
    if typed == other {
        return Some(Failure::new(Exit::Usage, format!("cannot take {typed} twice")).help("give it once"));
    }
    let (why, help) = told(&typed, &other)?;
    Some(Failure::new(Exit::Usage, format!("cannot take {typed} together with {other}")).fact(why).help(help))
}

/// Why two flags do not go together, and what helps.
fn told(a: &str, b: &str) -> Option<(&'static str, String)> {
    [(a, b), (b, a)].into_iter().find_map(|(flag, other)| {
        let row = CONFLICTS.iter().find(|row| row.flag == flag && row.others.contains(&other))?;
        Some((row.why, row.help.replace("{other}", other)))
    })
}

/// `--frame <all|LIST>` as `--frame`, `--stability[=<SCENES>]` as `--stability`, `[ID]...` as `ID`.
fn name(shown: &str) -> String {
    let shown = if shown.starts_with('-') { shown.split(['[', '=']).next().unwrap_or_default() } else { shown };
    shown.split(' ').next().unwrap_or_default().trim_matches(['<', '>', '[', ']', '.']).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Arg, Command};

    fn shown(arg: &Arg) -> String {
        arg.get_long().map_or_else(|| name(&arg.to_string()), |long| format!("--{long}"))
    }

    #[test]
    fn every_conflict_says_why_and_what_to_do() {
        let mut whole = crate::cli::command();
        whole.build();
        let visible = |command: &&Command| !command.is_hide_set();
        let mut pairs = 0;
        for command in std::iter::once(&whole).chain(whole.get_subcommands().filter(visible)) {
            // Global flags are asked by another call of clap, which wants the whole command.
            for arg in command.get_arguments().filter(|arg| !arg.is_global_set()) {
                for other in command.get_arg_conflicts_with(arg) {
                    pairs += 1;
                    let (a, b) = (shown(arg), shown(other));
                    assert!(told(&a, &b).is_some(), "{}: {a} and {b}", command.get_name());
                }
            }
        }
        assert!(pairs > 40, "{pairs}");
        assert!(told("--quiet", "--verbose").is_some());
    }

    #[test]
    fn a_flag_without_its_partner_is_refused_beside_what_conflicts_with_the_partner() {
        let said = |line: &str| {
            let words = line.split(' ').map(std::ffi::OsString::from);
            without_partner(&crate::cli::command().try_get_matches_from(words).unwrap())
        };
        for (line, flag) in [
            ("bvhc view a.bvhc -o a.png --depth 2", "--depth"),
            ("bvhc verify a.bvhc --junit a.xml --svg a.svg", "--svg"),
            ("bvhc stats a.bvhc --csv --fail-if depth>4", "--fail-if"),
        ] {
            let text = said(line).unwrap_err().to_text(str::to_string);
            assert!(text.contains(&format!("cannot take {flag} without")), "{text}");
        }
        for line in ["bvhc view a.bvhc --tree --depth 2", "bvhc verify a.bvhc --accuracy --svg a.svg", "bvhc info a"] {
            assert!(said(line).is_ok(), "{line}");
        }
        // Each is spelled as it is in its command.
        let definition = crate::cli::command();
        for (command, flag, other) in READ_ONLY_WITH {
            let command = definition.find_subcommand(command).unwrap();
            for flag in [flag, other] {
                assert!(command.get_arguments().any(|arg| arg.get_long() == flag.strip_prefix("--")), "{flag}");
            }
        }
    }

    #[test]
    fn help_names_the_flag_to_leave_out() {
        let help = |a, b| told(a, b).unwrap().1;
        assert_eq!(help("--seed", "--ray"), "leave out --seed");
        assert_eq!(help("--ray", "--seed"), "leave out --seed");
        assert_eq!(help("--frame", "--drop-meta"), "leave out --drop-meta");
        assert_eq!(told("--ray", "--fps"), None);
        assert_eq!(
            ["--stability[=<SCENES>]", "[MODEL]...", "--frame <N>"].map(name),
            ["--stability", "MODEL", "--frame"]
        );
    }
}
