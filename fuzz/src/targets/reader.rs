//! Opening at every level of validation, and tracing what was opened.

use super::{Target, limit};
use crate::guard::within;
use crate::mutate::file;
use crate::planted::Seen;
use bvhc::cache::{Between, Cache, CacheError, CompactNode, Frames, OpenOptions, Opened, Sequence, Validation, View};
use bvhc::geom::{Aabb, Ray};
use bvhc::trace::wide::WideView;
use bvhc::trace::{Hit, NoObserver, TurnedView, try_any_hit, try_closest_hit};

pub const TARGET: Target = Target { name: "reader", run, change: file::change, faults: &["E0403", "E0302", "E0205"] };

/// A copy where the bytes are not aligned, decoded sections up to the limit, and what a check of records notes for each record.
pub fn allowance(input: &[u8]) -> usize {
    3 * limit(input) as usize + 24 * input.len() + (1 << 20)
}

fn run(input: &[u8]) -> Seen {
    let mut seen = Seen::new();
    let mut opened_before = true;
    for validation in [Validation::Quick, Validation::Hash, Validation::Tree] {
        let options = OpenOptions { validation, max_memory: limit(input), ..OpenOptions::default() };
        match within(allowance(input), || Cache::from_slice(input, &options)) {
            Ok(cache) => {
                assert!(opened_before, "what a lower level refuses, a higher one opens");
                look(&cache);
                trace(&cache.view(), cache.header().scene_bounds(), validation == Validation::Tree);
            }
            Err(CacheError::Sequence { .. }) => {
                let frames = open_frames(input, &options);
                assert!(opened_before || frames.is_err(), "what a lower level refuses, a higher one opens");
                if let Err(error) = frames {
                    opened_before = false;
                    seen.push(error.to_string());
                }
            }
            Err(error) => {
                opened_before = false;
                seen.push(error.to_string());
            }
        }
    }
    seen
}

/// Frames that are looked at: a small file may show the same thousands of triangles in hundreds of them.
pub const MOST_FRAMES: usize = 8;

/// Open a sequence and its first frames, and trace what was opened. How many frames there are, or the first error.
pub fn open_frames(input: &[u8], options: &OpenOptions) -> Result<usize, CacheError> {
    let sequence = within(allowance(input), || Sequence::from_slice(input, options))?;
    look_at_rows(&sequence);
    for index in 0..sequence.frame_count().min(MOST_FRAMES) {
        let frame = within(allowance(input), || sequence.frame(index))?;
        trace(&frame.view(), sequence.header().scene_bounds(), options.validation == Validation::Tree);
        // What two frames must share, and what is asked of it where a single frame does not need it.
        match within(allowance(input), || sequence.between(0, index)) {
            Ok(between) => trace_between(&between, sequence.header().scene_bounds(), options.validation),
            Err(CacheError::Unlike { .. } | CacheError::Limit { .. }) => {}
            Err(error) => assert!(matches!(error.rule(), Some("E0504" | "E0705")), "both frames open: {error}"),
        }
    }
    assert!(sequence.frame(sequence.frame_count()).is_err(), "a frame behind the last");
    Ok(sequence.frame_count())
}

/// Ask for everything that the frames of a file share.
fn look_at_rows(sequence: &Frames) {
    let parts = sequence.geoms().len();
    let names = (0..parts).filter_map(|i| sequence.names().get(i)).map(str::len).sum::<usize>();
    let blocks: u64 = (0..sequence.block_count() + 1).map(|block| sequence.block_bytes(block)).sum();
    let found = sequence.frames().iter().filter(|frame| sequence.numbered(frame.number).is_some()).count();
    assert_eq!(found, sequence.frame_count(), "a frame is not found by its number");
    std::hint::black_box((names, blocks, sequence.vertices().len(), sequence.materials().len(), sequence.meta()));
}

/// Ask for everything that a file has.
fn look(cache: &Opened) {
    let parts = cache.geoms().len();
    let names = (0..parts).filter_map(|i| cache.names().get(i)).map(str::len).sum::<usize>();
    let stored: usize = (0..cache.sections().len() + 1).map(|i| cache.stored_bytes(i).len()).sum();
    let raw: usize = (0..cache.sections().len() + 1).filter_map(|i| cache.section_bytes(i)).map(<[u8]>::len).sum();
    let noted = cache.meta().map_or(0, |m| m.dependencies.len() + m.notes.len());
    let trees = (0..cache.blases().len() + 1).filter_map(|i| cache.view().blas(i)).count();
    std::hint::black_box((names, stored, raw, noted, trees));
}

/// As [`trace`], at a few times between two frames.
fn trace_between(between: &Between<'_>, b: Aabb, validation: Validation) {
    for i in 0..4u32 {
        let at = |a: usize, s: f32| b.min[a] + (b.max[a] - b.min[a]) * s;
        let from = [at(0, 0.1 * i as f32), at(1, 0.3), at(2, 1.1)];
        let to = [at(0, 0.5), at(1, 0.2 * i as f32), at(2, 0.4)];
        let ray = Ray::new(from, [0, 1, 2].map(|a| to[a] - from[a]));
        for time in [0.0, 0.3, 1.0] {
            let (closest, any) = (between.closest_hit(&ray, time), between.any_hit(&ray, time));
            let valid = validation == Validation::Tree;
            assert!(!valid || closest.is_ok() && any.is_ok(), "the reader says valid, the traversal: {closest:?}");
            if let (true, Ok(closest), Ok(any)) = (valid, &closest, &any) {
                assert_eq!(closest.is_some(), *any, "the nearest hit and any hit differ on {ray:?} at {time}");
            }
            _ = closest.ok().flatten().and_then(|hit| between.normal(&hit, time));
        }
    }
}

/// Rays through the compact trees of a file whose every record was looked at hit what they hit in the binary ones.
pub fn trace_compact(trees: &WideView<'_, 8, CompactNode>, b: Aabb) {
    let named = |hit: Hit| (hit.t.to_bits(), hit.geom, hit.prim, hit.instance);
    for ray in net(b) {
        let want = try_closest_hit(&trees.view, &ray, &mut NoObserver).map(|hit| hit.map(named));
        assert_eq!(trees.closest_hit(&ray).map(|hit| hit.map(named)), want, "{ray:?}");
        assert_eq!(trees.any_hit(&ray), want.map(|hit| hit.is_some()), "{ray:?}");
    }
}

/// The same through turned subtrees.
pub fn trace_turned(turned: &TurnedView<'_>, b: Aabb) {
    let named = |hit: Hit| (hit.t.to_bits(), hit.geom, hit.prim);
    for ray in net(b) {
        let want = try_closest_hit(&turned.view, &ray, &mut NoObserver).map(|hit| hit.map(named));
        assert_eq!(turned.closest_hit(&ray).map(|hit| hit.map(named)), want, "{ray:?}");
        assert_eq!(turned.any_hit(&ray), want.map(|hit| hit.is_some()), "{ray:?}");
    }
}

/// A fixed net of rays from one side of a box to another point in it.
fn net(b: Aabb) -> impl Iterator<Item = Ray> {
    (0..8u32).map(move |i| {
        let share = |k: u32| (i.wrapping_mul(k) % 61) as f32 / 60.0;
        let at = |a: usize, s: f32| b.min[a] + (b.max[a] - b.min[a]) * s;
        let from = [at(0, share(7)), at(1, share(11)), at(2, share(13))];
        let to = [at(0, share(17)), at(1, share(19)), at(2, share(23))];
        Ray::new(from, [0, 1, 2].map(|a| to[a] - from[a]))
    })
}

/// Rays through whatever was opened end; through a file whose every record was looked at, they end without an error.
pub fn trace(view: &View<'_>, b: Aabb, valid: bool) {
    for ray in net(b) {
        let closest = try_closest_hit(view, &ray, &mut NoObserver);
        let any = try_any_hit(view, &ray, &mut NoObserver);
        assert!(!valid || closest.is_ok() && any.is_ok(), "the reader says valid, the traversal: {closest:?}");
        if let (true, Ok(closest), Ok(any)) = (valid, &closest, &any) {
            assert_eq!(closest.is_some(), *any, "the nearest hit and any hit differ on {ray:?}");
        }
    }
}
