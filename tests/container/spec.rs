//! The specification says what the code does.

use bvhc::cache::rules;

const SPEC: &str = include_str!("../../format-spec/SPEC.md");

#[allow(dead_code)]
#[path = "../../examples/hexdump.rs"]
mod hexdump;

#[test]
fn the_worked_example_is_what_the_command_prints() {
    let dump = hexdump::annotate(&hexdump::one_triangle().unwrap()).unwrap();
    assert!(SPEC.contains(&dump), "paste the output of `cargo run --example hexdump` into section 14:\n{dump}");
}

#[test]
fn every_rule_is_named_where_it_is_demanded() {
    let missing: Vec<_> = rules::all().map(|r| r.id).filter(|id| !SPEC.contains(id)).collect();
    assert!(missing.is_empty(), "{missing:?}");
    let numbers = SPEC.match_indices(['E', 'W']).filter_map(|(i, _)| SPEC.get(i..i + 5));
    for id in numbers.filter(|n| n[1..].bytes().all(|b| b.is_ascii_digit())) {
        assert!(rules::find(id).is_some(), "the specification names {id}, which is no rule");
    }
}
