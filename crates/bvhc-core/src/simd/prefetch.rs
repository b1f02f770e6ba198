//! Bytes that will be read soon.

/// Ask for the lines of memory, of 64 bytes each, that a value begins in, so many bytes of it, while other work goes on. Only a hint, and none but on x86-64.
#[inline(always)]
#[allow(unsafe_code, unused_variables)]
pub fn prefetch<T>(value: &T, bytes: usize) {
    #[cfg(target_arch = "x86_64")]
    for start in (0..bytes).step_by(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: the only precondition is SSE, and that is part of the x86-64 baseline. The instruction reads and writes nothing that a program could tell, and takes
        // any address, valid or not.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast::<i8>().wrapping_add(start)) };
    }
}
