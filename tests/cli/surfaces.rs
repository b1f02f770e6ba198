//! Help, man pages, completions: all from one definition, and all saying the same.

use crate::Place;
use bvhc::build::{OPTIONS, Spelling};
use bvhc::cli::commands::man;
use bvhc::cli::exit::{Exit, help_table, markdown_table};

#[test]
fn help_and_man_page_carry_the_table_of_exit_codes() {
    let place = Place::new();
    for flag in ["-h", "--help"] {
        assert!(place.ok(flag).out.contains(&help_table()), "{flag}");
    }
    place.ok("man --out pages");
    let page = String::from_utf8(place.read("pages/bvhc.1"))
        .unwrap()
        .replace("\\-", "-")
        .replace("\\(aq", "'")
        .replace("\\&", "");
    for exit in Exit::ALL {
        assert!(page.contains(&exit.code().to_string()) && page.contains(exit.meaning()), "{exit:?} in {page}");
    }
}

#[test]
fn the_table_lists_each_code_once() {
    let table = markdown_table();
    for exit in Exit::ALL {
        assert_eq!(table.matches(&format!("| {} | {} |", exit.code(), exit.name())).count(), 1);
    }
}

#[test]
fn every_command_has_help_examples_and_a_man_page() {
    let place = Place::new();
    let written = place.ok("man --out pages").out;
    for command in
        ["build", "info", "stats", "check", "verify", "view", "chart", "convert", "explain", "completions", "man"]
    {
        let help = place.ok(&format!("{command} --help")).out;
        assert!(help.contains("Usage: bvhc "), "{help}");
        assert!(written.contains(&format!("bvhc-{command}.1")), "{written}");
        let page = String::from_utf8(place.read(&format!("pages/bvhc-{command}.1"))).unwrap();
        assert!(page.contains(".SH NAME") && page.contains(".SH SYNOPSIS"));
    }
    assert_eq!(man::pages().unwrap().len(), written.lines().count());
}

#[test]
fn build_help_shows_what_the_presets_stand_for() {
    let help = Place::new().ok("build --help").out;
    let squeezed: String = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for preset in ["draft", "balanced", "best"] {
        assert!(squeezed.contains(&format!("{preset}: --method ")), "{help}");
    }
}

#[test]
fn completions_for_every_shell_know_the_flags() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = place.ok(&format!("completions {shell}")).out;
        assert!(script.contains("split-budget"), "{shell}");
    }
    assert_eq!(place.run("completions tcsh").code, 2);
}

#[test]
fn usage_errors_are_2_and_suggest() {
    let place = Place::new();
    for args in ["", "nonsense", "build", "info", "check --level deep x", "build a.obj -o b --bins 1", "stats -q -v x"]
    {
        assert_eq!(place.run(args).code, 2, "bvhc {args}");
    }
    assert!(place.run("build a.obj -o b --split-budgit 3").err.contains("--split-budget"));
}

/// What `-O help` says of each option, and that an option without a flag is still found by who types one.
#[test]
fn options_without_a_flag_are_listed_and_told_how_to_set() {
    let place = Place::new();
    let list = place.ok("build -O help").out;
    let squeezed: String = list.split_whitespace().collect::<Vec<_>>().join(" ");
    for row in OPTIONS {
        let readers = row.readers_in_words();
        for part in [format!("{}={}", row.name, row.placeholder), row.kind.range(), format!("read by: {readers}]")] {
            assert!(squeezed.contains(&part), "{part} in {list}");
        }
        let help = place.ok("build -h").out;
        let flag = format!("--{} <{}>", row.name, row.placeholder);
        assert_eq!(help.contains(&flag), row.spelling == Spelling::Flag, "{}", row.name);
        // `--clip` is a flag of another meaning.
        if row.spelling == Spelling::Setting && !help.contains(&format!("--{} <", row.name)) {
            let said = place.run(&format!("build a.obj -o a.bvhc --{} 3", row.name));
            assert_eq!(said.code, 2);
            assert!(said.err.contains(&format!("help: write -O {}=", row.name)), "{}", said.err);
        }
    }
    let help = |args: &str| place.run(&format!("build a.obj -o a.bvhc {args}")).err;
    assert!(help("--no-unsplit").contains("write -O unsplit=false;"), "{}", help("--no-unsplit"));
    assert!(help("--collapse").contains("write -O collapse=true;"), "{}", help("--collapse"));
    assert!(help("--max-leav=3").contains("write -O max-leaf=N;"), "{}", help("--max-leav=3"));
    assert!(help("--json --radius 3").contains(r#""exit_name":"usage""#), "{}", help("--json --radius 3"));
    assert!(!place.run("info --radius 3 a").err.contains("-O"), "info has no options of trees");
}
