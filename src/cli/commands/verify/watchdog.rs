//! What ends a run whose device does not come back.

use super::junit;
use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::verify::opencl;
use std::path::PathBuf;
use std::time::Duration;

/// How often is looked, at most.
const TICK: Duration = Duration::from_millis(50);
/// How long drivers have to clean up behind themselves when the process ends. One that hangs may hang there, too.
const CLEANING: Duration = Duration::from_secs(5);

/// From now on, end the process with 5 where a driver has been in one call for longer than `limit`. The library does not start the thread, since only a program may end.
pub fn watch(limit: Duration, junit: Option<PathBuf>, context: &Context) {
    if limit.is_zero() {
        return;
    }
    let terminal = context.terminal;
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(TICK.min(limit / 2));
            let Some(waited) = opencl::waiting().filter(|waited| *waited > limit) else { continue };
            let failure = lost(waited, limit);
            terminal.error(&failure);
            if let Some(path) = &junit
                && let Err(failure) = junit::write(path, &[junit::without_devices(&failure, waited)])
            {
                terminal.error(&failure);
            }
            std::thread::spawn(|| {
                std::thread::sleep(CLEANING);
                std::process::abort();
            });
            // At the end of the process drivers take themselves apart, and a call that then comes back fails: nobody is to hear of that.
            let _silence = (std::io::stdout().lock(), std::io::stderr().lock());
            std::process::exit(i32::from(failure.exit.code()));
        }
    });
}

fn lost(waited: Duration, limit: Duration) -> Failure {
    Failure::new(Exit::Unsupported, "the OpenCL device is lost")
        .fact(format!("its driver has not come back from a call for {}", figures::seconds(waited)))
        .fact(format!(
            "--device-timeout allows {}, and calls are made to take less than a second",
            figures::seconds(limit)
        ))
        .help("pass --device cpu")
}
