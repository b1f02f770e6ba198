//! Build keys are a promise: a file stays up to date as long as its key is the same. So each recipe's options are written as they always
//! were, in the same order; `golden/build_keys.txt` was written before there was a table of options.
//!
//! A method's revision is left out, since that is raised on purpose. A line changes only together with a method's revision.
//! `BVHC_UPDATE_DOCS=1 cargo test --test build_keys` adds the lines of a new method or option, and changes none.

use bvhc::build::{Axes, BuildOptions, Clip, HullBasis, Levels, METHODS, Preset, Purpose};
use bvhc::cache::keys::Recipe;

const GOLDEN: &str = include_str!("golden/build_keys.txt");

/// One recipe a line: what was asked for, the start of its key, and the options in it.
fn line(asked: &str, options: &BuildOptions) -> String {
    let recipe = Recipe { method: options.method.to_string(), builder_revision: 1, options: options.effective() };
    let key: String = recipe.build_key([])[..8].iter().map(|byte| format!("{byte:02x}")).collect();
    let named: Vec<String> = recipe.options.iter().map(|(name, value)| format!("{name} {value}")).collect();
    format!("{} {asked}: {key}: {}", options.method, named.join(", "))
}

/// What is set on top of a preset: every option alone, and all of them.
fn changes(base: &BuildOptions) -> Vec<(&'static str, BuildOptions)> {
    let base = || base.clone();
    vec![
        ("axes", BuildOptions { axes: Axes::Longest, ..base() }),
        ("bins", BuildOptions { bins: 17, ..base() }),
        ("spatial-bins", BuildOptions { spatial_bins: 256, ..base() }),
        ("radius", BuildOptions { radius: 3, ..base() }),
        ("basis", BuildOptions { basis: HullBasis::Leaf, ..base() }),
        ("presplit", BuildOptions { presplit: 0.3, ..base() }),
        ("max-leaf", BuildOptions { max_leaf: 255, ..base() }),
        ("sah-trav", BuildOptions { traversal_cost: 1e-3, ..base() }),
        ("sah-isect", BuildOptions { intersection_cost: 0.1 + 0.2, ..base() }),
        ("clip", BuildOptions { clip: Clip::Box, ..base() }),
        ("split-alpha", BuildOptions { split_alpha: 1e-7, ..base() }),
        ("split-alpha -0", BuildOptions { split_alpha: -0.0, ..base() }),
        ("split-budget", BuildOptions { split_budget: 64.0, ..base() }),
        ("unsplit", BuildOptions { unsplit: false, ..base() }),
        ("prune", BuildOptions { prune: 1e3, ..base() }),
        ("reinsert", BuildOptions { reinsert: 8, ..base() }),
        ("adapt", BuildOptions { adapt: 1 << 20, ..base() }),
        ("collapse", BuildOptions { collapse: true, ..base() }),
        ("levels", BuildOptions { levels: Levels::Two, ..base() }),
        ("rays-for", BuildOptions { purpose: Purpose::Bake, adapt: 64, ..base() }),
        (
            "all",
            BuildOptions {
                method: base().method,
                axes: Axes::Longest,
                bins: 2,
                spatial_bins: 3,
                radius: 31,
                basis: HullBasis::Leaf,
                presplit: 63.0,
                max_leaf: 1,
                traversal_cost: 1e3,
                intersection_cost: 1.0 / 3.0,
                clip: Clip::Box,
                split_alpha: 1.0,
                split_budget: 1.0,
                unsplit: false,
                prune: 0.0,
                reinsert: 1000,
                adapt: 1,
                collapse: true,
                levels: Levels::One,
                purpose: Purpose::Physics,
            },
        ),
    ]
}

#[test]
fn build_keys_are_what_they_were() {
    let mut lines = Vec::new();
    for row in METHODS {
        for (name, preset) in
            [("auto", Preset::Auto), ("draft", Preset::Draft), ("balanced", Preset::Balanced), ("best", Preset::Best)]
        {
            lines.push(line(
                &format!("on {name}"),
                &BuildOptions { method: row.method, ..BuildOptions::preset(preset) },
            ));
        }
        let base = BuildOptions { method: row.method, ..BuildOptions::default() };
        lines.extend(changes(&base).iter().map(|(change, options)| line(change, options)));
    }
    for (preset, name) in
        [(Preset::Auto, "auto"), (Preset::Draft, "draft"), (Preset::Balanced, "balanced"), (Preset::Best, "best")]
    {
        lines.push(line(&format!("as preset {name}"), &BuildOptions::preset(preset)));
    }
    // A line that stood there still stands there, whatever was added: a line is known by what stands before its key.
    let asked = |line: &str| line.split_once(": ").map(|(asked, _)| asked.to_owned());
    for then in GOLDEN.lines() {
        let now = lines.iter().find(|now| asked(now) == asked(then));
        assert_eq!(now.map(String::as_str), Some(then));
    }
    let new: String = lines.iter().flat_map(|line| [line, "\n"]).collect();
    if new != GOLDEN && std::env::var_os("BVHC_UPDATE_DOCS").is_some() {
        std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/build_keys.txt"), new).unwrap();
        return;
    }
    let added: Vec<&String> = lines.iter().filter(|now| !GOLDEN.lines().any(|then| then == *now)).collect();
    assert!(new == GOLDEN, "add these lines by BVHC_UPDATE_DOCS=1 cargo test --test build_keys: {added:#?}");
}
