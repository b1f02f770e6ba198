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
    ctrlc::set_handler(|| {
        CANCELLED.store(true, Ordering::SeqCst);
        let _wait = PUBLISHING.lock().unwrap_or_else(PoisonError::into_inner);
        std::process::exit(i32::from(Exit::Interrupted.code()));
    })
    .map_err(|e| Failure::new(Exit::Internal, "cannot install the signal handler").fact(e.to_string()))
}

/// The flag that long work polls.
pub fn flag() -> &'static AtomicBool {
    &CANCELLED
}

/// Permission to write an output; refused once a signal has come.
pub fn publish() -> Result<MutexGuard<'static, ()>, Failure> {
    let guard = PUBLISHING.lock().unwrap_or_else(PoisonError::into_inner);
    if CANCELLED.load(Ordering::SeqCst) { Err(Failure::interrupted()) } else { Ok(guard) }
}
