//! `bvhc convert`: another codec, the same content; or one frame of a sequence as a still file.

use super::build::options::NodeForm;
use super::build::parse_codec;
use super::still;
use crate::cache::{self, Codec, ConvertOptions, Header, Sequence, WriteOptions};
use crate::cli::Context;
use crate::cli::caches::{self, KeptOpen};
use crate::cli::exit::Exit;
use crate::cli::failure::{Entry, Failure};
use crate::cli::frame_list::FrameList;
use crate::cli::interrupt;
use crate::cli::names;
use crate::cli::outputs;
use crate::cli::patterns;
use crate::report::info::hex;
use crate::size::bytes;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::RwLockReadGuard;

/// Store cache files with another codec; their content stays the same, and so does their content id
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  bvhc convert rock.bvhc -o rock.small.bvhc --codec zstd:19\n  bvhc convert rock.small.bvhc -o rock.bvhc --codec raw\n  bvhc convert rock.bvhc -o rock.wide.bvhc --nodes compact8  rays are traced faster\n  bvhc convert heli.bvhc -o heli.7.bvhc --frame 7            one frame of a sequence\n  bvhc convert heli.bvhc -o heli.%04d.bvhc --frame all       each frame as a still file\n  bvhc convert caches/ -o small/ --codec zstd:19             all files of a folder"
)]
pub struct ConvertArgs {
    /// Cache files to read, folders of them, or quoted patterns such as 'caches/**/*.bvhc'
    #[arg(required = true, value_name = "IN")]
    inputs: Vec<PathBuf>,
    /// Cache file to write, or a folder (`DIR/`) that receives a file of the same name for each; of several frames a folder, or a name with a place for the number
    /// such as heli.%04d.bvhc
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Of a sequence: the frames that become still files: one number, a list such as 1-100 or 1,5-9, or all
    #[arg(long, value_name = "all|LIST", allow_hyphen_values = true, value_parser = FrameList::parse)]
    frame: Option<FrameList>,
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

/// What became of each file.
#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    files: &'a [Entry<Converted>],
}

#[derive(Serialize)]
struct Converted {
    /// Of the file that was read.
    path: String,
    output: String,
    /// The number of the sequence's frame that was taken out.
    frame: Option<i32>,
    /// Bytes.
    input_len: u64,
    output_len: u64,
    content_id: String,
    dropped: Vec<String>,
}

pub fn run(args: &ConvertArgs, context: &Context) -> Result<Exit, Failure> {
    let inputs = patterns::expand(&args.inputs, patterns::CACHES, "convert", &context.terminal)?;
    let sources = FrameList::sources(args.frame.as_ref(), &inputs, "convert", context)?;
    let outputs = outputs::of_each(&sources, &args.output, "bvhc", "convert")?;
    let mut outputs = outputs.iter();
    let mut open = KeptOpen::new(context);
    let things = sources.iter().map(|source| (source.path.as_path(), source.frame));
    let (files, exit) = caches::each_of(things, context, |(input, frame)| {
        let output = outputs.next().map_or(args.output.as_path(), PathBuf::as_path);
        // What was written is told before a signal may end the process.
        let (converted, _publishing) = convert(input, frame, output, args, &mut open, context)?;
        if !context.terminal.json {
            tell(&converted, context)?;
        }
        Ok(converted)
    });
    if context.terminal.json {
        context.terminal.document(&Document { schema: "bvhc.convert.v1", exit_code: exit.code(), files: &files })?;
    }
    Ok(exit)
}

/// The permission to write is held by whoever tells of it.
type Publishing = RwLockReadGuard<'static, ()>;

fn convert(
    input: &Path,
    frame: Option<i32>,
    output: &Path,
    args: &ConvertArgs,
    open: &mut KeptOpen<'_>,
    context: &Context,
) -> Result<(Converted, Publishing), Failure> {
    outputs::is_no_pipe(output)?;
    outputs::make_folder(output, &args.output)?;
    outputs::writable(output)?;
    if !args.force {
        outputs::may_replace(output)?;
    }
    let write = WriteOptions { codec: args.codec, ..WriteOptions::default() };
    let compact = Some(NodeForm::any_compact(&args.nodes)).filter(|_| !args.nodes.is_empty());
    let of = |header: &Header, dropped: Vec<String>| Converted {
        path: input.to_string_lossy().into_owned(),
        output: output.to_string_lossy().into_owned(),
        frame,
        input_len: input.metadata().map_or(0, |m| m.len()),
        output_len: header.file_len,
        content_id: hex(&header.content_id),
        dropped,
    };
    if let Some(number) = frame {
        let sequence = open.sequence(input)?;
        let (header, publishing) = extract(sequence, input, output, number, args, write, context)?;
        return Ok((of(&header, Vec::new()), publishing));
    }
    if compact == Some(true) && caches::is_sequence(input, context) {
        return Err(Failure::new(Exit::Usage, format!("cannot convert {}", names::path(input)))
            .fact("--nodes compact8 is about still files, and this is a sequence")
            .help("leave it out, or add --frame N to take one frame out"));
    }
    let options = ConvertOptions { write, compact, strip_unknown: args.strip_unknown, drop_meta: args.drop_meta };
    // The permission to write is held over the reading too: the library does both in one step.
    let publishing = interrupt::publish()?;
    let done = cache::convert(input, output, &caches::options(context), &options, &context.exec)
        .map_err(|e| caches::failure(&e))?;
    Ok((of(&done.written.header, done.dropped.iter().map(ToString::to_string).collect()), publishing))
}

/// Write one frame of a sequence as a still file.
fn extract(
    sequence: &Sequence,
    input: &Path,
    output: &Path,
    number: i32,
    args: &ConvertArgs,
    write: WriteOptions,
    context: &Context,
) -> Result<(Header, Publishing), Failure> {
    let frame = caches::frame(sequence, input, number, context)?;
    let (mut image, meta) = still::of_frame(sequence, &frame);
    if NodeForm::any_compact(&args.nodes) {
        image.add_compact().map_err(|e| caches::failure(&e))?;
    }
    let publishing = interrupt::publish()?;
    let written = cache::write_file(output, &image, &meta, &write, &context.exec).map_err(|e| caches::failure(&e))?;
    Ok((written.header, publishing))
}

/// What was written, as text.
fn tell(converted: &Converted, context: &Context) -> Result<(), Failure> {
    let terminal = &context.terminal;
    if !converted.dropped.is_empty() {
        terminal.warn(&format!("left out {}", converted.dropped.join(", ")));
    }
    if terminal.quiet {
        return Ok(());
    }
    let (from, to) = (bytes(converted.input_len), bytes(converted.output_len));
    let output = names::path(Path::new(&converted.output));
    terminal.result(&match converted.frame {
        Some(number) => format!("{output}  frame {number}: {from} → {to}"),
        None => format!("{output}  {from} → {to}, content {} unchanged", &converted.content_id[..8]),
    })
}
