//! The only place that knows threads.
//!
//! Every operation has a sequential twin with identical results: work is cut into chunks whose size the caller fixes,
//! and results come back in the order of the chunks, so nothing depends on how many threads there are or which of them
//! was first.

use super::error::BuildError;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Fewest items that are worth a task where each is a matter of nanoseconds.
const LEAST: usize = 1 << 12;

/// Runs closures on a fixed number of threads, or all of them on the caller's.
#[derive(Debug)]
pub struct Executor {
    /// `None`: the sequential twin.
    pool: Option<rayon::ThreadPool>,
    meter: Option<Meter>,
}

/// Of a metered executor: how many operations are open, and how long at least one was.
#[derive(Debug, Default)]
struct Meter {
    open: AtomicU64,
    nanoseconds: AtomicU64,
}

impl Executor {
    /// Everything on the calling thread.
    pub const fn sequential() -> Executor {
        Executor { pool: None, meter: None }
    }

    /// Everything on the calling thread, but cut up as for several, and [`Executor::divided`] tells how much of it was.
    pub fn metered() -> Executor {
        Executor { pool: None, meter: Some(Meter::default()) }
    }

    /// How long a [metered](Executor::metered) executor has spent in work that several threads would share. The rest is what no number
    /// of threads makes quicker.
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
        let start = Instant::now();
        let result = work();
        meter.open.fetch_sub(1, Relaxed);
        meter.nanoseconds.fetch_add(start.elapsed().as_nanos() as u64, Relaxed);
        result
    }

    /// `jobs` threads; 0 means one per core.
    pub fn new(jobs: usize) -> Result<Executor, BuildError> {
        let jobs = if jobs == 0 { std::thread::available_parallelism().map_or(1, |n| n.get()) } else { jobs };
        if jobs == 1 {
            return Ok(Executor::sequential());
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(jobs)
            .thread_name(|i| format!("bvhc-build-{i}"))
            .build()
            .map_err(|e| BuildError::Threads { jobs, reason: e.to_string() })?;
        Ok(Executor { pool: Some(pool), meter: None })
    }

    pub fn threads(&self) -> usize {
        self.pool.as_ref().map_or(1, rayon::ThreadPool::current_num_threads)
    }

    /// Whether nothing need be cut up.
    pub fn is_sequential(&self) -> bool {
        self.pool.is_none() && self.meter.is_none()
    }

    /// Enter the pool: what `f` spawns through this executor runs on its threads.
    pub fn run<R: Send>(&self, f: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(f),
            None => f(),
        }
    }

    /// Both closures, side by side where a thread is free.
    pub fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        match &self.pool {
            Some(pool) => pool.join(a, b),
            None => self.alone(|| (a(), b())),
        }
    }

    /// `f(index, item)` for every item; results in order.
    pub fn map<T: Send, R: Send>(&self, items: Vec<T>, f: impl Fn(usize, T) -> R + Sync) -> Vec<R> {
        match &self.pool {
            Some(pool) => pool.install(|| items.into_par_iter().enumerate().map(|(i, item)| f(i, item)).collect()),
            None => self.alone(|| items.into_iter().enumerate().map(|(i, item)| f(i, item)).collect()),
        }
    }

    /// `f(i)` for every `i` below `count`, in order. Nobody clears the memory first, as one thread would have to for all.
    pub fn generate<T: Send>(&self, count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        let mut items = Vec::with_capacity(count);
        match &self.pool {
            Some(pool) => pool.install(|| items.par_extend((0..count).into_par_iter().with_min_len(LEAST).map(f))),
            None => self.alone(|| items.extend((0..count).map(f))),
        }
        items
    }

    /// [`Executor::map`] with memory to work in, which `make` makes once for a run of items. It comes as the item before left it, and
    /// nothing may depend on which that was.
    pub fn map_with<T: Send, W, R: Send>(
        &self,
        items: Vec<T>,
        make: impl Fn() -> W + Sync + Send,
        f: impl Fn(&mut W, usize, T) -> R + Sync + Send,
    ) -> Vec<R> {
        match &self.pool {
            Some(pool) => pool.install(|| {
                items.into_par_iter().enumerate().map_init(make, |memory, (i, item)| f(memory, i, item)).collect()
            }),
            None => self.alone(|| {
                let mut memory = make();
                items.into_iter().enumerate().map(|(i, item)| f(&mut memory, i, item)).collect()
            }),
        }
    }

    /// `f(index, chunk)` for every chunk of `size` items (the last may be shorter); results in order.
    pub fn map_chunks<T: Sync, R: Send>(
        &self,
        items: &[T],
        size: usize,
        f: impl Fn(usize, &[T]) -> R + Sync,
    ) -> Vec<R> {
        match &self.pool {
            Some(pool) => pool.install(|| items.par_chunks(size).enumerate().map(|(i, c)| f(i, c)).collect()),
            None => self.alone(|| items.chunks(size).enumerate().map(|(i, c)| f(i, c)).collect()),
        }
    }

    /// [`Executor::map_chunks`] over chunks that may be changed.
    pub fn map_chunks_mut<T: Send, R: Send>(
        &self,
        items: &mut [T],
        size: usize,
        f: impl Fn(usize, &mut [T]) -> R + Sync,
    ) -> Vec<R> {
        match &self.pool {
            Some(pool) => pool.install(|| items.par_chunks_mut(size).enumerate().map(|(i, c)| f(i, c)).collect()),
            None => self.alone(|| items.chunks_mut(size).enumerate().map(|(i, c)| f(i, c)).collect()),
        }
    }
}
