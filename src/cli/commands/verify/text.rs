//! The verdict on a file for people.

use super::FrameSum;
use super::file::Verified;
use crate::cli::Context;
use crate::cli::figures;
use crate::cli::names;
use crate::cli::table::Table;
use crate::cli::terminal::Paint;
use crate::scene::Loss;
use crate::trace::Hit;
use crate::verify::{
    Asked, Counts, DeviceOutcome, Expected, Got, Mismatch, OracleOutcome, Placed, Plan, set_name, write_ray,
};
use std::path::Path;
use std::time::Duration;

pub fn verdict(verified: &Verified, plan: &Plan, context: &Context) -> String {
    let (terminal, outcome) = (&context.terminal, &verified.outcome);
    let word =
        if verified.is_right() { terminal.paint(Paint::Green, "right") } else { terminal.paint(Paint::Red, "wrong") };
    let against = match &verified.source {
        Some(model) => names::path(model),
        None => "its own triangles".to_string(),
    };
    let sets = match plan.sets[..] {
        [set] => set_name(set).to_string(),
        _ => format!("{} sets", plan.sets.len()),
    };
    let name = verified.title();
    let mut text = format!("{name}: {word} (against {against}; rays of {sets}, seed {})\n", plan.seed);

    let mut table = Table::default();
    for device in &outcome.devices {
        row(&mut table, &device.name, &device.total(), plan);
        if terminal.verbose > 0 {
            for (set, counts) in &device.sets {
                row(&mut table, &format!("  {}", set_name(*set)), counts, plan);
            }
        }
    }
    text.push_str(&table.render());
    for device in outcome.devices.iter().skip(1) {
        let (name, total) = (&device.name, device.total());
        text.push_str(&format!("{name}: {}\n", names::escape(&device.description)));
        text.push_str(&deviation(device));
        if total.brute_rays > 0 {
            let (rays, other) = (figures::counted(total.brute_rays, "ray", "rays"), figures::count(total.brute_unlike));
            let took = figures::seconds(Duration::from_secs_f64(total.brute_seconds));
            text.push_str(&format!(
                "{name}: {rays} traced without the tree, too: {other} answered otherwise then; {took}\n"
            ));
        }
    }
    if verified.is_lowered {
        text.push_str(
            "fewer rays than elsewhere, since each enters so many nodes and triangles here; --rays N traces more\n",
        );
    }
    text.push_str(&oracle(&outcome.oracle, verified.rays));
    if terminal.verbose > 0 {
        let entries = figures::counted(verified.stack.into(), "node waits", "nodes wait");
        text.push_str(&format!("at most {entries} on the stack of a traversal, by the depth of the trees\n"));
    }
    text.push_str(&verified.placed.as_ref().map(placing).unwrap_or_default());
    let first = outcome.devices.first().and_then(|d| d.first_mismatch.as_ref());
    for (i, device) in outcome.devices.iter().enumerate() {
        match (&device.first_mismatch, first) {
            (Some(m), Some(first)) if i > 0 && same(m, first) => {
                text.push_str(&format!("{} {} by the same ray in the same way\n", m.device, m.class.words()));
            }
            (Some(m), _) => text.push_str(&told(m, verified, device.total().mismatches())),
            (None, _) => {}
        }
    }
    text
}

/// What the frames of a sequence come to, in one line.
pub fn sum(path: &Path, sum: &FrameSum, context: &Context) -> String {
    let FrameSum { frames, right, rays, hits, mismatches } = *sum;
    let (word, paint) = if right == frames { ("right", Paint::Green) } else { ("wrong", Paint::Red) };
    let count = if right == frames { frames } else { frames - right };
    format!(
        "{}: {} of {} {}; {}, {}, {}\n",
        names::path(path),
        figures::count(count),
        figures::counted(frames, "frame", "frames"),
        context.terminal.paint(paint, word),
        figures::counted(rays, "ray", "rays"),
        figures::counted(hits, "hit", "hits"),
        figures::counted(mismatches, "mismatch", "mismatches"),
    )
}

fn row(table: &mut Table, name: &str, counts: &Counts, plan: &Plan) {
    let seconds = if plan.asked == Asked::AnyHit { counts.any_seconds } else { counts.seconds };
    let rate = match seconds > 0.0 {
        true => format!("{:.2} M rays/s", counts.rays as f64 / seconds / 1e6),
        false => String::new(),
    };
    let cells = [
        figures::counted(counts.rays, "ray", "rays"),
        figures::counted(counts.hits, "hit", "hits"),
        figures::counted(counts.mismatches(), "mismatch", "mismatches"),
        figures::counted(counts.ties, "tie", "ties"),
        figures::seconds(Duration::from_secs_f64(seconds)),
        rate,
    ];
    table.row(name, cells);
}

/// What a device whose arithmetic differs made of it.
fn deviation(device: &DeviceOutcome) -> String {
    let Some(deviation) = &device.deviation else { return String::new() };
    let total = device.total();
    let differ = [
        (total.ties, "ties"),
        (total.grazing, "at edges passed within rounding"),
        (total.unsure, "where rounding an instance's matrix decides"),
        (total.rounding, "in the last bits alone"),
        (total.unjudged, "not judged"),
    ];
    let differ: Vec<String> =
        differ.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{} {what}", figures::count(n))).collect();
    let differ = if differ.is_empty() { "none did".to_string() } else { differ.join(", ") };
    format!("{}: answers may differ from the CPU's, since {}: {differ}\n", device.name, names::escape(deviation))
}

fn oracle(oracle: &OracleOutcome, rays: u64) -> String {
    let tested = format!(
        "{} tested, each against the triangle that it names\n",
        figures::counted(oracle.hits_tested, "hit", "hits")
    );
    let all = if oracle.rays == rays { "all" } else { "a sample of" };
    tested
        + &format!(
            "brute force over {} triangles judges {all} {}: {} missed, {} farther, {} false; {}, {} grazing, {} unsure; {}\n",
            figures::count(oracle.instanced_triangles),
            figures::counted(oracle.rays, "ray", "rays"),
            figures::count(oracle.missed),
            figures::count(oracle.farther),
            figures::count(oracle.false_hits),
            figures::counted(oracle.ties, "tie", "ties"),
            figures::count(oracle.grazing),
            figures::count(oracle.unsure),
            figures::seconds(Duration::from_secs_f64(oracle.seconds)),
        )
}

/// How the triangles stand to the model's.
pub fn placing(placed: &Placed) -> String {
    let Placed { loss, read, astray, .. } = placed;
    let triangles = figures::counted(placed.instanced_triangles, "triangle", "triangles");
    let rounded = |what: &str, loss: &Loss| {
        let (share, most) = (100.0 * loss.share, 100.0 * Loss::MOST);
        let share = if share < 0.01 { "less than 0.01".to_owned() } else { format!("{share:.2}") };
        let verdict = match loss.is_tolerable() {
            true => String::new(),
            false if loss.share <= Loss::MOST => {
                format!("; wrong: nothing is left of {:.2}% of the triangles", 100.0 * loss.gone)
            }
            false => format!("; wrong: more than {most:.1}% moves hits"),
        };
        format!("{what} by up to {:.3e}, {share}% of a triangle's shortest edge on average{verdict}\n", loss.farthest)
    };
    let held = format!("{triangles} held against the model in f64");
    let mut text = match (loss.farthest, read.farthest) {
        (0.0, 0.0) => format!("{held}: no corner is moved by rounding to f32\n"),
        (0.0, _) => rounded(&format!("{held}: reading it as f32 moves corners"), read),
        _ => rounded(&format!("{held}: rounding moves corners"), loss),
    };
    if loss.farthest > 0.0 && read.farthest > 0.0 {
        text.push_str(&rounded("reading the model as f32 moved them before", read));
    }
    if *astray > 0 {
        let some = figures::counted(*astray, "triangle is", "triangles are");
        text.push_str(&format!("{some} not where the model has them; wrong: no rounding explains it\n"));
    }
    text
}

fn same(a: &Mismatch, b: &Mismatch) -> bool {
    (a.set, a.index, a.query, a.class, a.got) == (b.set, b.index, b.query, b.class, b.got)
}

/// A device's first mismatch, and how to see it again.
fn told(m: &Mismatch, verified: &Verified, mismatches: u64) -> String {
    let others = match mismatches - 1 {
        0 => String::new(),
        n => format!("; {} after it", figures::counted(n, "mismatch", "mismatches")),
    };
    let mut text = format!("{} {}{others}\n", m.device, m.class.words());
    text.push_str(&format!("  ray       {}  (number {} of {})\n", write_ray(&m.ray), m.index, set_name(m.set)));
    text.push_str(&format!("  expected  {}\n", expected(&m.expected)));
    text.push_str(&format!("  got       {}\n", got(&m.got)));
    if let Some(blame) = &m.blame {
        text.push_str(&format!("  to blame  {}\n", names::escape(&blame.to_string())));
    }
    let name = names::path(&verified.path);
    let ray = write_ray(&m.ray);
    if let Some(number) = verified.frame {
        text.push_str(&format!(
            "help: bvhc convert {name} -o STILL --frame {number} && bvhc verify STILL --ray {ray}\n"
        ));
        return text;
    }
    let source = verified.source.as_ref().map_or_else(String::new, |s| format!(" --source {}", names::path(s)));
    // The CPU traces in any case, the compact trees of a file too.
    let is_opened = m.device.starts_with("opencl");
    let device = if is_opened { format!(" --device {}", m.device) } else { String::new() };
    text.push_str(&format!("help: bvhc verify {name}{source}{device} --ray {ray}\n"));
    text
}

pub fn expected(expected: &Expected) -> String {
    match expected {
        Expected::Hit { source, prim, nearest, farthest } => {
            format!("triangle {prim} of instance {} at t = {}", source.instance, interval(*nearest, *farthest))
        }
        Expected::Nothing => "nothing".to_string(),
        Expected::Reference(found) => hit(found.as_ref()),
    }
}

pub fn got(got: &Got) -> String {
    match got {
        Got::Hit(found) => hit(Some(found)),
        Got::Nothing => "nothing".to_string(),
        Got::Any(true) => "some hit".to_string(),
        Got::Any(false) => "no hit at all".to_string(),
        Got::Malformed(reason) => reason.to_string(),
    }
}

pub fn hit(found: Option<&Hit>) -> String {
    let Some(h) = found else { return "nothing".to_string() };
    let instance = h.instance.map_or_else(String::new, |i| format!(" of instance {i}"));
    format!("triangle {}{instance} at t = {:?}, TRIS[{}], u = {:?}, v = {:?}", h.prim, h.t, h.triangle, h.u, h.v)
}

/// Both ends, unless they are one number in `f32`.
pub fn interval(nearest: f64, farthest: f64) -> String {
    let (a, b) = (nearest as f32, farthest as f32);
    if a == b { format!("{a:?}") } else { format!("{nearest:?} … {farthest:?}") }
}
