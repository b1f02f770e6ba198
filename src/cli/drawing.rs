//! Charts, pictures and reports that are written beside what a command is about.

use super::exit::Exit;
use super::failure::Failure;
use super::interrupt;
use super::names;
use crate::report::chart::Chart;
use crate::report::picture::Canvas;
use std::io::Read;
use std::path::Path;

/// Refuse to write over a file that is neither empty nor a report or chart of before: it may be somebody's only copy of a model.
pub fn may_replace(path: &Path) -> Result<(), Failure> {
    replaces(path, b"<", "it is no XML, and only reports and charts are written over")
}

/// The same for a file that shall become a PNG.
pub fn may_replace_picture(path: &Path) -> Result<(), Failure> {
    replaces(path, b"\x89PNG", "it is no PNG, and only pictures are written over")
}

/// Refuse a file with something in it that does not start like this.
fn replaces(path: &Path, start: &[u8], rule: &str) -> Result<(), Failure> {
    let starts_so = || -> std::io::Result<bool> {
        let mut found = Vec::new();
        std::fs::File::open(path)?.take(start.len() as u64).read_to_end(&mut found)?;
        Ok(found == start)
    };
    if !path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0) || starts_so().unwrap_or(false) {
        return Ok(());
    }
    Err(Failure::new(Exit::Usage, format!("cannot replace {}", names::path(path)))
        .fact(rule)
        .help("name another file, or remove this one"))
}

/// Write a chart as SVG.
pub fn draw(path: &Path, chart: &Chart) -> Result<(), Failure> {
    let svg = chart.svg().map_err(|e| Failure::from_message(Exit::Internal, &e.to_string()))?;
    std::fs::write(path, svg).map_err(|e| {
        Failure::new(Exit::Io, format!("cannot write the chart {}", names::path(path))).fact(e.to_string())
    })
}

/// Write a picture as PNG.
pub fn picture(path: &Path, canvas: &Canvas) -> Result<(), Failure> {
    let png = canvas.png().map_err(|e| Failure::new(Exit::Internal, "cannot make a PNG").fact(e.to_string()))?;
    let _publishing = interrupt::publish()?;
    std::fs::write(path, png).map_err(|e| {
        Failure::new(Exit::Io, format!("cannot write the picture {}", names::path(path))).fact(e.to_string())
    })
}
