//! Pages, pictures, figures and text of what was made.

use super::ChartArgs;
use super::document::Outputs;
use super::sections;
use crate::cli::Context;
use crate::cli::drawing;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::cli::outputs;
use crate::report::chart::Chart;
use crate::report::chart::page::{Page, Section};
use crate::size::bytes;
use serde::Serialize;
use std::path::PathBuf;

/// What a run made, whatever it was about.
pub struct Made {
    pub title: String,
    /// Above the pictures of a page.
    pub lead: Vec<String>,
    pub warnings: Vec<String>,
    pub sections: Vec<Section>,
    /// Those whose tables are printed.
    pub printed: Vec<Section>,
    pub csv: String,
    /// The last lines of what is printed as text.
    pub advice: Vec<String>,
}

/// Refuse outputs that could not be written or should not be, before anything is measured.
pub fn may_write(args: &ChartArgs) -> Result<(), Failure> {
    let outputs = [&args.output, &args.svg, &args.png, &args.csv];
    for output in outputs.iter().copied().flatten() {
        outputs::writable(output)?;
        drawing::may_replace(output)?;
    }
    let kinds: [(&[&str], &str); 4] = [
        (&["html", "htm"], "name it *.html; one picture is drawn by --svg FILE.svg or --png FILE.png"),
        (&["svg"], "name it *.svg; a page is made by -o PAGE.html"),
        (&["png"], "name it *.png; a page is made by -o PAGE.html"),
        (&["csv", "txt"], "name it *.csv"),
    ];
    for (output, (kinds, help)) in outputs.into_iter().zip(kinds) {
        output.as_deref().map_or(Ok(()), |output| drawing::suits(output, kinds, help))?;
    }
    apart(&outputs)
}

/// Refuse to write two things into one file.
fn apart(outputs: &[&Option<PathBuf>]) -> Result<(), Failure> {
    let given: Vec<&PathBuf> = outputs.iter().copied().flatten().collect();
    let twice = given.iter().enumerate().find(|(i, path)| given[..*i].contains(path));
    twice.map_or(Ok(()), |(_, path)| {
        Err(Failure::new(Exit::Usage, format!("cannot write {}", names::path(path)))
            .fact("it is named for two outputs, and the second would replace the first")
            .help("name a file for each"))
    })
}

/// Write what was asked for, and print the rest. Whoever calls has the permission to publish.
pub fn write<D: Serialize>(
    args: &ChartArgs,
    made: &Made,
    context: &Context,
    document: impl FnOnce(Outputs) -> D,
) -> Result<(), Failure> {
    let mut written = Vec::new();
    if let Some(path) = &args.output {
        let Made { title, lead, warnings, sections, .. } = made;
        let page =
            Page { title: title.clone(), lead: lead.clone(), warnings: warnings.clone(), sections: sections.clone() };
        let html = page.html();
        drawing::put(path, "the page", html.as_bytes())?;
        written.push((path, html.len() as u64));
    }
    if let Some(path) = &args.svg {
        drawing::draw(path, &together(made))?;
        written.push((path, path.metadata().map_or(0, |m| m.len())));
    }
    if let Some(path) = &args.png {
        written.push((path, drawing::pixels(path, together(made))?));
    }
    if let Some(path) = &args.csv {
        drawing::put(path, "the figures", made.csv.as_bytes())?;
        written.push((path, made.csv.len() as u64));
    }
    let terminal = &context.terminal;
    if terminal.json {
        let name = |path: &Option<PathBuf>| path.as_ref().map(|p| p.to_string_lossy().into_owned());
        let [html, svg, png, csv] = [&args.output, &args.svg, &args.png, &args.csv].map(name);
        return terminal.document(&document(Outputs { html, svg, png, csv }));
    }
    if args.markdown {
        for section in &made.printed {
            terminal.print(&sections::markdown(section))?;
        }
        return Ok(());
    }
    if terminal.quiet {
        return Ok(());
    }
    for section in &made.printed {
        terminal.print(&sections::text(section))?;
    }
    for (path, length) in written {
        terminal.print(&format!("{}  {}\n", names::path(path), bytes(length)))?;
    }
    for line in &made.advice {
        terminal.print(&format!("{line}\n"))?;
    }
    Ok(())
}

/// All pictures as one.
fn together(made: &Made) -> Chart {
    let sections = &made.sections;
    let panels: Vec<_> = sections.iter().flat_map(|section| section.chart.panels.clone()).collect();
    let mut markers = Vec::new();
    let mut notes = Vec::new();
    for section in sections {
        let new = section.chart.markers.iter().filter(|marker| !markers.contains(*marker)).cloned().collect::<Vec<_>>();
        markers.extend(new);
        let new = section.chart.notes.iter().filter(|note| !notes.contains(*note)).cloned().collect::<Vec<_>>();
        notes.extend(new);
    }
    let columns = panels.len().clamp(1, 2);
    Chart { title: made.title.clone(), notes, panels, columns, markers }
}
