//! Which vector instructions there are: what the crate was compiled for, and what the processor has beyond that.

/// A set of vector instructions, the narrower ones first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Level {
    /// None: plain code.
    Portable,
    /// Four lanes on 64-bit Arm.
    Neon,
    /// Four lanes on x86-64.
    Sse2,
    /// Eight lanes on x86-64.
    Avx2,
}

impl Level {
    /// What the crate was compiled for. Traversal and [`Lanes`](super::Lanes) use it without asking the processor.
    pub const BASE: Level = if cfg!(target_arch = "x86_64") {
        Level::Sse2
    } else if cfg!(target_arch = "aarch64") {
        Level::Neon
    } else {
        Level::Portable
    };
}

/// The widest instructions that this processor has: what [`widest`] uses. Never below [`Level::BASE`].
#[inline]
pub fn level() -> Level {
    // The standard library asks the processor once and keeps the answer.
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        return lowered(Level::Avx2);
    }
    Level::BASE
}

/// Run `work` with the widest vectors that the processor has; the result has the same bits with any. Plain loops over columns gain by it.
/// What `work` calls must be `#[inline(always)]`, and so must `work` itself, or it stays as narrow as it is.
#[inline(always)]
#[allow(unsafe_code)]
pub fn widest<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if level() == Level::Avx2 {
        // A closure that is large stays a function of its own otherwise, which is not translated for AVX2.
        // SAFETY: the only precondition is AVX2, and the processor was just asked for it.
        return unsafe {
            super::avx2::run(
                #[inline(always)]
                |_| work(),
            )
        };
    }
    work()
}

/// No more than a test allows on this thread.
#[cfg(target_arch = "x86_64")]
#[inline]
fn lowered(found: Level) -> Level {
    #[cfg(any(test, feature = "testing"))]
    let found = found.min(limit::LIMIT.get()).max(Level::BASE);
    found
}

#[cfg(any(test, feature = "testing"))]
mod limit {
    use super::Level;

    thread_local! {
        pub static LIMIT: std::cell::Cell<Level> = const { std::cell::Cell::new(Level::Avx2) };
    }
}

/// Run `work`, and what it does on this thread, as if the processor had no more than `limit`. What is compiled in stays:
/// see [`Level::BASE`].
#[cfg(any(test, feature = "testing"))]
pub fn at_most<R>(limit: Level, work: impl FnOnce() -> R) -> R {
    let before = limit::LIMIT.replace(limit);
    let result = work();
    limit::LIMIT.set(before);
    result
}
