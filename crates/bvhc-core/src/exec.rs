//! The only place that knows threads.
//!
//! Every operation has a sequential twin with identical results: work is cut into chunks whose size the caller fixes,
//! and results come back in the order of the chunks, so nothing depends on how many threads there are or which of them
//! was first.

#[cfg(feature = "rayon")]
use rayon::prelude::*;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Fewest items that are worth a task where each is a matter of nanoseconds.
#[cfg(feature = "rayon")]
const LEAST: usize = 1 << 12;

/// Runs closures on a fixed number of threads, or all of them on the caller's.
///
/// Without the crate's feature `rayon` every executor is the sequential twin.
#[derive(Debug)]
pub struct Executor {
    pool: Pool,
    meter: Option<Meter>,
}

#[derive(Debug)]
enum Pool {
    /// The sequential twin.
    None,
    /// Threads of this executor alone.
    #[cfg(feature = "rayon")]
    Own(rayon::ThreadPool),
    /// The pool that the calling thread belongs to, or else the process's.
    #[cfg(feature = "rayon")]
    Current,
}

/// The operating system refused to start threads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ThreadsError {
    /// Threads that were asked for.
    pub jobs: usize,
    /// What the operating system said, or what the limit is.
    pub reason: String,
}

impl fmt::Display for ThreadsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot start {} threads: {}", self.jobs, self.reason)
    }
}

impl std::error::Error for ThreadsError {}

/// On WebAssembly without an operating system the standard library panics where it is asked for the time.
const HAS_CLOCK: bool = !cfg!(all(target_family = "wasm", target_os = "unknown"));

/// Of a metered executor: how many operations are open, and how long at least one was.
#[derive(Debug, Default)]
struct Meter {
    open: AtomicU64,
    nanoseconds: AtomicU64,
}

impl Executor {
    /// The most threads of an executor: starting more than any machine has processors would only exhaust the system.
    pub const MOST_THREADS: usize = 1024;

    /// Everything on the calling thread.
    pub const fn sequential() -> Executor {
        Executor { pool: Pool::None, meter: None }
    }

    /// The threads of the pool that the calling thread belongs to, or else rayon's own pool of one thread per core. Without the
    /// feature `rayon`: [`Executor::sequential`].
    pub const fn current() -> Executor {
        #[cfg(feature = "rayon")]
        return Executor { pool: Pool::Current, meter: None };
        #[cfg(not(feature = "rayon"))]
        return Executor::sequential();
    }

    /// Everything on the calling thread, but cut up as for several, and [`Executor::divided`] tells how much of it was.
    pub fn metered() -> Executor {
        Executor { pool: Pool::None, meter: Some(Meter::default()) }
    }

    /// How long a [metered](Executor::metered) executor has spent in work that several threads would share. The rest is what no number
    /// of threads makes quicker. Zero on WebAssembly without an operating system, which has no clock.
    pub fn divided(&self) -> Duration {
        Duration::from_nanos(self.meter.as_ref().map_or(0, |meter| meter.nanoseconds.load(Relaxed)))
    }

    /// The sequential twin of an operation.
    fn alone<R>(&self, work: impl FnOnce() -> R) -> R {
        let Some(meter) = &self.meter else { return work() };
        if meter.open.fetch_add(1, Relaxed) > 0 {
            let result = work();
            meter.open.fetch_sub(1, Relaxed);
            return result;
        }
        let start = HAS_CLOCK.then(Instant::now);
        let result = work();
        meter.open.fetch_sub(1, Relaxed);
        let spent = start.map_or(Duration::ZERO, |start| start.elapsed());
        meter.nanoseconds.fetch_add(spent.as_nanos() as u64, Relaxed);
        result
    }

    /// `jobs` threads; 0 means one per core. One thread is the caller's own: no thread is started.
    ///
    /// # Errors
    /// Where there would be more than [`Executor::MOST_THREADS`], or the operating system starts none.
    #[cfg(feature = "rayon")]
    pub fn new(jobs: usize) -> Result<Executor, ThreadsError> {
        if jobs > Executor::MOST_THREADS {
            return Err(ThreadsError { jobs, reason: format!("{} are the most", Executor::MOST_THREADS) });
        }
        let jobs = if jobs == 0 { std::thread::available_parallelism().map_or(1, |n| n.get()) } else { jobs };
        if jobs == 1 {
            return Ok(Executor::sequential());
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(jobs)
            .thread_name(|i| format!("bvhc-{i}"))
            .build()
            .map_err(|e| ThreadsError { jobs, reason: e.to_string() })?;
        Ok(Executor { pool: Pool::Own(pool), meter: None })
    }

    /// The sequential twin, whatever `jobs` says: the crate was built without the feature `rayon`.
    ///
    /// # Errors
    /// None.
    #[cfg(not(feature = "rayon"))]
    pub fn new(_jobs: usize) -> Result<Executor, ThreadsError> {
        Ok(Executor::sequential())
    }

    /// How many threads share the work.
    pub fn threads(&self) -> usize {
        match &self.pool {
            Pool::None => 1,
            #[cfg(feature = "rayon")]
            Pool::Own(pool) => pool.current_num_threads(),
            #[cfg(feature = "rayon")]
            Pool::Current => rayon::current_num_threads(),
        }
    }

    /// Whether nothing need be cut up.
    pub fn is_sequential(&self) -> bool {
        matches!(self.pool, Pool::None) && self.meter.is_none()
    }

    #[cfg(feature = "rayon")]
    fn is_parallel(&self) -> bool {
        !matches!(self.pool, Pool::None)
    }

    /// Enter the pool: what `f` spawns through this executor runs on its threads.
    pub fn run<R: Send>(&self, f: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            #[cfg(feature = "rayon")]
            Pool::Own(pool) => pool.install(f),
            _ => f(),
        }
    }

    /// Both closures, side by side where a thread is free.
    pub fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        #[cfg(feature = "rayon")]
        if self.is_parallel() {
            return self.run(|| rayon::join(a, b));
        }
        self.alone(|| (a(), b()))
    }

    /// `wait` on a thread of its own while `work` runs on the caller's: for what waits for the disk and computes nothing. The sequential twin
    /// and a build without the feature `rayon` do one after the other.
    pub fn beside<A: Send, B>(&self, wait: impl FnOnce() -> A + Send, work: impl FnOnce() -> B) -> (A, B) {
        #[cfg(feature = "rayon")]
        if self.is_parallel() {
            return std::thread::scope(|scope| {
                let waiting = scope.spawn(wait);
                let done = work();
                (waiting.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), done)
            });
        }
        (wait(), work())
    }

    /// `f(item)` for every item where each mostly waits for the disk, so that many may wait at once, on threads of their own; results in order.
    pub fn map_waits<T: Send, R: Send>(&self, items: Vec<T>, f: impl Fn(T) -> R + Sync) -> Vec<R> {
        #[cfg(feature = "rayon")]
        if self.is_parallel() && items.len() > 1 {
            /// More gain little: the disk orders what waits for it.
            const MOST: usize = 16;
            let each = items.len().div_ceil(MOST);
            let mut rest = items.into_iter();
            let shares: Vec<Vec<T>> = std::iter::repeat_with(|| rest.by_ref().take(each).collect::<Vec<T>>())
                .take_while(|share| !share.is_empty())
                .collect();
            return std::thread::scope(|scope| {
                let f = &f;
                let start = |share: Vec<T>| scope.spawn(move || share.into_iter().map(f).collect::<Vec<R>>());
                let started: Vec<_> = shares.into_iter().map(start).collect();
                let join = |thread: std::thread::ScopedJoinHandle<'_, Vec<R>>| {
                    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
                };
                started.into_iter().flat_map(join).collect()
            });
        }
        items.into_iter().map(f).collect()
    }

    /// `f(index, item)` for every item; results in order.
    pub fn map<T: Send, R: Send>(&self, items: Vec<T>, f: impl Fn(usize, T) -> R + Sync) -> Vec<R> {
        #[cfg(feature = "rayon")]
        if self.is_parallel() {
            return self.run(|| items.into_par_iter().enumerate().map(|(i, item)| f(i, item)).collect());
        }
        self.alone(|| items.into_iter().enumerate().map(|(i, item)| f(i, item)).collect())
    }

    /// `f(i)` for every `i` below `count`, each a task of its own; results in order. For many small items:
    /// [`Executor::generate`].
    pub fn map_range<R: Send>(&self, count: usize, f: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
        #[cfg(feature = "rayon")]
        if self.is_parallel() {
            return self.run(|| (0..count).into_par_iter().map(f).collect());
        }
        self.alone(|| (0..count).map(f).collect())
    }

    /// `f(i)` for every `i` below `count`, in order. Nobody clears the memory first, as one thread would have to for all.
    pub fn generate<T: Send>(&self, count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        let mut items = Vec::with_capacity(count);
        self.append(&mut items, count, f);
        items
    }

    /// [`Executor::generate`] behind what `items` holds already.
    pub fn append<T: Send>(&self, items: &mut Vec<T>, count: usize, f: impl Fn(usize) -> T + Sync + Send) {
        #[cfg(feature = "rayon")]
        if self.is_parallel() {
            return self.run(|| items.par_extend((0..count).into_par_iter().with_min_len(LEAST).map(f)));
        }
        self.alone(|| items.extend((0..count).map(f)));
    }

    /// [`Executor::map`] with memory to work in, which `make` makes once for a run of items. It comes as the item before left it, and
    /// nothing may depend on which that was.
    pub fn map_with<T: Send, W, R: Send>(
        &self,
        items: Vec<T>,
        make: impl Fn() -> W + Sync + Send,
        f: impl Fn(&mut W, usize, T) -> R + Sync + Send,
    ) -> Vec<R> {
        #[cfg(feature = "rayon")]
        if self.is_parallel() {
            let each = |memory: &mut W, (i, item)| f(memory, i, item);
            return self.run(|| items.into_par_iter().enumerate().map_init(make, each).collect());
        }
        self.alone(|| {
            let mut memory = make();
            items.into_iter().enumerate().map(|(i, item)| f(&mut memory, i, item)).collect()
        })
    }

    /// `f(index, chunk)` for every chunk of `size` items (the last may be shorter); results in order.
    pub fn map_chunks<T: Sync, R: Send>(
        &self,
        items: &[T],
        size: usize,
        f: impl Fn(usize, &[T]) -> R + Sync,
    ) -> Vec<R> {
        #[cfg(feature = "rayon")]
        if self.is_parallel() {
            return self.run(|| items.par_chunks(size.max(1)).enumerate().map(|(i, c)| f(i, c)).collect());
        }
        self.alone(|| items.chunks(size.max(1)).enumerate().map(|(i, c)| f(i, c)).collect())
    }

    /// [`Executor::map_chunks`] over chunks that may be changed.
    pub fn map_chunks_mut<T: Send, R: Send>(
        &self,
        items: &mut [T],
        size: usize,
        f: impl Fn(usize, &mut [T]) -> R + Sync,
    ) -> Vec<R> {
        #[cfg(feature = "rayon")]
        if self.is_parallel() {
            return self.run(|| items.par_chunks_mut(size.max(1)).enumerate().map(|(i, c)| f(i, c)).collect());
        }
        self.alone(|| items.chunks_mut(size.max(1)).enumerate().map(|(i, c)| f(i, c)).collect())
    }

    /// Sort; equal items may change places, so they must be equal in every byte that anyone reads.
    pub fn sort_unstable<T: Ord + Send>(&self, items: &mut [T]) {
        #[cfg(feature = "rayon")]
        if self.is_parallel() {
            return self.run(|| items.par_sort_unstable());
        }
        self.alone(|| items.sort_unstable());
    }

    /// BLAKE3 of some bytes.
    pub fn hash(&self, bytes: &[u8]) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        self.update_hash(&mut hasher, bytes);
        *hasher.finalize().as_bytes()
    }

    /// Feed a hasher; several threads are worth it from [`Executor::HASH_IN_PARALLEL_FROM`] bytes on.
    #[doc(hidden)] // for the crates of this repository, which share a version of `blake3`
    pub fn update_hash(&self, hasher: &mut blake3::Hasher, bytes: &[u8]) {
        #[cfg(feature = "rayon")]
        if self.is_parallel() && bytes.len() >= Self::HASH_IN_PARALLEL_FROM {
            self.run(|| _ = hasher.update_rayon(bytes));
            return;
        }
        hasher.update(bytes);
    }

    /// Fewer bytes are hashed on one thread: BLAKE3's documentation names this as where several begin to gain.
    pub const HASH_IN_PARALLEL_FROM: usize = 128 << 10;
}

#[cfg(test)]
mod tests {
    use super::Executor;
    use std::time::{Duration, Instant};

    #[test]
    fn a_metered_executor_gives_the_answers_of_the_sequential_one() {
        let (metered, plain) = (Executor::metered(), Executor::sequential());
        let sums = |exec: &Executor| {
            exec.map_chunks(&[1, 2, 3, 4, 5], 2, |i, some| exec.join(|| i, || some.iter().sum::<i32>()))
        };
        assert_eq!(sums(&metered), sums(&plain));
        assert_eq!(plain.divided(), Duration::ZERO);
        // It is cut up as for several threads.
        assert!(!metered.is_sequential() && plain.is_sequential() && metered.threads() == 1);
    }

    #[cfg(feature = "rayon")]
    #[test]
    fn what_waits_keeps_its_order_and_threads() {
        for exec in [Executor::sequential(), Executor::new(2).unwrap()] {
            for count in [0, 1, 2, 15, 16, 17, 100] {
                let items: Vec<usize> = (0..count).collect();
                assert_eq!(exec.map_waits(items.clone(), |item| item), items);
            }
            assert_eq!(exec.beside(|| 1, || 2), (1, 2));
        }
        // All wait at once, or none would get past the barrier.
        let barrier = std::sync::Barrier::new(16);
        Executor::new(2).unwrap().map_waits(vec![(); 16], |()| _ = barrier.wait());
    }

    #[test]
    fn a_meter_counts_what_is_divided_once_and_nothing_else() {
        let exec = Executor::metered();
        if !super::HAS_CLOCK {
            exec.join(|| (), || ());
            assert_eq!(exec.divided(), Duration::ZERO);
            return;
        }
        let work = || {
            let start = Instant::now();
            std::hint::black_box(blake3::hash(&[1; 1 << 18]));
            start.elapsed()
        };
        // What one thread does alone is not counted.
        work();
        assert_eq!(exec.divided(), Duration::ZERO);

        // Of operations within operations the outer one is counted.
        let start = Instant::now();
        let spent = exec.map_range(3, |_| exec.join(work, work));
        let around = start.elapsed();
        let spent: Duration = spent.into_iter().map(|(a, b)| a + b).sum();
        let divided = exec.divided();
        assert!(spent <= divided && divided <= around, "{spent:?} within {divided:?} within {around:?}");
    }
}
