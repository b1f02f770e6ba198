//! Charts, pictures and reports that are written beside what a command is about.

use super::caches;
use super::exit::Exit;
use super::failure::Failure;
use super::interrupt;
use super::names;
use crate::cache::{self, CacheError, Staged, Strays};
use crate::report::chart::Chart;
use crate::report::picture::Canvas;
use std::io::Read;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// What a chart begins with.
const CHART: &str = "<!-- bvhc -->\n";
/// What the figures of charts begin with.
pub const FIGURES: [&str; 4] = ["model", "picture", "name", "flags"];
/// By these the program knows what it wrote: each stands in the first bytes of a chart, its figures, a report, a page, a picture, a manual page.
const MARKS: [&str; 6] = [
    CHART,
    "model,picture,name,flags,",
    "<testsuites name=\"bvhc verify\"",
    "<meta name=\"generator\" content=\"bvhc\">",
    "Software\0bvhc",
    ".TH BVHC",
];
const FIRST: usize = 512;

/// Refuse to write over a file that is neither empty nor made by this program: it may be somebody's only copy.
pub fn may_replace(path: &Path) -> Result<(), Failure> {
    if path.as_os_str() == "-" {
        return Err(Failure::new(Exit::Usage, "cannot write a report or a picture to standard output")
            .fact("it is written into a file")
            .help("name a file; one that is called - is ./-"));
    }
    let is_ours = || -> std::io::Result<bool> {
        let mut first = Vec::new();
        std::fs::File::open(path)?.take(FIRST as u64).read_to_end(&mut first)?;
        Ok(MARKS.iter().any(|mark| first.windows(mark.len()).any(|some| some == mark.as_bytes())))
    };
    if !path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0) || is_ours().unwrap_or(false) {
        return Ok(());
    }
    Err(Failure::new(Exit::Usage, format!("cannot replace {}", names::path(path)))
        .fact("bvhc did not make it, and writes over nothing else")
        .help("name another file, or remove this one"))
}

/// Refuse a name that says another kind of file than the one that is written; a name without an extension says nothing.
pub fn suits(path: &Path, kinds: &[&str], help: &str) -> Result<(), Failure> {
    let Some(extension) = path.extension().map(|e| e.to_string_lossy().to_lowercase()) else { return Ok(()) };
    if kinds.contains(&extension.as_str()) {
        return Ok(());
    }
    Err(Failure::new(Exit::Usage, format!("cannot write {}", names::path(path)))
        .fact(format!("what is written is {}, whatever its name says", kinds[0].to_uppercase()))
        .help(help))
}

/// Write a chart as SVG.
pub fn draw(path: &Path, chart: &Chart) -> Result<(), Failure> {
    let svg = chart.svg().map_err(|e| Failure::new(Exit::Internal, e.to_string()))?;
    put(path, "the chart", (CHART.to_owned() + &svg).as_bytes())
}

/// Write a file in one step, so that it is old or new as a whole, also where the disk is full; `what` it is, as an error calls it. Whoever calls has the
/// permission of [`interrupt::publish`], or leaves nothing behind that would harm.
pub fn put(path: &Path, what: &str, bytes: &[u8]) -> Result<(), Failure> {
    let staged = cache::stage_bytes(path, &Strays::default(), bytes).and_then(Staged::put);
    staged.map(drop).map_err(|error| match error {
        CacheError::Io { source, .. } => {
            Failure::new(Exit::Io, format!("cannot write {what} {}", names::path(path))).fact(source.to_string())
        }
        other => caches::failure(&other),
    })
}

/// Write a picture as PNG; how many bytes that took.
pub fn picture(path: &Path, canvas: &Canvas) -> Result<u64, Failure> {
    let png = encoded(canvas)?;
    let _publishing = interrupt::publish()?;
    write_picture(path, &png)
}

/// Draw a chart and write it as PNG. Whoever calls has the permission of [`interrupt::publish`], so a signal would wait: one that comes while the chart is drawn
/// ends that, and nothing is written.
pub fn pixels(path: &Path, chart: Chart) -> Result<u64, Failure> {
    let was_cancelled = interrupt::flag().load(Ordering::SeqCst);
    let (done, wait) = mpsc::channel();
    std::thread::spawn(move || {
        let canvas = chart.canvas().map_err(|e| Failure::new(Exit::Internal, e.to_string()));
        // Nobody waits any longer after a signal.
        _ = done.send(canvas.and_then(|canvas| encoded(&canvas)));
    });
    loop {
        match wait.recv_timeout(ASKED) {
            Ok(png) => return write_picture(path, &png?),
            Err(RecvTimeoutError::Timeout) if was_cancelled || !interrupt::flag().load(Ordering::SeqCst) => {}
            Err(RecvTimeoutError::Timeout) => return Err(Failure::interrupted()),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Failure::new(Exit::Internal, "cannot draw the chart").fact("its thread ended"));
            }
        }
    }
}

/// How often it is asked whether a signal came.
const ASKED: Duration = Duration::from_millis(20);

fn encoded(canvas: &Canvas) -> Result<Vec<u8>, Failure> {
    canvas.png().map_err(|e| Failure::new(Exit::Internal, "cannot make a PNG").fact(e.to_string()))
}

fn write_picture(path: &Path, png: &[u8]) -> Result<u64, Failure> {
    put(path, "the picture", png)?;
    Ok(png.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_begin_with_their_mark() {
        assert_eq!(FIGURES.join(",") + ",", MARKS[1]);
    }
}
