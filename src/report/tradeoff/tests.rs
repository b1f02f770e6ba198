//! Contests that are cut short, and what searches chose.

use super::measure::chosen;
use super::*;
use crate::build::{BuildOptions, Preset};
use crate::exec::Executor;
use crate::scene::{ReadOptions, read};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Interrupts after so many steps.
struct After(AtomicU32);

impl Watch for After {
    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::SeqCst) == 0
    }

    fn step(&self, _recipe: &str, _round: u32, _done: u64, _of: u64) {
        let left = self.0.load(Ordering::SeqCst);
        self.0.store(left.saturating_sub(1), Ordering::SeqCst);
    }
}

fn recipes() -> Vec<Recipe> {
    let preset = |(preset, name): (Preset, &str)| Recipe {
        name: name.to_string(),
        origin: Origin::Preset,
        flags: String::new(),
        options: BuildOptions::preset(preset),
    };
    [(Preset::Auto, "auto"), (Preset::Balanced, "balanced"), (Preset::Draft, "draft")].map(preset).to_vec()
}

fn measured(recipes: &[Recipe], budget: Duration, rounds: u32, steps: u32) -> TradeOff {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/helicopter/heli.0001.obj");
    let (scene, exec) = (read(&path, &ReadOptions::default()).unwrap(), Executor::sequential());
    let effort = Effort { rays: 64, rounds, until: Instant::now() + budget };
    let watch = After(AtomicU32::new(steps));
    let mut contest = Contest::new(&scene, recipes, effort, &exec, &watch);
    contest.first_round(&|options| format!("as {}", options.method)).unwrap();
    assert_eq!(contest.kept().is_some(), steps > 1);
    contest.more_rounds();
    contest.finish()
}

#[test]
fn what_a_search_chose_costs_what_the_search_costs_and_builds_without_it() {
    let all = measured(&recipes(), Duration::from_secs(600), 2, 1000);
    let names: Vec<&str> = all.recipes.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names, ["draft", "balanced", "auto", "auto's choice"]);
    assert!(all.left_out.is_empty() && all.recipes.iter().all(|row| row.build.rounds == 2), "{all:?}");
    let (auto, choice) = (&all.recipes[2], &all.recipes[3]);
    assert_eq!((auto.rays.cost, auto.nodes, auto.references), (choice.rays.cost, choice.nodes, choice.references));
    assert_eq!((choice.origin, &choice.chosen_by[..]), (Origin::Choice, &["auto".to_string()][..]));
    assert!(choice.flags.starts_with("as ") && all.recipes.iter().any(|row| row.front));

    // Where the list has it, it is marked there.
    let listed = chosen(&auto.notes).unwrap();
    let named = Recipe { name: "mine".into(), origin: Origin::Given, flags: String::new(), options: listed };
    let again = measured(&[recipes(), vec![named]].concat(), Duration::from_secs(600), 1, 1000);
    let mine = again.recipes.iter().find(|row| row.name == "mine").unwrap();
    assert_eq!((again.recipes.len(), &mine.chosen_by[..]), (4, &["auto".to_string()][..]));
}

#[test]
fn without_time_the_quickest_is_measured_and_the_others_are_told() {
    let all = measured(&recipes(), Duration::ZERO, 5, 1000);
    let left: Vec<(&str, &Reason)> = all.left_out.iter().map(|l| (l.name.as_str(), &l.reason)).collect();
    assert_eq!(all.recipes.len(), 1);
    assert_eq!((all.recipes[0].name.as_str(), all.recipes[0].build.rounds), ("draft", 1));
    assert_eq!(left, [("balanced", &Reason::Budget), ("auto", &Reason::Budget)]);
}

#[test]
fn what_was_measured_before_an_interruption_stays() {
    let all = measured(&recipes(), Duration::from_secs(600), 5, 2);
    assert_eq!((all.recipes.len(), all.left_out.len()), (1, 2), "{all:?}");
    assert!(all.left_out.iter().all(|l| l.reason == Reason::Interrupted));
    assert!(measured(&recipes(), Duration::from_secs(600), 5, 1).recipes.is_empty());
}

#[test]
fn a_choice_for_several_trees_is_none() {
    let note = |text: &str| vec![text.to_string()];
    assert_eq!(chosen(&note("auto: without the search: method=sweep max-leaf=4")).unwrap().max_leaf, 4);
    for odd in ["auto, tree 3: without the search: method=sweep", "auto: without the search: sweep", "auto: took it"] {
        assert!(chosen(&note(odd)).is_none(), "{odd}");
    }
}
