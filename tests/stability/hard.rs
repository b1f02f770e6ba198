//! What moves, and what is refused.

use super::{MOTIONS, REFUSED, alone, splits};
use bvhc::build::Executor;

#[test]
fn motions_are_hit_right_and_built_for_as_often_as_it_pays() {
    let _turn = alone();
    let exec = Executor::new(0).unwrap();
    for motion in &MOTIONS {
        let report = motion.judged(240, 120, &exec).unwrap();
        assert_eq!(report.broken(), None, "{report:#?}");
        let [auto, always, never] = &report.rows[..] else { panic!("{report:#?}") };
        assert!(auto.built <= never.built && always.built <= auto.built, "{report:#?}");
    }
}

/// The failure by name: a tree that is refitted whatever happens pays for large motion, and one that is built anew where that pays does not.
#[test]
fn refitting_alone_fails_after_large_motion() {
    let _turn = alone();
    let exec = Executor::new(0).unwrap();
    for name in ["F28", "F28-walk"] {
        let motion = MOTIONS.iter().find(|motion| motion.id == name).unwrap();
        let report = motion.judged(600, 200, &exec).unwrap();
        let [auto, always, _] = &report.rows[..] else { panic!("{report:#?}") };
        assert!(always.worst_over > 1.5 && auto.worst_over < always.worst_over, "{report:#?}");
    }
}

/// With splits, refitted: what was cut is whole again, so the gain is gone before anything has moved.
#[test]
fn spatial_splits_do_not_pay_once_they_are_refitted() {
    let _turn = alone();
    let report = splits(1500, 400, &Executor::new(0).unwrap()).unwrap();
    let [built, fitted, moved @ ..] = &report.over[..] else { panic!("{report:?}") };
    assert!(report.references > 1.1 && *fitted > 1.2 * built, "{report:?}");
    assert!(moved.iter().any(|over| *over > 1.2 * built), "{report:?}");
}

#[test]
fn what_cannot_be_built_or_followed_is_refused_in_words() {
    let _turn = alone();
    let exec = Executor::sequential();
    for refused in &REFUSED {
        let refusal = refused.tried(&exec);
        assert!(refusal.refusal.as_ref().is_some_and(|words| words.len() > 10), "{refusal:?}");
    }
}
