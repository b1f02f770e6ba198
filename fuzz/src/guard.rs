//! What a case may take: a second, and so much memory.

use crate::planted::Plan;
use crate::targets::Target;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

#[path = "../../examples/build_stats/memory.rs"]
mod memory;

const LONGEST: Duration = Duration::from_secs(1);

/// Run one case. Panics where it panics, or takes longer than a second; that is how a fuzzer is told.
pub fn hold(target: &Target, input: &[u8], plan: &Plan) {
    let took = run(target, input, plan);
    if took > LONGEST {
        // A busy machine is slow at times; a hang is slow again.
        let best = (0..3).map(|_| run(target, input, plan)).min().unwrap_or(took);
        assert!(best <= LONGEST, "{}: a case of {} bytes takes {best:?}", target.name, input.len());
    }
}

fn run(target: &Target, input: &[u8], plan: &Plan) -> Duration {
    // One thread that stays: what the library shares among threads is done by it alone, in a fixed order.
    static POOL: OnceLock<rayon::ThreadPool> = OnceLock::new();
    let pool = POOL.get_or_init(|| rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread"));
    pool.install(|| {
        let began = Instant::now();
        let seen = (target.run)(input);
        let took = began.elapsed();
        plan.judge(&seen);
        took
    })
}

/// What `work` gives. Panics where that holds more bytes at once than it may.
pub fn within<T>(most: usize, work: impl FnOnce() -> T) -> T {
    let (result, held) = memory::peak_of(work);
    assert!(held <= most, "the case holds {held} bytes and may hold {most}");
    result
}
