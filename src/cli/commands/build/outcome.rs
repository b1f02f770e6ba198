//! What became of each output, as a line for people and as an object for machines.

use super::plan::Job;
use super::remarks::Remark;
use crate::cache::WriteSummary;
use crate::cli::failure::ErrorObject;
use crate::cli::figures;
use crate::cli::names;
use crate::compile::Placing;
use crate::report::file::FileReport;
use crate::report::info::{FileInfo, hex};
use crate::scene::{Posed, ReadReport, Rounding};
use crate::sequence::FrameOutcome;
use crate::size::bytes;
use serde::Serialize;
use std::time::Duration;

/// One element of `files` in `bvhc build --json`.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    pub input: String,
    pub output: String,
    /// Its number, where the input is a frame of a pattern.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<i32>,
    pub status: Status,
    /// Why it was or would be built.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub build_key: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub built: Option<Built>,
    /// What a warning says of the model; of an output that is up to date, what its META says was left out.
    pub warnings: Vec<Remark>,
    /// What was read of a model that would be built.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<Model>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorObject>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    Built,
    UpToDate,
    WouldBuild,
    Failed,
}

/// The figures of a finished build.
#[derive(Clone, Debug, Serialize)]
pub struct Built {
    pub triangles: u64,
    pub references: u64,
    /// References beyond one per triangle, as a share of the triangles.
    pub duplication: f64,
    /// Of trees over triangles; of a sequence those of all poses.
    pub nodes: u64,
    /// Of the tree over the instances; of a sequence those of all placements.
    pub top_nodes: u64,
    pub trees: u64,
    pub instances: u64,
    pub instanced_triangles: u64,
    /// Of trees over triangles; of a sequence, of any tree.
    pub max_depth: u32,
    /// Over several trees, the mean weighted by the areas of their roots.
    pub sah: Option<f64>,
    pub file_len: u64,
    pub content_id: String,
    /// What became of each frame of a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sequence: Option<SequenceBuilt>,
    #[serde(flatten)]
    pub arrival: Arrival,
    pub times: Times,
    /// Largest resident set of the process, in bytes: where it built nothing else, and the system tells.
    pub peak_memory: Option<u64>,
}

/// The frames of a sequence that was built.
#[derive(Clone, Debug, Serialize)]
pub struct SequenceBuilt {
    /// Meshes over all frames that stand as in a frame before.
    pub same: u64,
    /// Trees that were refitted.
    pub refitted: u64,
    /// Trees that were built, those for all frames together and those for one.
    pub built: u64,
    /// Meshes over all frames that were taken from the file that was there before.
    pub taken: u64,
    /// Frames whose models were read, or that were posed.
    pub read: u64,
    pub frames: Vec<FrameOutcome>,
}

impl SequenceBuilt {
    /// `surveyed` trees were made for all frames together.
    pub fn new(frames: Vec<FrameOutcome>, surveyed: u64, read: u64) -> SequenceBuilt {
        let sum = |count: fn(&FrameOutcome) -> u64| frames.iter().map(count).sum();
        let (same, refitted, built) = (sum(|f| f.same), sum(|f| f.refitted), surveyed + sum(|f| f.built));
        SequenceBuilt { same, refitted, built, taken: sum(|f| f.taken), read, frames }
    }
}

/// How a model came from its file to where its trees are built.
#[derive(Clone, Debug, Serialize)]
pub struct Arrival {
    /// What reading left out.
    pub read: ReadReport,
    /// What rounding in reading cost.
    pub rounding: Rounding,
    /// What putting meshes where they stand cost.
    pub placing: Placing,
    /// The moment of an animation that it stands at.
    pub posed: Option<Posed>,
    /// What people are told of all this, one sentence each.
    pub remarks: Vec<String>,
    /// Those of them that warn, which the outcome has.
    #[serde(skip)]
    pub warnings: Vec<Remark>,
}

impl Arrival {
    pub fn new(
        read: ReadReport,
        rounding: Rounding,
        placing: Placing,
        posed: Option<Posed>,
        warnings: Vec<Remark>,
    ) -> Arrival {
        let moment = posed.as_ref().map(ToString::to_string);
        let remarks = warnings.iter().map(|warning| warning.text.clone()).chain(moment).collect();
        Arrival { read, rounding, placing, posed, remarks, warnings }
    }
}

/// A model that was read and put where it stands, and no more.
#[derive(Clone, Debug, Serialize)]
pub struct Model {
    /// Those that trees would be built over.
    pub triangles: u64,
    pub trees: u64,
    /// 0 with one level.
    pub instances: u64,
    #[serde(flatten)]
    pub arrival: Arrival,
}

/// Where the time went.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Times {
    pub read_ms: f64,
    pub build_ms: f64,
    /// Hashing the inputs again and writing; of an only output also syncing and renaming, which several wait for together.
    pub write_ms: f64,
    pub total_ms: f64,
}

impl Times {
    /// What is neither reading nor building is writing.
    pub fn new(read: Duration, build: Duration, total: Duration) -> Times {
        let millis = |d: Duration| (d.as_secs_f64() * 1e5).round() / 1e2;
        Times {
            read_ms: millis(read),
            build_ms: millis(build),
            write_ms: millis(total.saturating_sub(read + build)),
            total_ms: millis(total),
        }
    }
}

impl Times {
    /// Add the time until the output was in its place.
    pub fn wait(&mut self, time: Duration) {
        for part in [&mut self.write_ms, &mut self.total_ms] {
            *part = ((*part + time.as_secs_f64() * 1e3) * 1e2).round() / 1e2;
        }
    }
}

impl Outcome {
    pub fn new(job: &Job, status: Status) -> Outcome {
        Outcome {
            input: job.input.to_string_lossy().into_owned(),
            output: job.output.to_string_lossy().into_owned(),
            frame: job.frame,
            status,
            reason: None,
            build_key: None,
            built: None,
            warnings: Vec::new(),
            model: None,
            error: None,
        }
    }
}

impl Built {
    pub fn new(report: &FileReport, written: &WriteSummary, arrival: Arrival, times: Times) -> Built {
        let header = &written.header;
        Built {
            triangles: header.prim_count,
            references: header.ref_count,
            duplication: report.blas.duplication,
            nodes: report.blas.nodes,
            top_nodes: report.tlas.as_ref().map_or(0, |top| top.nodes),
            trees: u64::from(header.blas_count),
            instances: u64::from(header.instance_count),
            instanced_triangles: report.instanced_triangles,
            max_depth: report.blas.max_depth,
            sah: Some(report.blas.sah),
            file_len: header.file_len,
            content_id: hex(&header.content_id),
            sequence: None,
            arrival,
            times,
            peak_memory: None,
        }
    }

    /// Of a sequence: triangles, references, trees and instances of all topologies and placements; no SAH, which each frame has its own of.
    pub fn of_sequence(sequence: SequenceBuilt, written: &WriteSummary, arrival: Arrival, times: Times) -> Built {
        let header = &written.header;
        let extra = header.ref_count.saturating_sub(header.prim_count);
        let FileInfo { nodes, top_nodes, .. } = FileInfo::new(header, &written.sections, None);
        Built {
            triangles: header.prim_count,
            references: header.ref_count,
            duplication: if header.prim_count == 0 { 0.0 } else { extra as f64 / header.prim_count as f64 },
            nodes,
            top_nodes,
            trees: u64::from(header.blas_count),
            instances: u64::from(header.instance_count),
            instanced_triangles: sequence.frames.iter().map(|frame| frame.instanced_triangles).sum(),
            max_depth: header.max_depth,
            sah: None,
            file_len: header.file_len,
            content_id: hex(&header.content_id),
            sequence: Some(sequence),
            arrival,
            times,
            peak_memory: None,
        }
    }

    /// `heli.bvhc  20 frames of up to 30,000 tris, 1 topology: 1 tree built, 19 refitted, 40 as before; 4.1 MiB (210 KiB a frame), 0.8 s`
    fn sequence_line(&self, job: &Job, sequence: &SequenceBuilt) -> String {
        let counted = figures::counted;
        let frames = sequence.frames.len() as u64;
        let most = sequence.frames.iter().map(|frame| frame.instanced_triangles).max().unwrap_or(0);
        let took = figures::seconds(Duration::from_secs_f64(self.times.total_ms / 1e3));
        let each = bytes(self.file_len / frames.max(1));
        let taken = match sequence.taken {
            0 => String::new(),
            taken => format!(", {} unchanged", figures::count(taken)),
        };
        format!(
            "{}  {} of up to {}, {}: {} built, {} refitted, {} as before{taken}; {} ({each} a frame), {took}",
            names::path(&job.output),
            counted(frames, "frame", "frames"),
            counted(most, "tri", "tris"),
            counted(self.trees, "topology", "topologies"),
            counted(sequence.built, "tree", "trees"),
            figures::count(sequence.refitted),
            figures::count(sequence.same),
            bytes(self.file_len),
        )
    }

    /// `rock.bvhc  69,451 tris → 84,120 refs (+21.1%), 91,377 nodes, depth 22, SAH 31.4, 3.1 MiB, 0.41 s`
    pub fn line(&self, job: &Job) -> String {
        if let Some(sequence) = &self.sequence {
            return self.sequence_line(job, sequence);
        }
        let counted = figures::counted;
        let tris = |n| counted(n, "tri", "tris");
        let refs = counted(self.references, "ref", "refs");
        let share = self.duplication * 100.0;
        let mut line = format!("{}  {} → {refs} ({share:+.1}%)", names::path(&job.output), tris(self.triangles));
        if self.instances > 0 {
            let trees = counted(self.trees, "tree", "trees");
            let instances = counted(self.instances, "instance", "instances");
            line += &format!(" in {trees}, {instances} ({})", tris(self.instanced_triangles));
        }
        line += &format!(", {}, depth {}", counted(self.nodes, "node", "nodes"), self.max_depth);
        let took = figures::seconds(Duration::from_secs_f64(self.times.total_ms / 1e3));
        let cost = self.sah.map_or_else(String::new, |sah| format!(", SAH {}", figures::cost(sah)));
        line + &format!("{cost}, {}, {took}", bytes(self.file_len))
    }

    /// Phases and memory, for `-v`.
    pub fn detail(&self, job: &Job) -> String {
        let t = &self.times;
        let memory = self.peak_memory.map_or_else(String::new, |m| {
            // Of a small model, nearly all is the program itself.
            let each = Some(self.triangles).filter(|n| *n >= FEWEST_TO_DIVIDE).map(|n| m / n);
            let each = each.map_or_else(String::new, |b| format!(" ({b} bytes per triangle)"));
            format!(", peak memory {}{each}", bytes(m))
        });
        let name = names::path(&job.output);
        format!("{name}: read {:.0} ms, build {:.0} ms, write {:.0} ms{memory}", t.read_ms, t.build_ms, t.write_ms)
    }
}

/// Triangles from which on the memory of a triangle says more of the build than of the program.
const FEWEST_TO_DIVIDE: u64 = 1 << 16;

/// `VmHWM` of Linux; other systems do not tell without more code than the figure is worth.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}
