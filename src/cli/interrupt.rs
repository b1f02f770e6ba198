//! SIGINT and SIGTERM: stop at once, but never in the middle of publishing an output.

use super::exit::Exit;
use super::failure::Failure;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

static CANCELLED: AtomicBool = AtomicBool::new(false);
/// Held while an output is being written and renamed.
static PUBLISHING: Mutex<()> = Mutex::new(());

/// Install the handler. It raises the flag that builders poll, waits for a write under way (which is atomic and short), and
/// ends the process: reading and building leave nothing on disk that would need tidying.
pub fn install() -> Result<(), Failure> {
    fail_beyond_size_limits();
    ctrlc::set_handler(|| {
        CANCELLED.store(true, Ordering::SeqCst);
        let _wait = PUBLISHING.lock().unwrap_or_else(PoisonError::into_inner);
        std::process::exit(i32::from(Exit::Interrupted.code()));
    })
    .map_err(|e| Failure::new(Exit::Internal, "cannot install the signal handler").fact(e.to_string()))
}

/// Let writes beyond a limit on the size of files (`ulimit -f`) fail as those to a full disk do. By default a signal ends the process there, and the temporary file of
/// an output stays behind.
#[cfg(all(any(target_os = "linux", target_os = "macos"), not(any(target_arch = "mips", target_arch = "mips64"))))]
fn fail_beyond_size_limits() {
    use std::ffi::c_int;
    const SIGXFSZ: c_int = 25;
    const SIG_IGN: usize = 1;
    #[allow(unsafe_code)]
    unsafe extern "C" {
        fn signal(number: c_int, handler: usize) -> usize;
    }
    // SAFETY: ISO C's function with its types, where a handler is a pointer or one of two small numbers; the one given stands for no function, so none is ever
    // called. It is called once, before any thread is started, and nothing here depends on what it answers.
    #[allow(unsafe_code)]
    unsafe {
        signal(SIGXFSZ, SIG_IGN);
    }
}

#[cfg(not(all(
    any(target_os = "linux", target_os = "macos"),
    not(any(target_arch = "mips", target_arch = "mips64"))
)))]
fn fail_beyond_size_limits() {}

/// The flag that long work polls.
pub fn flag() -> &'static AtomicBool {
    &CANCELLED
}

/// Permission to write an output; refused once a signal has come.
pub fn publish() -> Result<MutexGuard<'static, ()>, Failure> {
    let guard = PUBLISHING.lock().unwrap_or_else(PoisonError::into_inner);
    if CANCELLED.load(Ordering::SeqCst) { Err(Failure::interrupted()) } else { Ok(guard) }
}
