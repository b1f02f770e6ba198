//! What became of each output, as a line for people and as an object for machines.

use super::plan::Job;
use crate::cache::{Image, WriteSummary};
use crate::cli::figures;
use crate::cli::names;
use crate::report::file::FileReport;
use crate::report::info::hex;
use crate::scene::ReadReport;
use serde::Serialize;
use std::time::Duration;

/// One element of `results` in `bvhc build --json`.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    pub input: String,
    pub output: String,
    pub status: Status,
    /// Why it was or would be built.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub build_key: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub built: Option<Built>,
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

#[derive(Clone, Debug, Serialize)]
pub struct ErrorObject {
    pub exit_code: u8,
    pub exit_name: &'static str,
    pub error: String,
    pub facts: Vec<String>,
}

/// The figures of a finished build.
#[derive(Clone, Debug, Serialize)]
pub struct Built {
    pub triangles: u64,
    pub references: u64,
    /// References beyond one per triangle, as a share of the triangles.
    pub duplication: f64,
    pub nodes: u64,
    pub trees: u64,
    pub instances: u64,
    pub instanced_triangles: u64,
    pub max_depth: u32,
    /// Over several trees, the mean weighted by the areas of their roots.
    pub sah: f64,
    pub file_len: u64,
    pub content_id: String,
    pub read: ReadReport,
    pub times: Times,
    /// Largest resident set of the process so far, in bytes, where the system tells.
    pub peak_memory: Option<u64>,
}

/// Where the time went.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Times {
    pub read_ms: f64,
    pub build_ms: f64,
    /// Hashing the inputs again, writing, syncing, renaming and the check of the result.
    pub write_ms: f64,
    pub total_ms: f64,
}

impl Outcome {
    pub fn new(job: &Job, status: Status) -> Outcome {
        Outcome {
            input: job.input.to_string_lossy().into_owned(),
            output: job.output.to_string_lossy().into_owned(),
            status,
            reason: None,
            build_key: None,
            built: None,
            error: None,
        }
    }
}

impl Built {
    pub fn new(image: &Image, written: &WriteSummary, read: ReadReport, times: Times) -> Built {
        let header = &written.header;
        let report = FileReport::of_view(String::new(), header.file_len, &image.view());
        Built {
            triangles: header.prim_count,
            references: header.ref_count,
            duplication: report.blas.duplication,
            nodes: header.node_count,
            trees: u64::from(header.blas_count),
            instances: u64::from(header.instance_count),
            instanced_triangles: report.instanced_triangles,
            max_depth: header.max_depth,
            sah: report.blas.sah,
            file_len: header.file_len,
            content_id: hex(&header.content_id),
            read,
            times,
            peak_memory: peak_memory(),
        }
    }

    /// `rock.bvhc  69,451 tris → 84,120 refs (+21.1%), 91,377 nodes, depth 22, SAH 31.4, 3.3 MB, 0.41 s`
    pub fn line(&self, job: &Job) -> String {
        let mut line = format!("{}  {} tris", names::path(&job.output), figures::count(self.triangles));
        line += &format!(" → {} refs ({:+.1}%)", figures::count(self.references), self.duplication * 100.0);
        if self.instances > 0 {
            let instances = figures::count(self.instances);
            let seen = figures::count(self.instanced_triangles);
            line += &format!(" in {} trees, {instances} instances ({seen} tris)", figures::count(self.trees));
        }
        line += &format!(", {} nodes, depth {}", figures::count(self.nodes), self.max_depth);
        let took = figures::seconds(Duration::from_secs_f64(self.times.total_ms / 1e3));
        line + &format!(", SAH {}, {}, {took}", figures::cost(self.sah), figures::bytes(self.file_len))
    }

    /// Phases and memory, for `-v`.
    pub fn detail(&self, job: &Job) -> String {
        let t = &self.times;
        let memory = self.peak_memory.map_or_else(String::new, |m| {
            let each = m.checked_div(self.triangles).map_or_else(String::new, |b| format!(" ({b} bytes per triangle)"));
            format!(", peak memory {}{each}", figures::bytes(m))
        });
        let name = names::path(&job.output);
        format!("{name}: read {:.0} ms, build {:.0} ms, write {:.0} ms{memory}", t.read_ms, t.build_ms, t.write_ms)
    }
}

/// What reading dropped, as a phrase, or `None` for a clean model.
pub fn dropped(report: &ReadReport) -> Option<String> {
    let beyond = format!(" beyond the range of f32 ({:.1e}; the limit is {:.1e})", report.largest_magnitude, f32::MAX);
    let counted = [
        (report.degenerate_triangles, "triangle", " without area"),
        (report.non_finite_triangles, "triangle", " with NaN or infinite positions"),
        (report.skipped_primitives, "line and point primitive", ""),
        (report.singular_instances, "instance", " scaled to nothing"),
        (report.out_of_range_instances, "instance", &beyond),
        (report.hidden_nodes, "hidden node", ""),
        (report.unplayed_animations, "animation", " (everything stands at rest)"),
        (report.unapplied_morph_weights, "morph weight", " without a target"),
    ];
    let found: Vec<String> =
        counted.iter().filter(|c| c.0 > 0).map(|(n, what, which)| phrase(*n, what, which)).collect();
    (!found.is_empty()).then(|| found.join(", "))
}

/// What reading had to decide where the model does not say or may not be followed, each as a sentence.
pub fn decided(report: &ReadReport) -> Vec<String> {
    let counted = [
        (report.unposed_skins, "node", " with a skin but without joints or weights: placed without the skin"),
        (report.uninstanced_skins, "skinned node", " with instances: placed once, by the joints"),
        (report.unweighted_vertices, "vertex without joint weights", ": placed by the first joint"),
    ];
    let found = counted.iter().filter(|c| c.0 > 0).map(|(n, what, which)| phrase(*n, what, which));
    let ignored = report.ignored_extensions.iter();
    found
        .chain(ignored.map(|name| format!("the glTF extension {name}, which may move or change triangles, is ignored")))
        .collect()
}

/// `3 triangles without area`, `1 vertex without weights`.
fn phrase(n: u64, what: &str, which: &str) -> String {
    let plural = match what.strip_prefix("vertex") {
        _ if n == 1 => what.to_string(),
        Some(rest) => format!("vertices{rest}"),
        None => format!("{what}s"),
    };
    format!("{} {plural}{which}", figures::count(n))
}

/// `VmHWM` of Linux; other systems do not tell without more code than the figure is worth.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}
