//! Work on as many floats as a wide node has children, by the widest registers that the processor has.

use super::{Floats, Register};
#[cfg(target_arch = "x86_64")]
use super::{Level, avx2, level};

/// Something to do with `N` floats at once, by whatever registers there are. `run` must be `#[inline(always)]`, and so must what it calls.
pub trait Work<const N: usize> {
    /// What comes of it.
    type Out;
    /// Do it.
    fn run<V: Floats<N>>(self, door: V::Door) -> Self::Out;
}

/// The widest registers of this processor for `N` floats, asked for when work is there.
#[derive(Clone, Copy, Debug)]
pub struct Widest;

/// Numbers of floats that [`Widest`] has registers for: 4 and 8.
pub trait Runs<const N: usize> {
    /// Do the work; the result has the same bits on any processor.
    fn run<W: Work<N>>(work: W) -> W::Out;
}

impl Runs<4> for Widest {
    #[inline(always)]
    fn run<W: Work<4>>(work: W) -> W::Out {
        work.run::<Register>(())
    }
}

impl Runs<8> for Widest {
    #[inline(always)]
    #[allow(unsafe_code)]
    fn run<W: Work<8>>(work: W) -> W::Out {
        #[cfg(target_arch = "x86_64")]
        if level() == Level::Avx2 {
            // A closure that is large stays a function of its own otherwise, which is not translated for AVX2: each operation is a call there.
            // SAFETY: the only precondition is AVX2, and the processor was just asked for it.
            return unsafe {
                avx2::run(
                    #[inline(always)]
                    |door| work.run::<avx2::Octet>(door),
                )
            };
        }
        work.run::<[Register; 2]>(())
    }
}
