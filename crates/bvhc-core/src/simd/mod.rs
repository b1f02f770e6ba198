//! Vector instructions: the one room that holds them.
//!
//! `portable` says what each operation means and runs on any machine; `sse2`, which every x86-64 processor has, is its twin with the same bits,
//! as tests prove on every pair of special values. Nothing multiplies and adds in one rounding, so all machines agree. [`boxes`] is what
//! builders use, [`rays`] what traversal uses.
//!
//! [`widest`] is a wider door, for the work that it pays for: `agglomerative`, whose search is plain loops over columns. AVX-512 in its
//! stead gains a little with wide windows and nothing with narrow ones: too little for a third translation. The other builders handle
//! boxes, which fill two registers of four, and what is done next with one depends on the result. Behind that door too, one loop at a
//! time, `sweep` and `sbvh` were no quicker, `bonsai` hardly, and `binned` was slower by some hundredths. Bins with boxes of
//! one register, minima negated, so that a union is one instruction, were hardly filled quicker: what counts there is the time until a
//! box can be read again, not instructions (see `Bins::fill`). The whole builder compiled for AVX2 (`RUSTFLAGS="-C target-cpu=x86-64-v3"
//! cargo run --release --example build_stats`) takes up to twice as long for `sbvh`: the likely cause is that boxes are written by halves and then
//! read whole, which a processor cannot forward.

#[cfg(target_arch = "x86_64")]
mod avx2;
pub mod boxes;
#[cfg(any(test, not(target_arch = "x86_64")))]
mod portable;
pub mod rays;
#[cfg(target_arch = "x86_64")]
mod sse2;

pub use boxes::{LaneBox, Lanes};
#[cfg(not(target_arch = "x86_64"))]
use portable as ops;
#[cfg(target_arch = "x86_64")]
use sse2 as ops;

/// Run `work` with the widest vectors that the processor has; the result has the same bits with any. Plain loops over columns gain by it.
/// What `work` calls must be `#[inline(always)]`, and so must `work` itself, or it stays as narrow as it is.
#[inline(always)]
#[allow(unsafe_code)]
pub fn widest<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if avx2::is_open() {
        // SAFETY: the only precondition is AVX2, and the processor was just asked for it.
        return unsafe { avx2::run(work) };
    }
    work()
}

#[cfg(any(test, feature = "testing"))]
thread_local! {
    static CLOSED: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Run `work`, and what it does on this thread, without the wide door.
#[cfg(any(test, feature = "testing"))]
pub fn narrow<R>(work: impl FnOnce() -> R) -> R {
    CLOSED.set(true);
    let result = work();
    CLOSED.set(false);
    result
}
