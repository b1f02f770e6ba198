//! `bvhc convert`: another codec, the same content; or one frame of a sequence as a still file.

use super::build::options::NodeForm;
use super::build::parse_codec;
use super::build::same_file;
use super::still;
use crate::cache::{self, Codec, ConvertOptions, Header, WriteOptions};
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::interrupt;
use crate::cli::names;
use crate::cli::outputs;
use crate::report::info::hex;
use crate::size::bytes;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Store a cache file with another codec; its content stays the same, and so does its content id
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  bvhc convert rock.bvhc -o rock.small.bvhc --codec zstd:19\n  bvhc convert rock.small.bvhc -o rock.bvhc --codec raw\n  bvhc convert rock.bvhc -o rock.wide.bvhc --nodes compact8  rays are traced faster\n  bvhc convert heli.bvhc -o heli.7.bvhc --frame 7            one frame of a sequence"
)]
pub struct ConvertArgs {
    /// Cache file to read
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// Cache file to write
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Of a sequence: the number of the frame that becomes a still file
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<i32>,
    /// How sections are stored: raw can be mapped, zstd is smaller (levels 1 to 22, usually 3), compact is about a tenth of a raw sequence (level
    /// usually 9) and zstd in a still file
    #[arg(long, value_name = "raw|zstd[:LEVEL]|compact[:LEVEL]", default_value = "raw", value_parser = parse_codec)]
    codec: Codec,
    /// In which forms the trees are stored: binary always, and with compact8 also with eight children a node [default: those that IN has]
    #[arg(long, value_name = "FORM,…", value_enum, value_delimiter = ',')]
    nodes: Vec<NodeForm>,
    /// Write over a file that is no cache, too
    #[arg(short, long)]
    force: bool,
    /// Leave out the provenance; `bvhc build` then takes the file for out of date
    #[arg(long, conflicts_with = "frame")]
    drop_meta: bool,
    /// Leave out sections that this version does not know
    #[arg(long, conflicts_with = "frame")]
    strip_unknown: bool,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    input: &'a str,
    output: &'a str,
    input_len: u64,
    output_len: u64,
    content_id: String,
    dropped: Vec<String>,
}

pub fn run(args: &ConvertArgs, context: &Context) -> Result<Exit, Failure> {
    if same_file(&args.input, &args.output) {
        return Err(Failure::new(Exit::Usage, "cannot convert a file into itself")
            .fact(format!("{} and {} are one file", names::path(&args.input), names::path(&args.output)))
            .help("name another output with -o"));
    }
    outputs::is_no_pipe(&args.output)?;
    outputs::writable(&args.output)?;
    if !args.force {
        outputs::may_replace(&args.output)?;
    }
    let write = WriteOptions { codec: args.codec, ..WriteOptions::default() };
    let compact = Some(NodeForm::any_compact(&args.nodes)).filter(|_| !args.nodes.is_empty());
    let options = ConvertOptions { write, compact, strip_unknown: args.strip_unknown, drop_meta: args.drop_meta };

    if let Some(number) = args.frame {
        return extract(args, number, write, context);
    }

    if compact == Some(true) && caches::is_sequence(&args.input, context) {
        let action = format!("cannot convert {}", names::path(&args.input));
        return Err(Failure::new(Exit::Usage, action)
            .fact("--nodes compact8 is about still files, and this is a sequence")
            .help("leave it out, or add --frame N to take one frame out"));
    }

    // The permission to write is held over the reading too: the library does both in one step.
    let publishing = interrupt::publish()?;
    let done = cache::convert(&args.input, &args.output, &caches::options(context), &options, &context.exec)
        .map_err(|e| caches::failure(&e))?;
    drop(publishing);
    let input_len = length(&args.input);
    let header = done.written.header;
    let dropped: Vec<String> = done.dropped.iter().map(ToString::to_string).collect();
    if context.terminal.json {
        tell(args, &header, input_len, dropped, context)?;
        return Ok(Exit::Success);
    }
    if !dropped.is_empty() {
        context.terminal.warn(&format!("left out {}", dropped.join(", ")));
    }
    if !context.terminal.quiet {
        let (from, to) = (bytes(input_len), bytes(header.file_len));
        let id = &hex(&header.content_id)[..8];
        context.terminal.result(&format!("{}  {from} → {to}, content {id} unchanged", names::path(&args.output)))?;
    }
    Ok(Exit::Success)
}

/// What was written, as JSON.
fn tell(
    args: &ConvertArgs,
    header: &Header,
    input_len: u64,
    dropped: Vec<String>,
    context: &Context,
) -> Result<(), Failure> {
    context.terminal.document(&Document {
        schema: "bvhc.convert.v1",
        input: &args.input.to_string_lossy(),
        output: &args.output.to_string_lossy(),
        input_len,
        output_len: header.file_len,
        content_id: hex(&header.content_id),
        dropped,
    })
}

/// Write one frame of a sequence as a still file.
fn extract(args: &ConvertArgs, number: i32, write: WriteOptions, context: &Context) -> Result<Exit, Failure> {
    let sequence = caches::open_sequence(&args.input, context)?;
    let frame = caches::frame(&sequence, &args.input, number, context)?;
    let (mut image, meta) = still::of_frame(&sequence, &frame);
    if NodeForm::any_compact(&args.nodes) {
        image.add_compact().map_err(|e| caches::failure(&e))?;
    }
    let publishing = interrupt::publish()?;
    let written =
        cache::write_file(&args.output, &image, &meta, &write, &context.exec).map_err(|e| caches::failure(&e))?;
    drop(publishing);
    let (input_len, header) = (length(&args.input), written.header);
    if context.terminal.json {
        tell(args, &header, input_len, Vec::new(), context)?;
    } else if !context.terminal.quiet {
        let (from, to) = (bytes(input_len), bytes(header.file_len));
        context.terminal.result(&format!("{}  frame {number}: {from} → {to}", names::path(&args.output)))?;
    }
    Ok(Exit::Success)
}

fn length(path: &Path) -> u64 {
    path.metadata().map_or(0, |m| m.len())
}
