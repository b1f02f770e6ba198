//! Many outputs: small models are built side by side, one on a thread, and their files take their places while the next ones are built.
//!
//! A model on one thread needs no other: nothing is cut up, nothing waits, and as many are in memory at once as there are threads, each with its
//! share of `--max-memory`. One that needs more than its share is built by itself with all of it, as large models are. What each has to say is
//! held back and said in the order of the inputs.

use super::Workshop;
use super::outcome::Outcome;
use super::plan::Job;
use super::publish::put_all;
use super::{Settled, attend, finish, report, settle};
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::progress::Files;
use crate::cli::terminal::holding_back;
use std::time::{Duration, Instant};

/// Larger models give several threads enough to do by themselves.
const SMALL: u64 = 2 << 20;

/// So many files at most are written before they take their places together. Each is open until then, and the next group is written meanwhile, which a
/// limit on open files must allow.
const GROUP: usize = 16;

/// A group of models that take longer is made smaller, so that what is done is told, and in its place, about once in this time.
const PACE: Duration = Duration::from_millis(500);

/// What came of a job, and what it said.
struct Attempt<'j> {
    job: &'j Job,
    said: Vec<String>,
    settled: Result<Settled, Failure>,
}

/// Do all jobs, and report each in its turn. An error ends the run.
pub fn attend_all(jobs: &[Job], workshop: &Workshop) -> Result<Vec<(Outcome, Exit)>, Failure> {
    let (context, exec) = (workshop.context, &workshop.context.exec);
    let of_one = context.share(exec.threads());
    let of_one = workshop.with(&of_one);
    let bytes: Vec<u64> = jobs.iter().map(|job| job.input.metadata().map_or(0, |file| file.len())).collect();
    let files = Files::new(&context.terminal, jobs.len(), bytes.iter().sum());
    let (mut results, mut written, mut next) = (Vec::with_capacity(jobs.len()), Vec::new(), 0);
    // Few at first: nobody knows yet how long each takes.
    let mut most = exec.threads().min(GROUP);
    while next < jobs.len() {
        let small = |i: &usize| *i < jobs.len() && is_small(&jobs[*i], bytes[*i]);
        let end = (next..next + most).find(|i| !small(i)).unwrap_or(next + most);
        let start = Instant::now();
        let group: Vec<&Job> = jobs[next..end].iter().collect();
        let attempts = || {
            exec.map(group, |_, job| {
                let (settled, said) = holding_back(|| settle(job, &of_one));
                files.advance(job.input.metadata().map_or(0, |file| file.len()));
                Attempt { job, said, settled }
            })
        };
        let (published, attempts) = exec.beside(|| publish(std::mem::take(&mut written), workshop), attempts);
        tell(published, workshop, &files, &mut results)?;
        most = if start.elapsed() < PACE / 2 {
            2 * most
        } else if start.elapsed() > PACE {
            most / 2
        } else {
            most
        };
        most = most.clamp(exec.threads().min(GROUP), GROUP);
        written = attempts;
        next = end;
        if next < jobs.len() && !small(&next) {
            tell(publish(std::mem::take(&mut written), workshop), workshop, &files, &mut results)?;
            results.push(files.aside(|| attend(&jobs[next], workshop))?);
            files.advance(bytes[next]);
            next += 1;
        }
    }
    tell(publish(written, workshop), workshop, &files, &mut results)?;
    Ok(results)
}

/// Whether one thread is enough for a model. A glTF's buffers may be larger than its text, and then most have its name.
fn is_small(job: &Job, bytes: u64) -> bool {
    let buffer = || job.input.with_extension("bin").metadata().map_or(0, |file| file.len());
    let is_gltf = job.input.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"));
    job.bytes.is_none() && job.frames.is_none() && bytes + if is_gltf { buffer() } else { 0 } <= SMALL
}

/// Put in place what was written.
fn publish<'j>(mut attempts: Vec<Attempt<'j>>, workshop: &Workshop) -> Vec<Attempt<'j>> {
    let staged = |attempt: &mut Attempt| match &mut attempt.settled {
        Ok(Settled::Written(written)) => written.staged.take(),
        _ => None,
    };
    let (places, staged): (Vec<usize>, Vec<_>) =
        attempts.iter_mut().enumerate().filter_map(|(place, attempt)| Some((place, staged(attempt)?))).unzip();
    let put = put_all(staged, workshop.args.sync, &workshop.context.exec);
    for (place, put) in places.into_iter().zip(put) {
        if let Err(failure) = put {
            attempts[place].settled = Err(failure);
        }
    }
    attempts
}

/// Report what is in its place, or failed.
fn tell(
    attempts: Vec<Attempt>,
    workshop: &Workshop,
    files: &Files,
    results: &mut Vec<(Outcome, Exit)>,
) -> Result<(), Failure> {
    for Attempt { job, said, settled } in attempts {
        let has_little = workshop.context.exec.threads() > 1;
        results.push(files.aside(|| match settled {
            Err(failure) if failure.exit == Exit::Limit && has_little => attend(job, workshop),
            settled => {
                workshop.context.terminal.say(&said);
                report(job, settled.and_then(|settled| finish(job, settled, workshop)), workshop)
            }
        })?);
    }
    Ok(())
}
