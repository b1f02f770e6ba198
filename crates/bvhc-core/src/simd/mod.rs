//! Vector instructions: the one room that holds them.
//!
//! `portable` says what each operation on four floats means and runs on any machine. It has two twins with the same bits, as tests prove on
//! every pair of special values: `sse2`, which every x86-64 processor has, and `neon`, which every 64-bit Arm processor that runs programs has. The
//! compiler takes the one of its target. Nothing multiplies and adds in one rounding, so all machines agree. `Register` is what traversal uses,
//! [`Lanes`] and [`LaneBox`] are what builders use.
//!
//! [`Widest`] asks the processor for eight lanes where a ray meets eight boxes at once. [`Floats`] has the operations for whatever registers there are.
//!
//! [`widest`] asks the processor for more, for the work that it pays for: `agglomerative`, whose search is plain loops over columns. AVX-512
//! in its stead gains a little with wide windows and nothing with narrow ones: too little for a third translation. The other builders handle
//! boxes, which fill two registers of four, and what is done next with one depends on the result. Behind that door too, one loop at a
//! time, `sweep` and `sbvh` were no quicker, `bonsai` hardly, and `binned` was slower by some hundredths. Bins with boxes of
//! one register, minima negated, so that a union is one instruction, were hardly filled quicker: what counts there is the time until a
//! box can be read again, not instructions (see `Bins::fill`). The whole builder compiled for AVX2 (`RUSTFLAGS="-C target-cpu=x86-64-v3"
//! cargo run --release --example build_stats`) takes up to twice as long for `sbvh`: the likely cause is that boxes are written by halves and then
//! read whole, which a processor cannot forward.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod boxes;
mod floats;
mod lanes;
mod level;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(any(test, not(any(target_arch = "aarch64", target_arch = "x86_64"))))]
mod portable;
mod prefetch;
mod register;
mod runs;
#[cfg(target_arch = "x86_64")]
mod sse2;
#[cfg(test)]
mod tests;

pub use boxes::LaneBox;
pub use floats::Floats;
pub use lanes::Lanes;
#[cfg(any(test, feature = "testing"))]
pub use level::at_most;
pub use level::{Level, level, widest};
pub(crate) use prefetch::prefetch;
pub(crate) use register::Register;
pub use runs::{Runs, Widest, Work};

#[cfg(target_arch = "aarch64")]
use neon as operations;
#[cfg(not(any(target_arch = "aarch64", target_arch = "x86_64")))]
use portable as operations;
#[cfg(target_arch = "x86_64")]
use sse2 as operations;
