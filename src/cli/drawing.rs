//! Charts and reports that are written beside what a command is about.

use super::exit::Exit;
use super::failure::Failure;
use super::names;
use crate::report::chart::Chart;
use std::io::Read;
use std::path::Path;

/// Refuse to write over a file that is neither empty nor a report or chart of before: it may be somebody's only copy of a model.
pub fn may_replace(path: &Path) -> Result<(), Failure> {
    let mut start = [0; 1];
    let read = |start: &mut [u8; 1]| std::fs::File::open(path)?.read_exact(start);
    match path.metadata() {
        Ok(metadata) if metadata.is_file() && metadata.len() > 0 && !(read(&mut start).is_ok() && start == *b"<") => {
            Err(Failure::new(Exit::Usage, format!("cannot replace {}", names::path(path)))
                .fact("it is no XML, and only reports and charts are written over")
                .help("name another file, or remove this one"))
        }
        _ => Ok(()),
    }
}

/// Write a chart as SVG.
pub fn draw(path: &Path, chart: &Chart) -> Result<(), Failure> {
    let svg = chart.svg().map_err(|e| Failure::from_message(Exit::Internal, &e.to_string()))?;
    std::fs::write(path, svg).map_err(|e| {
        Failure::new(Exit::Io, format!("cannot write the chart {}", names::path(path))).fact(e.to_string())
    })
}
