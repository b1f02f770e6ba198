//! The wide door: work compiled for processors with AVX2, chosen at run time.

/// Whether this processor has what [`run`] needs. The standard library looks once and keeps the answer.
#[inline]
pub fn is_open() -> bool {
    #[cfg(test)]
    if super::CLOSED.get() {
        return false;
    }
    std::arch::is_x86_feature_detected!("avx2")
}

/// Run `work`, which the compiler inlines here and so translates for eight lanes. FMA is not asked for: every operation rounds as it
/// does elsewhere.
#[target_feature(enable = "avx2")]
pub fn run<R>(work: impl FnOnce() -> R) -> R {
    work()
}
