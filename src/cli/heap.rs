//! Memory that was freed goes back to the operating system.

use crate::build::Progress;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A build's progress, between whose phases memory is given back: a search builds one tree after the other, and what one left would count for the next.
pub struct Thrifty<'a> {
    inner: &'a dyn Progress,
    latest: Mutex<Instant>,
}

/// Giving back has its price, and small trees have many phases.
const PAUSE: Duration = Duration::from_millis(50);

impl<'a> Thrifty<'a> {
    pub fn new(inner: &'a dyn Progress) -> Thrifty<'a> {
        Thrifty { inner, latest: Mutex::new(Instant::now()) }
    }
}

impl Progress for Thrifty<'_> {
    fn is_cancelled(&self) -> bool {
        self.inner.is_cancelled()
    }

    fn advance(&self, primitives: u64) {
        self.inner.advance(primitives);
    }

    fn phase(&self, name: &'static str) {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        if latest.elapsed() > PAUSE {
            give_back();
            *latest = Instant::now();
        }
        drop(latest);
        self.inner.phase(name);
    }
}

/// Give back what was freed and is still held. The allocator of GNU systems keeps what lies between blocks that live on, so that a step of many small
/// blocks would count for the next one as well. Elsewhere nothing is done.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        use std::ffi::c_int;
        #[allow(unsafe_code)]
        unsafe extern "C" {
            fn malloc_trim(pad: usize) -> c_int;
        }
        // SAFETY: glibc's function with its types. It may be called at any time and from any thread, touches free memory alone, and nothing here depends on
        // what it answers.
        #[allow(unsafe_code)]
        unsafe {
            malloc_trim(0);
        }
    }
}
