//! `bvhc info`: the facts of a file's header, in one small read.

use crate::build;
use crate::cli::Context;
use crate::cli::advice;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::{Entry, Failure};
use crate::cli::figures;
use crate::cli::names;
use crate::cli::paragraph;
use crate::cli::patterns;
use crate::cli::table::Table;
use crate::report::info::{FileInfo, MetaInfo, OptionInfo, SectionInfo};
use crate::size::bytes;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Show what the header of cache files says: format, counts, identities, sections
///
/// Reads the header, the section table and the provenance, whatever the size of the file. The trees are not looked at.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  bvhc info rock.bvhc\n  bvhc info rock.bvhc --field content_id\n  bvhc info rock.bvhc --field meta.options"
)]
pub struct InfoArgs {
    /// Cache files, folders of them, or quoted patterns such as 'caches/**/*.bvhc'
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print one value alone, by its name in --json; a dot leads inwards
    #[arg(long, value_name = "NAME", conflicts_with_all = ["sections", "json"])]
    field: Option<String>,
    /// Show the section table
    #[arg(long)]
    sections: bool,
}

#[derive(Serialize)]
struct Document {
    schema: &'static str,
    exit_code: u8,
    files: Vec<Entry<NamedInfo>>,
}

#[derive(Serialize)]
struct NamedInfo {
    path: String,
    #[serde(flatten)]
    info: FileInfo,
}

pub fn run(args: &InfoArgs, context: &Context) -> Result<Exit, Failure> {
    let terminal = &context.terminal;
    let files = patterns::expand(&args.files, patterns::CACHES, "show", &context.terminal)?;
    let (entries, exit) = caches::each(&files, context, |path| {
        let head = caches::head(path, context)?;
        let info = FileInfo::new(&head.header, &head.sections, head.meta.as_ref().map(Into::into));
        let info = FileInfo { meta_error: head.meta_error, ..info };
        Ok(NamedInfo { path: path.to_string_lossy().into_owned(), info })
    });
    if terminal.json {
        terminal.document(&Document { schema: "bvhc.info.v1", exit_code: exit.code(), files: entries })?;
        return Ok(exit);
    }
    let found = files.iter().zip(&entries).filter_map(|(path, entry)| Some((path, &entry.done()?.info)));
    for (i, (path, info)) in found.enumerate() {
        if let Some(field) = &args.field {
            terminal.result(&field_of(info, field)?)?;
            continue;
        }
        if files.len() > 1 {
            terminal.print(&format!("{}{}\n", if i > 0 { "\n" } else { "" }, names::path(path)))?;
        }
        terminal.print(&text(info, terminal.verbose))?;
        if args.sections {
            terminal.print(&format!("\n{}", sections(info)))?;
        }
    }
    Ok(exit)
}

fn text(info: &FileInfo, verbose: u8) -> String {
    let mut rows: Vec<(&str, String)> = Vec::new();
    let version = &info.format;
    let (builder, tool) = match &info.meta {
        Some(m) => {
            (format!("{} r{}", m.method, m.builder_revision), format!("  written by {} {}", m.tool, m.tool_version))
        }
        None => ("not known without META".to_string(), String::new()),
    };
    rows.push(("format", format!("{}.{} (needs reader {0}.{})", version.major, version.minor, version.min_minor)));
    rows.push(("builder", format!("{builder}{tool}")));

    // Counts, then what the flags mean for a renderer.
    if info.frames > 0 {
        rows.extend(of_frames(info));
    } else {
        rows.push(("tree", of_trees(info)));
    }
    rows.push(("flags", info.tree_flags.names.join(" · ")));
    let b = &info.scene_bounds;
    rows.push(("bounds", format!("{:?} … {:?}", b.min, b.max)));
    rows.push(("content", info.content_id.clone()));
    rows.push(("build", info.build_key.clone()));
    rows.push(("file", format!("{}  {}", info.file_id, bytes(info.file_len))));
    let mut named = by_kind(&info.sections);
    let hidden = more(named.len(), "--sections");
    named.truncate(MOST_LINES);
    named.extend(hidden);
    rows.push(("sections", named.join(" · ")));
    if let Some(error) = &info.meta_error {
        rows.push(("meta", format!("not read: {error}")));
    }
    if let Some(meta) = &info.meta {
        rows.extend(options(meta));
        let inputs = meta.inputs.iter();
        lines(&mut rows, "input", inputs.map(|i| format!("{}  {}  {}", i.name, bytes(i.len), i.blake3)));
        let dropped = meta.read_counts.iter().filter(|c| c.count > 0);
        lines(&mut rows, "read", dropped.map(|c| format!("{} {}", figures::count(c.count), c.name.replace('_', " "))));
        lines(&mut rows, "note", advice::notes(&meta.notes, verbose).into_iter());
    }
    // A file whose header is sound may have records that are not, and all figures above are the header's word.
    rows.push(("records", "not looked at here; bvhc check proves them".to_owned()));
    // Notes are sentences; every other value is one thing to be copied, or a list that grows with the file.
    let told = |(label, value): &(&str, String)| match (*label, names::escape(value)) {
        ("note", text) if !advice::names_a_recipe(value) => paragraph::hanging("note      ", &text),
        (label, text) => format!("{label:<9} {text}\n"),
    };
    rows.iter().map(told).collect()
}

/// The trees of a still file, by the names and with the figures of `build` and `stats`.
fn of_trees(info: &FileInfo) -> String {
    let [tris, refs] = [info.triangles, info.references].map(figures::count);
    let nodes = figures::count(info.nodes);
    if info.instances == 0 {
        return format!("{nodes} nodes · {tris} tris · {refs} refs · depth {}", info.max_depth);
    }
    // The header has one depth for both levels.
    format!(
        "{nodes} nodes · {tris} tris · {refs} refs · {} trees · {} instances · {} top-level nodes · deepest leaf of any level at {}",
        figures::count(info.trees),
        figures::count(info.instances),
        figures::count(info.top_nodes),
        info.max_depth
    )
}

/// The same of a sequence, whose figures are sums over what is stored once.
fn of_frames(info: &FileInfo) -> [(&'static str, String); 2] {
    let counted = figures::counted;
    let poses = info.sections.iter().find(|section| section.kind == "POSE").map_or(0, |section| section.elem_count);
    let nodes = info.nodes;
    let frames = [
        counted(u64::from(info.frames), "frame", "frames"),
        counted(u64::from(info.trees), "topology", "topologies"),
        counted(poses, "pose", "poses"),
    ];
    let stored = [
        format!("{} in all topologies", counted(info.triangles, "tri", "tris")),
        format!("{} in all poses", counted(nodes, "node", "nodes")),
        format!("{} in all placements", counted(u64::from(info.instances), "instance", "instances")),
        format!("deepest leaf of any level at {}", info.max_depth),
    ];
    [("frames", frames.join(" · ")), ("stored", stored.join(" · "))]
}

/// The options as the file has them. Meshes that move in a sequence may have trees that do not read those for trees, so that these are told of the others alone.
fn options(meta: &MetaInfo) -> Vec<(&'static str, String)> {
    let value = |name: &str| meta.options.iter().find(|option| option.name == name).map(|option| option.value.as_str());
    let is_surveyed = value("trees").is_some_and(|trees| trees != "first") && value("refit") != Some("never");
    let of_trees =
        |option: &&OptionInfo| is_surveyed && option.name != "levels" && build::option(&option.name).is_some();
    let told =
        |some: Vec<&OptionInfo>| some.iter().map(|o| format!("{} {}", o.name, o.value)).collect::<Vec<_>>().join(" · ");
    let (of_trees, others): (Vec<&OptionInfo>, Vec<&OptionInfo>) = meta.options.iter().partition(of_trees);
    let mut rows = vec![("options", told(others))];
    if !of_trees.is_empty() {
        rows.push((
            "moving",
            "trees for meshes that move are made for all their frames, by sweep and reinsertion".to_owned(),
        ));
        rows.push(("standing", format!("trees for meshes that stand still: {} · {}", meta.method, told(of_trees))));
    }
    rows
}

/// The sections of each kind and codec, in the order of the file: how many, unless there is one, and their bytes in the file.
fn by_kind(sections: &[SectionInfo]) -> Vec<String> {
    let of_one = |a: &SectionInfo, b: &SectionInfo| (&a.kind, &a.codec) == (&b.kind, &b.codec);
    let told = |same: &[SectionInfo]| {
        let [first, others @ ..] = same else { return String::new() };
        let number =
            if others.is_empty() { String::new() } else { format!("×{} ", figures::count(same.len() as u64)) };
        let stored = same.iter().map(|s| s.stored_len).fold(0, u64::saturating_add);
        format!("{} {number}{} {}", first.kind, bytes(stored), first.codec)
    };
    sections.chunk_by(of_one).map(told).collect()
}

/// Lines of one kind that are shown to people; a file may have tens of thousands.
const MOST_LINES: usize = 40;

/// Add a row for each item, up to [`MOST_LINES`], and how many more there are.
fn lines(rows: &mut Vec<(&str, String)>, label: &'static str, items: impl Iterator<Item = String>) {
    let items: Vec<String> = items.collect();
    let count = items.len();
    rows.extend(items.into_iter().take(MOST_LINES).map(|item| (label, item)));
    rows.extend(more(count, "--json").map(|text| (label, text)));
}

/// How many items are not shown, and the option that shows them.
fn more(count: usize, option: &str) -> Option<String> {
    (count > MOST_LINES)
        .then(|| format!("… and {} more; {option} shows them", figures::count((count - MOST_LINES) as u64)))
}

fn sections(info: &FileInfo) -> String {
    let mut table = Table::default();
    let heading = ["offset", "stored", "decoded", "records", "size", "codec", "align", "schema", "flags"];
    table.row("type", heading.map(str::to_string));
    for s in &info.sections {
        let ordinal = if s.ordinal == 0 { String::new() } else { format!("[{}]", s.ordinal) };
        let figures = [s.offset, s.stored_len, s.raw_len, s.elem_count].map(figures::count);
        let rest = [s.elem_size.to_string(), s.codec.clone(), s.align.to_string(), s.schema.to_string()];
        table.row(format!("{}{ordinal}", s.kind), figures.into_iter().chain(rest).chain([s.flags.names.join("|")]));
    }
    table.render()
}

/// One value: text without quotes, numbers as they are, anything deeper as JSON.
fn field_of(info: &FileInfo, name: &str) -> Result<String, Failure> {
    let all = serde_json::to_value(info)
        .map_err(|e| Failure::new(Exit::Internal, "cannot write JSON").fact(e.to_string()))?;
    let mut value = &all;
    for part in name.split('.') {
        let inner = part.parse::<usize>().ok().and_then(|i| value.get(i)).or_else(|| value.get(part));
        value = inner.ok_or_else(|| unknown_field(name, part, value))?;
    }
    Ok(value.as_str().map_or_else(|| value.to_string(), names::escape))
}

fn unknown_field(name: &str, part: &str, place: &serde_json::Value) -> Failure {
    let known = match place {
        serde_json::Value::Object(map) => map.keys().cloned().collect::<Vec<_>>().join(", "),
        serde_json::Value::Array(items) => format!("0 to {}", items.len().saturating_sub(1)),
        _ => "nothing".to_string(),
    };
    Failure::new(Exit::Usage, format!("cannot show the field {}", names::escape(name)))
        .fact(format!("there is no {} here; there is: {known}", names::escape(part)))
}
