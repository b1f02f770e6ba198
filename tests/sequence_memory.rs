//! What a sequence makes its reader hold follows from its length and the limit, whatever its frames show and whatever is wrong with them.

mod common;

use bvhc::cache::check::{Level, Limits, check_bytes};
use bvhc::cache::{CacheError, OpenOptions, Sequence, rules};
use bvhc::exec::Executor;
use bvhc::stability::heap::{self, Counting};
use common::vectors::sequences;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// One test for all: the counter sees every thread of the process.
#[test]
fn a_small_sequence_that_shows_much_makes_nobody_hold_much() {
    const POSES: usize = 3000;
    let sound = sequences::crowd(POSES);
    let mut broken = sound.clone();
    broken.triangles.iter_mut().for_each(|triangle| triangle.flags = 4);
    let (sound, broken) = (sound.file(), broken.file());
    let shown = POSES * 255 * 48;
    assert!(shown > 30 * sound.len(), "{} bytes show {shown}", sound.len());

    // Each pose breaks a rule 255 times.
    let check = || check_bytes(&broken, Level::Tree, None, &Limits::default(), &Executor::sequential());
    let (report, held) = heap::peak_of(check);
    assert_eq!(report.count(&rules::E0418), (POSES * 255) as u64);
    assert!(held < 2 * broken.len(), "the check of {} bytes holds {held}", broken.len());

    let options = OpenOptions { max_memory: 1 << 20, ..OpenOptions::default() };
    let open = || Sequence::from_slice(&sound, &options).unwrap().frame(0).map(drop);
    let (frame, held) = heap::peak_of(open);
    assert!(matches!(frame, Err(CacheError::Limit { .. })), "{frame:?}");
    assert!(held < sound.len() + (1 << 20), "opening {} bytes holds {held}", sound.len());
}
