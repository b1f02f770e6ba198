//! Records damaged at random under hashes that are right.

use super::*;

/// Damage records at random, make every hash right again, and check: nothing panics or hangs, and what is called valid can be
/// traced.
fn damage_and_repair(rounds: usize, seed: u64) {
    let vectors: Vec<Vec<u8>> = valid::all().into_iter().map(|v| v.bytes).collect();
    let mut dice = Dice(seed);
    let mut accepted = 0;
    for round in 0..rounds {
        let mut bytes = vectors[dice.below(vectors.len())].clone();
        let entries = vectors_bytes::entries(&bytes);
        for _ in 0..1 + dice.below(4) {
            // Mostly records, sometimes the table and the header; whole words as often as bits.
            let entry = entries.get(dice.below(entries.len())).filter(|e| e.stored_len >= 4 && dice.below(8) != 0);
            let (from, len) = match entry {
                Some(e) => (e.offset as usize, e.stored_len as usize),
                None => (0, 256 + 128 * entries.len()),
            };
            let at = (from + dice.below(len / 4) * 4).min(bytes.len() - 4);
            let word = match dice.below(6) {
                0 => dice.roll() as u32,
                1 => dice.below(70) as u32,
                2 => u32::MAX - dice.below(3) as u32,
                3 => f32::NAN.to_bits(),
                4 => u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()).wrapping_add(1),
                _ => u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) ^ 1 << dice.below(32),
            };
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        let bytes = vectors_bytes::refix(bytes);
        let limits = Limits { max_memory: 64 << 20, ..Limits::default() };
        let report = check_bytes(&bytes, Level::Tree, None, &limits, &Executor::current());
        if report.is_valid() {
            accepted += 1;
            trace_some(&bytes, &mut dice, round);
        }
        trace_compact(&bytes, report.is_valid(), &mut dice, round);
        trace_turned(&bytes, report.is_valid(), &mut dice, round);
    }
    println!("{accepted} of {rounds} damaged files are still valid");
}

#[test]
fn damaged_and_repaired_files_never_panic() {
    damage_and_repair(2_000, 3);
}

#[test]
#[ignore = "long: 200 000 damaged and repaired files"]
fn long_damaged_and_repaired_files_never_panic() {
    damage_and_repair(200_000, 11);
}

/// Sixty-four rays through a file that the check calls valid.
fn trace_some(bytes: &[u8], dice: &mut Dice, round: usize) {
    let options = OpenOptions { max_memory: 64 << 20, ..OpenOptions::default() };
    let bounds = vectors_bytes::header(bytes).scene_bounds();
    if vectors_bytes::header(bytes).has(tree_flags::SEQUENCE) {
        let options = OpenOptions { validation: Validation::Tree, ..options };
        let sequence = Sequence::from_slice(bytes, &options);
        let sequence = sequence.unwrap_or_else(|e| panic!("round {round}: the check says valid, the reader: {e}"));
        for number in 0..sequence.frame_count() {
            let frame = sequence.frame(number);
            let frame = frame.unwrap_or_else(|e| panic!("round {round}: the check says valid, the reader: {e}"));
            trace_view(&frame.view(), bounds, 64 / sequence.frame_count().min(64), dice, round);
            match sequence.between(number, (number + 1) % sequence.frame_count()) {
                Ok(between) => trace_between(&between, bounds, dice, round),
                Err(error) => assert!(matches!(error, CacheError::Unlike { .. }), "round {round}: {error}"),
            }
        }
        return;
    }
    let cache = Cache::from_bytes(bytes, &options);
    let cache = cache.unwrap_or_else(|e| panic!("round {round}: the check says valid, the reader: {e}"));
    trace_view(&cache.view(), bounds, 64, dice, round);
}

fn share(dice: &mut Dice) -> f32 {
    (dice.roll() >> 40) as f32 / (1u64 << 24) as f32
}

/// From anywhere in a box to anywhere else in it.
fn some_ray(bounds: Aabb, dice: &mut Dice) -> Ray {
    let mut point = || [0, 1, 2].map(|a| bounds.min[a] + (bounds.max[a] - bounds.min[a]) * share(dice));
    let (from, to) = (point(), point());
    Ray::new(from, [0, 1, 2].map(|a| to[a] - from[a]))
}

fn trace_between(between: &Between<'_>, bounds: Aabb, dice: &mut Dice, round: usize) {
    for _ in 0..8 {
        let (ray, time) = (some_ray(bounds, dice), share(dice));
        let closest = between.closest_hit(&ray, time);
        let any = between.any_hit(&ray, time);
        assert!(closest.is_ok(), "round {round}: the check says valid, the traversal: {closest:?}");
        assert_eq!(any, closest.map(|hit| hit.is_some()), "round {round}");
    }
}

/// Rays through compact trees, whatever is wrong with them, end; in a file that the check calls valid they hit what they hit in the binary ones.
fn trace_compact(bytes: &[u8], valid: bool, dice: &mut Dice, round: usize) {
    let options = OpenOptions { validation: Validation::Quick, max_memory: 64 << 20, ..OpenOptions::default() };
    let Ok(cache) = Cache::from_bytes(bytes, &options) else { return };
    let Some(trees) = cache.compact() else { return };
    for _ in 0..16 {
        let ray = some_ray(cache.header().scene_bounds(), dice);
        let (closest, any) = (trees.closest_hit(&ray), trees.any_hit(&ray));
        if valid {
            let named = |hit: bvhc::Hit| (hit.t.to_bits(), hit.geom, hit.prim, hit.instance);
            let want = try_closest_hit(&cache.view(), &ray, &mut NoObserver).map(|hit| hit.map(named));
            assert_eq!(any, want.map(|hit| hit.is_some()), "round {round}: {ray:?}");
            assert_eq!(closest.map(|hit| hit.map(named)), want, "round {round}: {ray:?}");
        }
    }
}

/// The same through turned subtrees.
fn trace_turned(bytes: &[u8], valid: bool, dice: &mut Dice, round: usize) {
    let options = OpenOptions { validation: Validation::Quick, max_memory: 64 << 20, ..OpenOptions::default() };
    let Ok(cache) = Cache::from_bytes(bytes, &options) else { return };
    let Some(turned) = cache.turned() else { return };
    for _ in 0..16 {
        let ray = some_ray(cache.header().scene_bounds(), dice);
        let (closest, any) = (turned.closest_hit(&ray), turned.any_hit(&ray));
        if valid {
            let named = |hit: bvhc::Hit| (hit.t.to_bits(), hit.geom, hit.prim);
            let want = try_closest_hit(&cache.view(), &ray, &mut NoObserver).map(|hit| hit.map(named));
            assert_eq!(any, want.map(|hit| hit.is_some()), "round {round}: {ray:?}");
            assert_eq!(closest.map(|hit| hit.map(named)), want, "round {round}: {ray:?}");
        }
    }
}

fn trace_view(view: &View<'_>, bounds: Aabb, rays: usize, dice: &mut Dice, round: usize) {
    for _ in 0..rays {
        let ray = some_ray(bounds, dice);
        let closest = try_closest_hit(view, &ray, &mut NoObserver);
        assert!(closest.is_ok(), "round {round}: the check says valid, the traversal: {closest:?}");
        assert!(try_any_hit(view, &ray, &mut NoObserver).is_ok(), "round {round}");
    }
}
