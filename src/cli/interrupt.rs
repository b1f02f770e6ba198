//! SIGINT and SIGTERM: stop at once, but never in the middle of publishing an output.

use super::exit::Exit;
use super::failure::Failure;
use super::terminal::Terminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, RwLock, RwLockReadGuard, mpsc};
use std::time::Duration;

static CANCELLED: AtomicBool = AtomicBool::new(false);
/// Shared by all that are writing or renaming an output just now.
static PUBLISHING: RwLock<()> = RwLock::new(());
/// Files that are written and wait for others before they take their places.
static STAGED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
/// Longest that ending waits for somebody to read what is told: a full pipe on stderr must not hold it up.
const PATIENCE: Duration = Duration::from_millis(200);

/// Install the handler. It raises the flag that builders poll, waits for the writes under way (which are atomic and short), removes files that
/// are staged, says so, and ends the process: reading and building leave nothing on disk that would need tidying.
pub fn install(terminal: Terminal) -> Result<(), Failure> {
    fail_beyond_size_limits();
    ctrlc::set_handler(move || {
        CANCELLED.store(true, Ordering::SeqCst);
        let _wait = PUBLISHING.write().unwrap_or_else(PoisonError::into_inner);
        for path in STAGED.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
            // The process ends either way, and whoever writes the same file next removes it as well.
            _ = std::fs::remove_file(path);
        }
        let (done, wait) = mpsc::channel();
        std::thread::spawn(move || {
            terminal.error(&Failure::interrupted());
            _ = done.send(());
        });
        _ = wait.recv_timeout(PATIENCE);
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
pub fn publish() -> Result<RwLockReadGuard<'static, ()>, Failure> {
    let guard = PUBLISHING.read().unwrap_or_else(PoisonError::into_inner);
    if CANCELLED.load(Ordering::SeqCst) { Err(Failure::interrupted()) } else { Ok(guard) }
}

/// Let a signal remove a file that was just written and is not in its place yet. Asked for while there is permission to write.
pub fn stage(path: &Path) {
    STAGED.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_owned());
}

/// The file at this path is in its place, or gone.
pub fn unstage(path: &Path) {
    STAGED.lock().unwrap_or_else(PoisonError::into_inner).retain(|staged| staged != path);
}
