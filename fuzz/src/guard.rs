//! What a case may take: a second, and so much memory.

use crate::planted::Plan;
use crate::targets::Target;
use bvhc::stability::heap::{Counting, peak_of};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const LONGEST: Duration = Duration::from_secs(1);

/// Run one case. Panics where it panics, or takes longer than a second; that is how a fuzzer is told.
pub fn hold(target: &Target, input: &[u8], plan: &Plan) {
    let took = run(target, input, plan);
    if took > LONGEST {
        // A busy machine is slow at times; a hang is slow again, and by the clock of its processor.
        let worked = || {
            let before = processor_time();
            let took = run(target, input, plan);
            // Without such a clock the wall's.
            before.zip(processor_time()).map_or(took, |(before, after)| after.saturating_sub(before))
        };
        let best = (0..3).map(|_| worked()).min().unwrap_or(took);
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

/// What all threads of the program have worked so far, as Linux tells it in hundredths of a second.
fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // Behind the name, which may have spaces: fields 14 and 15, user and system.
    let fields: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |i: usize| fields.get(i)?.parse::<u64>().ok();
    Some(Duration::from_millis((ticks(11)? + ticks(12)?) * 10))
}

/// What `work` gives. Panics where that holds more bytes at once than it may.
pub fn within<T>(most: usize, work: impl FnOnce() -> T) -> T {
    let (result, held) = peak_of(work);
    assert!(held <= most, "the case holds {held} bytes and may hold {most}");
    result
}
