//! Work compiled for processors with AVX2, chosen at run time.

/// Run `work`, which the compiler inlines here and so translates for eight lanes. FMA is not asked for: every operation rounds as it
/// does elsewhere.
#[target_feature(enable = "avx2")]
pub fn run<R>(work: impl FnOnce() -> R) -> R {
    work()
}
