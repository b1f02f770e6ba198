//! The documents say what is so: generated tables, command output, links, Rust.
//!
//! `BVHC_UPDATE_DOCS=1 cargo test --test cli documents` writes tables and output anew.

use crate::{Place, repository};
use bvhc::cli::commands::reference;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// README.md and the pages of `docs/`, as paths from the repository.
fn pages() -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> = std::fs::read_dir(repository().join("docs"))
        .unwrap()
        .map(|entry| Path::new("docs").join(entry.unwrap().file_name()))
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .collect();
    pages.sort();
    pages.insert(0, "README.md".into());
    pages
}

fn text_of(page: &Path) -> String {
    std::fs::read_to_string(repository().join(page)).unwrap_or_else(|e| panic!("{}: {e}", page.display()))
}

/// With `BVHC_UPDATE_DOCS`, write `new`; otherwise fail where it is not what stands there.
fn keep(page: &Path, old: &str, new: &str) {
    if old == new {
        return;
    }
    if std::env::var_os("BVHC_UPDATE_DOCS").is_some() {
        std::fs::write(repository().join(page), new).unwrap();
        return;
    }
    let (has, wants) = old.lines().zip(new.lines()).find(|(old, new)| old != new).unwrap_or_default();
    panic!(
        "{} is not up to date; run: BVHC_UPDATE_DOCS=1 cargo test --test cli documents\n  it has     {has}\n  it should  {wants}",
        page.display()
    );
}

/// Generated tables say what the code says, and `console` blocks show what their commands print; times and speeds may differ. The commands of
/// a page are run in a folder of their own.
#[test]
fn documents_are_up_to_date() {
    let mut commands = 0;
    for page in pages() {
        let old = text_of(&page);
        let tables = reference::updated(&old, &page).unwrap();
        let (new, run) = with_output(&tables);
        keep(&page, &old, &new);
        commands += run;
    }
    assert!(commands > 8, "only {commands} commands were found");
}

/// The page with what its commands print now, and how many they are.
fn with_output(text: &str) -> (String, usize) {
    let (place, mut new, mut commands) = (Place::new(), String::new(), 0);
    let mut lines = text.lines().peekable();
    let mut is_console = false;
    while let Some(line) = lines.next() {
        new.push_str(line);
        new.push('\n');
        if line.starts_with("```") {
            is_console = line == "```console";
        }
        let Some(command) = line.strip_prefix("$ ").filter(|_| is_console) else { continue };
        let mut shown = Vec::new();
        while let Some(next) = lines.next_if(|next| !next.starts_with("$ ") && !next.starts_with("```")) {
            shown.push(next.to_string());
        }
        // A line that differs in times alone stays as it is.
        for line in output(command, &place) {
            let same = shown.iter().find(|old| words(old) == words(&line));
            new.push_str(same.map_or(&line, |old| old));
            new.push('\n');
        }
        commands += 1;
    }
    (new, commands)
}

/// What `bvhc …`, perhaps cut off by `| head -N`, prints to stdout.
fn output(command: &str, place: &Place) -> Vec<String> {
    let (command, most) = match command.split_once(" | head -") {
        Some((command, most)) => (command, most.parse().unwrap()),
        None => (command, usize::MAX),
    };
    let args = command.strip_prefix("bvhc ").unwrap_or_else(|| panic!("only bvhc can be run: {command}"));
    for sample in args.split_whitespace().filter(|word| word.starts_with("samples/")) {
        // A pattern stands for all files of its folder.
        let files = match sample.rsplit_once('/').filter(|_| sample.contains('%')) {
            Some((folder, _)) => {
                std::fs::read_dir(repository().join(folder)).unwrap().map(|f| f.unwrap().path()).collect()
            }
            None => vec![repository().join(sample)],
        };
        for file in files.iter().filter(|file| file.is_file()) {
            place.write(file.strip_prefix(repository()).unwrap().to_str().unwrap(), std::fs::read(file).unwrap());
        }
    }
    place.ok(args).out.lines().take(most).map(str::to_string).collect()
}

/// A line's words, with `#` for what a clock says.
fn words(line: &str) -> Vec<&str> {
    let mut words: Vec<&str> = line.split_whitespace().collect();
    for i in 1..words.len() {
        if ["s", "ms", "M"].contains(&words[i]) && words[i - 1].parse::<f64>().is_ok() {
            words[i - 1] = "#";
        }
    }
    words
}

#[test]
fn documents_readme_is_short() {
    let text = text_of(Path::new("README.md"));
    assert!(text.lines().count() <= 200, "README.md has {} lines; move what is special to docs/", text.lines().count());
}

/// Rust in documents is compiled by `cargo test --doc`, which sees only what `src/lib.rs` includes; a block without a language would be taken
/// for Rust.
#[test]
fn documents_with_rust_are_doc_tests() {
    let lib = text_of(Path::new("src/lib.rs"));
    for page in pages() {
        let text = text_of(&page);
        let mut is_open = false;
        for line in text.lines().filter(|line| line.trim_start().starts_with("```")) {
            is_open = !is_open;
            assert!(!is_open || line.trim_start().len() > 3, "{}: a block has no language", page.display());
        }
        if text.contains("```rust") {
            let include = format!("include_str!(\"../{}\")", page.display());
            assert!(lib.contains(&include), "src/lib.rs must have #[doc = {include}]");
        }
    }
}

#[test]
fn documents_links_lead_somewhere() {
    let mut all = pages();
    let others = [
        "CONTRIBUTING.md",
        "SECURITY.md",
        "CHANGELOG.md",
        "format-spec/SPEC.md",
        "format-spec/README.md",
        "samples/README.md",
        "benches/peers.md",
        "crates/bvhc-core/README.md",
    ];
    all.extend(others.map(PathBuf::from));
    let mut links = 0;
    for page in all {
        for target in targets(&text_of(&page)).iter().filter(|t| !t.contains("://") && !t.starts_with("mailto:")) {
            let (file, anchor) = target.split_once('#').map_or((target.as_str(), None), |(f, a)| (f, Some(a)));
            let folder = repository().join(&page).parent().unwrap().to_owned();
            let path = if file.is_empty() { repository().join(&page) } else { folder.join(file) };
            assert!(path.exists(), "{} links to {target}, which is not there", page.display());
            if let Some(anchor) = anchor {
                let text = std::fs::read_to_string(&path).unwrap();
                assert!(anchors(&text).contains(anchor), "{} links to {target}: no such heading", page.display());
            }
            links += 1;
        }
    }
    assert!(links > 40, "only {links} links were found");
}

/// Where the inline links of a page lead.
fn targets(text: &str) -> Vec<String> {
    let mut targets = Vec::new();
    let mut is_code = false;
    for line in text.lines() {
        is_code ^= line.trim_start().starts_with("```");
        let parts = line.split("](").skip(1).filter(|_| !is_code);
        targets.extend(parts.filter_map(|part| Some(part.split_once(')')?.0.to_string())));
    }
    targets
}

/// The anchors that the usual hosts give a page's headings.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut anchors = BTreeSet::new();
    let mut is_code = false;
    for line in text.lines() {
        is_code ^= line.starts_with("```");
        if line.starts_with('#') && !is_code {
            let heading = line.trim_start_matches('#').trim().to_lowercase();
            let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            anchors.insert(kept.map(|c| if c == ' ' { '-' } else { c }).collect());
        }
    }
    anchors
}

#[test]
fn the_page_of_rules_has_a_row_for_each_rule() {
    let text = text_of(Path::new("docs/rules.md"));
    let first = |line: &str| bvhc::cache::rules::find(line.strip_prefix("| ")?.get(..5)?).map(|rule| rule.id);
    let rows: Vec<&str> = text.lines().filter_map(first).collect();
    let rules: Vec<&str> = bvhc::cache::rules::all().map(|rule| rule.id).collect();
    assert_eq!(rows, rules);
}
