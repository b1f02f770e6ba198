//! How much a piece of work holds at once: the system's allocator, counting where it is asked to.
//!
//! A program names [`Counting`] as its global allocator; in one that does not, nothing is counted.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, AtomicIsize, Ordering::Relaxed};

/// Whether anybody asks: a program that only has the allocator pays for one look at this.
static ON: AtomicBool = AtomicBool::new(false);
/// Bytes since it was switched on. What was there before may be given back, so it may be below 0.
static HELD: AtomicIsize = AtomicIsize::new(0);
static PEAK: AtomicIsize = AtomicIsize::new(0);

/// The system's allocator, for `#[global_allocator]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counting;

fn grow(bytes: usize) {
    if ON.load(Relaxed) {
        let held = HELD.fetch_add(bytes as isize, Relaxed) + bytes as isize;
        PEAK.fetch_max(held, Relaxed);
    }
}

fn shrink(bytes: usize) {
    if ON.load(Relaxed) {
        HELD.fetch_sub(bytes as isize, Relaxed);
    }
}

// SAFETY: every call goes to the system's allocator with the arguments that came in, and what it returns is returned; the counters touch nothing of it.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        shrink(layout.size());
        // SAFETY: as above.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Where it is not grown in place, both are there for a moment.
        grow(size);
        shrink(layout.size());
        // SAFETY: as above.
        unsafe { System.realloc(at, layout, size) }
    }
}

/// The result of `work`, and the most bytes that the program held at once meanwhile, beyond what it held before; 0 where [`Counting`] is not its allocator. All
/// threads count, so two that ask at once are told of each other.
pub fn peak_of<T>(work: impl FnOnce() -> T) -> (T, usize) {
    ON.store(true, Relaxed);
    let before = HELD.load(Relaxed);
    PEAK.store(before, Relaxed);
    let result = work();
    let peak = PEAK.load(Relaxed) - before;
    ON.store(false, Relaxed);
    (result, usize::try_from(peak).unwrap_or(0))
}
