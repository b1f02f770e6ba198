//! Opens a cache from memory, traces rays through it and writes what they hit, every float by its bits. Equal text from two targets means that
//! they agree on every ray.

use bvhc_core::cache::{CacheError, OpenOptions, Validation};
use bvhc_core::geom::Aabb;
use bvhc_core::random::Random;
use bvhc_core::trace::Malformed;
use bvhc_core::{Cache, Hit, Ray, Sequence};

/// A line for each of `rays` rays through the file, or one that says why it cannot be opened.
pub fn trace(file: &[u8], rays: usize) -> String {
    let options = OpenOptions { validation: Validation::Tree, ..OpenOptions::default() };
    let cache = match Cache::from_slice(file, &options) {
        Ok(cache) => cache,
        Err(CacheError::Sequence { .. }) => return trace_between(file, &options, rays),
        Err(error) => return format!("not opened: {error}\n"),
    };
    let root = cache.tlas_nodes().first().or(cache.nodes().first());
    let bounds = root.map_or(Aabb { min: [0.0; 3], max: [1.0; 3] }, |root| root.bounds());
    let mut random = Random::new(1);
    let mut out = String::new();
    for _ in 0..rays {
        let ray = some_ray(&bounds, &mut random);
        out += &line(cache.closest_hit(&ray), cache.any_hit(&ray));
    }
    out
}

/// The rays of a sequence, shared among its frames, each at a time between two of them; or why there is nothing between.
fn trace_between(file: &[u8], options: &OpenOptions, rays: usize) -> String {
    let sequence = match Sequence::from_slice(file, options) {
        Ok(sequence) => sequence,
        Err(error) => return format!("not opened: {error}\n"),
    };
    let bounds = sequence.header().scene_bounds();
    let (mut random, mut out) = (Random::new(1), String::new());
    let frames = sequence.frame_count();
    for first in 0..frames {
        let between = match sequence.between(first, (first + 1) % frames) {
            Ok(between) => between,
            Err(error) => {
                out += &format!("frame {first}: {error}\n");
                continue;
            }
        };
        for _ in 0..rays.div_ceil(frames) {
            let (ray, time) = (some_ray(&bounds, &mut random), random.unit() as f32);
            out += &line(between.closest_hit(&ray, time), between.any_hit(&ray, time));
        }
    }
    out
}

fn line(closest: Result<Option<Hit>, Malformed>, any: Result<bool, Malformed>) -> String {
    match (closest, any) {
        (Ok(None), Ok(any)) => format!("- {any}\n"),
        (Ok(Some(hit)), Ok(any)) => {
            let [t, u, v] = [hit.t, hit.u, hit.v].map(f32::to_bits);
            let (prim, geom, instance, triangle) = (hit.prim, hit.geom, hit.instance, hit.triangle);
            format!("{t:08x} {u:08x} {v:08x} {prim} {geom} {instance:?} {triangle} {any}\n")
        }
        (Err(error), _) | (_, Err(error)) => format!("{error}\n"),
    }
}

/// From a point around the box, which may be flat, to one in it; one time in four along an axis.
fn some_ray(bounds: &Aabb, random: &mut Random) -> Ray {
    let extent = [0, 1, 2].map(|a| bounds.max[a] - bounds.min[a]);
    let around = extent.iter().fold(0.0, |most: f32, &e| if e > most { e } else { most });
    let target = [0, 1, 2].map(|a| bounds.min[a] + extent[a] * random.unit() as f32);
    let origin = [0, 1, 2].map(|a| target[a] + around * (2.0 * random.unit() as f32 - 1.0));
    let along = random.below(12) as usize;
    Ray::new(origin, [0, 1, 2].map(|a| if along > 2 || a == along { target[a] - origin[a] } else { 0.0 }))
}

/// What a program around a WebAssembly module calls: make room for a file, fill it, trace, read the text.
#[cfg(target_family = "wasm")]
#[allow(unsafe_code)] // Only to give functions the names that they are called by. No other function of a module has these.
mod wasm {
    use std::cell::RefCell;

    thread_local! {
        static FILE: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
        static TEXT: RefCell<String> = const { RefCell::new(String::new()) };
    }

    /// Where the `len` bytes of a file go.
    #[unsafe(no_mangle)]
    extern "C" fn file(len: usize) -> *mut u8 {
        FILE.with_borrow_mut(|file| {
            *file = vec![0; len];
            file.as_mut_ptr()
        })
    }

    /// Trace rays through the file; the length of the text is returned.
    #[unsafe(no_mangle)]
    extern "C" fn trace(rays: usize) -> usize {
        let text = FILE.with_borrow(|file| super::trace(file, rays));
        TEXT.with_borrow_mut(|place| {
            *place = text;
            place.len()
        })
    }

    /// Where the text is.
    #[unsafe(no_mangle)]
    extern "C" fn text() -> *const u8 {
        TEXT.with_borrow(|text| text.as_ptr())
    }
}
