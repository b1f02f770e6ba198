//! How long a piece of work keeps this thread busy, where the system tells: other programs that want the processor do not count.

/// Seconds from some moment on.
#[cfg(all(unix, feature = "cli"))]
pub fn now() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Seconds from some moment on, by the clock on the wall.
#[cfg(not(all(unix, feature = "cli")))]
pub fn now() -> f64 {
    use std::sync::OnceLock;
    use std::time::Instant;
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

#[cfg(test)]
mod tests {
    #[test]
    fn work_takes_time() {
        let start = super::now();
        let mut sum = 0u64;
        while super::now() <= start {
            sum = std::hint::black_box(sum + 1);
        }
        assert!(super::now() > start);
    }
}
