//! `bvhc chart`: what each recipe takes to build against what rays cost then, and other pictures of speed against accuracy, on one page.
//!
//! `recipes` lists what is tried, `measure` measures a model or the frames of a sequence, `sections` makes pictures and tables of that, `document` says it
//! as JSON and as comma-separated values.

mod document;
mod measure;
mod recipes;
mod sections;

use crate::cli::Context;
use crate::cli::drawing;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::interrupt;
use crate::cli::names;
use crate::cli::outputs;
use crate::cli::patterns;
use crate::cli::reading::ModelReading;
use crate::report::chart::Chart;
use crate::report::chart::page::{Page, Section};
use crate::size::bytes;
use clap::Args;
use document::{Document, Outputs};
use measure::Charted;
use recipes::Given;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Chart build time against ray cost over all recipes, and rays a second against wrong hits
///
/// Every preset, every method and every --recipe builds the model's trees, once from the quickest to the slowest, then in rounds as long as the budget lasts; the
/// median of the rounds counts, and what the rounds cannot tell apart is said. Ray cost is 1.2 · nodes + triangle tests a ray, a mean over camera rays, one
/// diffuse bounce and ambient occlusion: a count, the same on every machine. Other arithmetics are judged and timed as by `verify --accuracy`. Of a sequence, a
/// file of many frames, ray cost and bytes are shown frame by frame. SIGINT ends the measuring, and what is measured is written.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ChartArgs {
    /// Models, or sequences that `bvhc build` made
    #[arg(required = true, value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// Page to write; it holds all that it shows, and asks no network
    #[arg(short, long, value_name = "PAGE.html")]
    output: Option<PathBuf>,
    /// Draw all pictures into one SVG file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write all figures as comma-separated values, with a heading
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Print the figures as Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Another recipe, by the flags of `bvhc build`, with or without a name before it; may be given again
    #[arg(long = "recipe", value_name = "[NAME=]FLAGS", value_parser = recipes::parse, allow_hyphen_values = true)]
    recipes: Vec<Given>,
    /// When to stop, all models together; the quickest recipe of each is built in any case
    #[arg(long, value_name = "TIME", value_parser = figures::parse_seconds, default_value = "60s")]
    budget: Duration,
    /// How often each recipe is built at most
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 9)]
    rounds: u32,
    /// Rays in each of three sets by which the cost of a ray is counted, from four cameras around the scene or each frame
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), default_value_t = 4096)]
    rays: u32,
    /// Rays that judge other arithmetics; 0 leaves that picture out
    #[arg(long, value_name = "N", value_parser = figures::parse_count, default_value = "20k")]
    accuracy_rays: u64,

    #[command(flatten)]
    reading: ModelReading,
}

const EXAMPLES: &str = "Examples:
  bvhc chart rock.glb -o rock.html
  bvhc chart hall.obj rock.glb -o both.html --budget 5m --svg both.svg --csv both.csv
  bvhc chart rock.glb --recipe 'moved=--method sweep --reinsert 8' --recipe '--preset draft --adapt 1024'
  bvhc chart heli.bvhc -o frames.html";

pub fn run(args: &ChartArgs, context: &Context) -> Result<Exit, Failure> {
    let recipes = recipes::all(&args.recipes)?;
    let args = &ChartArgs { models: patterns::expand(&args.models, patterns::MODELS, "chart")?, ..args.clone() };
    let outputs = [&args.output, &args.svg, &args.csv];
    for output in outputs.iter().copied().flatten() {
        outputs::writable(output)?;
        drawing::may_replace(output)?;
    }
    let kinds: [(&[&str], &str); 3] = [
        (&["html", "htm"], "name it *.html; one picture is drawn by --svg FILE.svg"),
        (&["svg"], "name it *.svg; a page is made by -o PAGE.html"),
        (&["csv", "txt"], "name it *.csv"),
    ];
    for (output, (kinds, help)) in outputs.into_iter().zip(kinds) {
        output.as_deref().map_or(Ok(()), |output| drawing::suits(output, kinds, help))?;
    }
    apart(&outputs)?;

    // From here on a signal waits until what is measured is written. The mutex is held to the end, also while the document is printed.
    let deadline = Instant::now() + args.budget;
    let publishing = interrupt::publish()?;
    let (mut charted, mut exits) = (Vec::new(), Vec::new());
    for (number, path) in args.models.iter().enumerate() {
        if is_interrupted() {
            break;
        }
        // What a model leaves of its share, the others have.
        let left = deadline.saturating_duration_since(Instant::now());
        let until = Instant::now() + left / (args.models.len() - number) as u32;
        match measure::measure(path, &recipes, until, args, context) {
            Ok(one) => {
                exits.push(Exit::Success);
                charted.push(one);
            }
            Err(failure) => {
                if failure.exit != Exit::Interrupted {
                    context.terminal.error(&failure);
                }
                exits.push(failure.exit);
            }
        }
    }
    let interrupted = is_interrupted();
    if charted.is_empty() {
        return if interrupted { Err(Failure::interrupted()) } else { Ok(Exit::combine(exits)) };
    }
    for missing in charted.iter().filter_map(sections::left_out) {
        context.terminal.warn(&missing);
    }
    let exit = if interrupted { Exit::Interrupted } else { Exit::combine(exits) };
    write(args, &charted, exit, context)?;
    drop(publishing);
    Ok(exit)
}

fn is_interrupted() -> bool {
    interrupt::flag().load(Ordering::SeqCst)
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

fn write(args: &ChartArgs, charted: &[Charted], exit: Exit, context: &Context) -> Result<(), Failure> {
    let sections: Vec<Section> = charted.iter().flat_map(|one| sections::of(one, args, context)).collect();
    let mut written = Vec::new();
    if let Some(path) = &args.output {
        let html = page(args, charted, &sections, exit, context).html();
        drawing::text(path, "the page", &html)?;
        written.push((path, html.len()));
    }
    if let Some(path) = &args.svg {
        let title = sections::title(args);
        drawing::draw(path, &together(title, &sections))?;
        written.push((path, path.metadata().map_or(0, |m| m.len() as usize)));
    }
    if let Some(path) = &args.csv {
        let csv = document::csv(charted);
        drawing::text(path, "the figures", &csv)?;
        written.push((path, csv.len()));
    }
    let terminal = &context.terminal;
    if terminal.json {
        let name = |path: &Option<PathBuf>| path.as_ref().map(|p| p.to_string_lossy().into_owned());
        let outputs = Outputs { html: name(&args.output), svg: name(&args.svg), csv: name(&args.csv) };
        return terminal.document(&Document::new(args, charted, outputs, exit, context));
    }
    if args.markdown {
        for section in &sections {
            terminal.print(&sections::markdown(section))?;
        }
        return Ok(());
    }
    if terminal.quiet {
        return Ok(());
    }
    for section in &sections {
        terminal.print(&sections::text(section))?;
    }
    for (path, length) in written {
        terminal.print(&format!("{}  {}\n", names::path(path), bytes(length as u64)))?;
    }
    Ok(())
}

fn page(args: &ChartArgs, charted: &[Charted], sections: &[Section], exit: Exit, context: &Context) -> Page {
    let threads = figures::counted(context.exec.threads() as u64, "thread", "threads");
    let lead = vec![
        format!(
            "bvhc {} on {} {}, {threads}. At most {} of each recipe, alternating over the recipes, within {}.",
            env!("CARGO_PKG_VERSION"),
            std::env::consts::OS,
            std::env::consts::ARCH,
            figures::counted(args.rounds.into(), "build", "builds"),
            figures::seconds(args.budget),
        ),
        "Ray cost is a count, the same on every machine. Times and speeds are this machine's. Select a point for its figures and the flags to type.".into(),
    ];
    let mut warnings = Vec::new();
    if exit == Exit::Interrupted {
        warnings.push("The run was interrupted: what had been measured by then is here.".to_string());
    }
    if charted.len() < args.models.len() {
        let missing = args.models.iter().filter(|path| !charted.iter().any(|one| one.path() == path.as_path()));
        let missing: Vec<String> = missing.map(|path| names::path(path)).collect();
        warnings.push(format!("Not measured: {}.", missing.join(", ")));
    }
    warnings.extend(charted.iter().filter_map(sections::left_out));
    Page { title: sections::title(args), lead, warnings, sections: sections.to_vec() }
}

/// All pictures as one.
fn together(title: String, sections: &[Section]) -> Chart {
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
    Chart { title, notes, panels, columns, markers }
}

/// What to type to make the pictures of one model again, apart from its outputs.
fn command(args: &ChartArgs, path: &Path) -> String {
    let mut words = vec!["bvhc".to_string(), "chart".into(), quoted(&path.to_string_lossy())];
    let output = args.output.as_ref().filter(|_| args.models.len() == 1);
    words.extend(["-o".to_string(), output.map_or("chart.html".into(), |output| quoted(&output.to_string_lossy()))]);
    for given in &args.recipes {
        words.extend(["--recipe".to_string(), quoted(&given.typed)]);
    }
    words.extend(["--budget".to_string(), format!("{}s", args.budget.as_secs_f64())]);
    words.extend(["--rounds".to_string(), args.rounds.to_string()]);
    words.extend(["--rays".to_string(), args.rays.to_string()]);
    words.extend(["--accuracy-rays".to_string(), args.accuracy_rays.to_string()]);
    words.extend(args.reading.typed().iter().map(|word| quoted(word)));
    words.join(" ")
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,%+@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_string();
    }
    format!("'{}'", names::escape(word).replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_would_split_them() {
        assert_eq!(quoted("a/b-1.obj"), "a/b-1.obj");
        assert_eq!(quoted("a b"), "'a b'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
        assert_eq!(quoted("$x"), "'$x'");
    }
}
