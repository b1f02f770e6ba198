//! The check, at every level, and its agreement with the reader.

use super::reader::{MOST_FRAMES, allowance, open_frames, trace, trace_compact, trace_turned};
use super::{Target, limit};
use crate::guard::within;
use crate::mutate::file;
use crate::planted::Seen;
use bvhc::cache::check::{Level, Limits, check_bytes};
use bvhc::cache::{Cache, CacheError, OpenOptions, Validation, rules};
use bvhc::exec::Executor;
use bvhc::report::overlap::{EpoMode, EpoReport};
use bvhc::report::stats::TreeStats;

/// What a reader of frames does without: what no ray needs, and what the header and other frames say.
fn is_of_no_frame(id: &str) -> bool {
    let ids = [
        "E0301", "E0303", "E0306", "E0307", "E0309", "E0320", "E0321", "E0322", "E0323", "E0324", "E0325", "E0705",
        "E0709",
    ];
    id.starts_with("E02") || ids.contains(&id)
}

pub const TARGET: Target = Target { name: "check", run, change: file::change, faults: &["E0425", "E0408", "E0503"] };

fn run(input: &[u8]) -> Seen {
    let limits = Limits { max_memory: limit(input), ..Limits::default() };
    let exec = Executor::sequential();
    let mut worse = 0;
    let mut report = None;
    for level in [Level::Quick, Level::Hash, Level::Tree] {
        let found = within(allowance(input), || check_bytes(input, level, None, &limits, &exec));
        let errors = usize::from(!found.is_valid());
        assert!(errors >= worse, "{level:?} takes back what a lower level found");
        worse = errors;
        report = Some(found);
    }
    let report = report.expect("three levels");

    // What one says of a file the other says too, but for a limit of memory, which both have.
    let options = OpenOptions { validation: Validation::Tree, max_memory: limit(input), ..OpenOptions::default() };
    match Cache::from_slice(input, &options) {
        Ok(cache) => {
            // The reader does without what no ray needs: provenance, and sections that may be skipped.
            let ancillary = ["E0202", "E0205", "E0206", "E0207", "E0208", "E0209", "E0210", "E0320"];
            let worse = report.findings.iter().find(|f| f.rule.id.starts_with('E') && !ancillary.contains(&f.rule.id));
            assert!(worse.is_none(), "the reader opens it, the check: {}", worse.expect("a finding"));
            trace(&cache.view(), cache.header().scene_bounds(), true);
            if let Some(trees) = cache.compact() {
                trace_compact(&trees, cache.header().scene_bounds());
            }
            if let Some(turned) = cache.turned() {
                trace_turned(&turned, cache.header().scene_bounds());
            }
            // Figures of a file that is right.
            let view = cache.view();
            let stats = (0..view.blases.len()).filter_map(|i| view.blas(i));
            let stats: Vec<TreeStats> = stats.map(|b| TreeStats::of_tree(b.nodes, 1)).collect();
            assert!(stats.iter().all(|s| s.max_depth <= 64));
            let epo = EpoReport::of_view(&view, EpoMode::Auto(64), &exec);
            assert!(epo.value >= 0.0, "{epo:?}");
        }
        // How much a frame takes is asked by the reader alone.
        Err(CacheError::Sequence { .. }) => match open_frames(input, &options) {
            Ok(frames) => {
                // Of poses and placements that no frame shows, and of frames that were not looked at, anything may be wrong.
                let unseen = report.count(&rules::W0502) + report.count(&rules::W0701);
                let all_seen = frames <= MOST_FRAMES && unseen == 0;
                let worse = report.findings.iter().find(|f| f.rule.id.starts_with('E') && !is_of_no_frame(f.rule.id));
                assert!(worse.is_none() || !all_seen, "all frames open, the check: {}", worse.expect("a finding"));
            }
            Err(CacheError::Limit { .. }) => {}
            Err(error) => assert!(!report.is_valid(), "the check says valid, the reader: {error}"),
        },
        Err(error) => assert!(!report.is_valid(), "the check says valid, the reader: {error}"),
    }
    report.findings.iter().map(|f| f.rule.id.to_owned()).collect()
}
