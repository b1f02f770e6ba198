//! What must follow from a verdict.

use bvhc::cache::{Cache, OpenOptions};
use bvhc::geom::Ray;
use bvhc::trace::{NoObserver, try_any_hit, try_closest_hit};

/// A file that the check calls valid opens and answers 64 rays; one that it refuses may open, but rays through it end.
pub fn agree(bytes: &[u8], valid: bool) {
    let options = OpenOptions { max_memory: 64 << 20, ..OpenOptions::default() };
    let cache = match Cache::from_bytes(bytes, &options) {
        Ok(cache) => cache,
        Err(error) => {
            assert!(!valid, "the check says valid, the reader: {error}");
            return;
        }
    };
    let view = cache.view();
    let b = cache.header().scene_bounds();
    for i in 0..64u32 {
        // A fixed net of rays from one side of the box to another point in it.
        let share = |k: u32| (i.wrapping_mul(k) % 61) as f32 / 60.0;
        let at = |a: usize, s: f32| b.min[a] + (b.max[a] - b.min[a]) * s;
        let from = [at(0, share(7)), at(1, share(11)), at(2, share(13))];
        let to = [at(0, share(17)), at(1, share(19)), at(2, share(23))];
        let ray = Ray::new(from, [0, 1, 2].map(|a| to[a] - from[a]));
        let closest = try_closest_hit(&view, &ray, &mut NoObserver);
        let any = try_any_hit(&view, &ray, &mut NoObserver);
        assert!(!valid || closest.is_ok() && any.is_ok(), "the check says valid, the traversal: {closest:?}");
    }
}
