//! What wide trees cost beside the binary ones that they are made of, a table for each file:
//! `cargo run --release --example wide -- [--rays N] [--rounds N] [--set NAME=VALUE]… FILE.bvhc…`
//!
//! Each tree of the file is collapsed to nodes of 4 and of 8 lanes, once by pulling up the largest child, as other libraries do, and once at least
//! SAH cost. Rays are those of the report: through the pixels of a camera, one diffuse bounce off what it sees, and occlusion from there, N of each.
//! `compact` is the last of these in nodes of 80 bytes; its bytes are those of nodes and of the order of references. The other wide forms also have their
//! triangles once more, in blocks of four with an order, which are not counted: 160 bytes a block. A node that a ray enters tests all
//! its boxes at once, and triangles are tested four at a time. Counts are the same on every machine.
//!
//! Before anything is counted, all forms must find the same hits for all rays, to the last bit. With --rounds, forms take turns tracing every set on one
//! thread, and the last columns say how many times as many rays a second each traces as the binary tree: the quotient of the medians.
//! --set changes `max-leaf`, `node-cost` or `group-cost`, by which collapses are decided.

use bvhc::cache::View;
use bvhc::simd::{Runs, Widest};
use bvhc::trace::probe::{Camera, ProbeRays, SETS};
use bvhc::trace::wide::{Collapse, CompactTrees, WideRecord, WideTrees, WideView};
use bvhc::trace::{Counters, Hit, Malformed, any_hit, closest_hit, try_any_hit, try_closest_hit};
use bvhc::{Cache, Ray};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut rays, mut rounds, mut files, mut collapse) = (1 << 14, 0, Vec::new(), Collapse::default());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg}: a value goes with it"));
        match arg.as_str() {
            "--rays" => rays = value()?.parse()?,
            "--rounds" => rounds = value()?.parse()?,
            "--set" => match value()?.split_once('=') {
                Some(("max-leaf", v)) => collapse.max_leaf = v.parse()?,
                Some(("node-cost", v)) => collapse.node_cost = v.parse()?,
                Some(("group-cost", v)) => collapse.group_cost = v.parse()?,
                _ => return Err("--set takes max-leaf=N, node-cost=X or group-cost=X".into()),
            },
            _ => files.push(arg),
        }
    }
    for file in &files {
        let cache = Cache::open(file)?;
        let view = cache.view();
        let probe = ProbeRays::new(&view, &Camera::automatic(&view), rays);
        let [pulled_4, planned_4] = [WideTrees::<4>::greedy(&view)?, WideTrees::new(&view, &collapse)?];
        let [pulled_8, planned_8] = [WideTrees::<8>::greedy(&view)?, WideTrees::new(&view, &collapse)?];
        let compact = CompactTrees::new(&planned_8);
        let forms = [
            Form::binary(&view),
            Form::wide("4 lanes, pulled up", pulled_4.view(&view)),
            Form::wide("4 lanes, least cost", planned_4.view(&view)),
            Form::wide("8 lanes, pulled up", pulled_8.view(&view)),
            Form::wide("8 lanes, least cost", planned_8.view(&view)),
            Form::wide("8 lanes, compact", compact.view(&view)),
        ];
        let equal = (1..forms.len()).find_map(|i| differs(&probe, &forms[0], &forms[i]).map(|ray| (i, ray)));
        if let Some((form, ray)) = equal {
            return Err(format!("{file}: {} has another hit than the binary tree for {ray:?}", forms[form].name).into());
        }
        println!("{file}: {} triangles\n", cache.header().prim_count);
        print(&forms, &probe, cache.header().prim_count as f64, rounds)?;
        println!();
    }
    Ok(())
}

type Answer = Result<Option<Hit>, Malformed>;
/// A question to a form about one ray, which counts the work.
type Ask<'a, A> = Box<dyn Fn(&Ray, &mut Counters) -> A + 'a>;
/// How many rays hit something, all of them traced at once, so that nothing but tracing is timed. Any hit if the flag is set.
type Count<'a> = Box<dyn Fn(&[Ray], bool) -> usize + 'a>;

/// A form of a scene's trees.
struct Form<'a> {
    name: &'a str,
    bytes: usize,
    closest: Ask<'a, Answer>,
    any: Ask<'a, Result<bool, Malformed>>,
    count_hits: Count<'a>,
}

impl<'a> Form<'a> {
    fn binary(view: &'a View<'a>) -> Form<'a> {
        Form {
            name: "binary",
            bytes: size_of_val(view.nodes),
            closest: Box::new(|ray, counters| try_closest_hit(view, ray, counters)),
            any: Box::new(|ray, counters| try_any_hit(view, ray, counters)),
            count_hits: Box::new(|rays, any| match any {
                true => rays.iter().filter(|ray| any_hit(view, ray) == Ok(true)).count(),
                false => rays.iter().filter(|ray| matches!(closest_hit(view, ray), Ok(Some(_)))).count(),
            }),
        }
    }

    fn wide<const N: usize, T: WideRecord<N>>(name: &'a str, wide: WideView<'a, N, T>) -> Form<'a>
    where
        Widest: Runs<N>,
    {
        Form {
            name,
            bytes: size_of_val(wide.nodes) + if wide.blocks.is_empty() { size_of_val(wide.order) } else { 0 },
            closest: Box::new(move |ray, counters| wide.try_closest_hit(ray, counters)),
            any: Box::new(move |ray, counters| wide.try_any_hit(ray, counters)),
            count_hits: Box::new(move |rays, any| match any {
                true => rays.iter().filter(|ray| wide.any_hit(ray) == Ok(true)).count(),
                false => rays.iter().filter(|ray| matches!(wide.closest_hit(ray), Ok(Some(_)))).count(),
            }),
        }
    }
}

/// The first ray that two forms answer differently. Which of several records of one triangle is named does not count.
fn differs(probe: &ProbeRays, a: &Form<'_>, b: &Form<'_>) -> Option<Ray> {
    let mut counters = Counters::default();
    let bits =
        |answer: Answer| answer.map(|hit| hit.map(|h| ([h.t, h.u, h.v].map(f32::to_bits), h.geom, h.prim, h.instance)));
    let mut closest = |form: &Form<'_>, ray: &Ray| bits((form.closest)(ray, &mut counters));
    let mut all = (0..2).flat_map(|set| probe.rays(set));
    let other = all.find(|ray| closest(a, ray) != closest(b, ray));
    other
        .or_else(|| probe.rays(2).iter().find(|ray| (a.any)(ray, &mut counters) != (b.any)(ray, &mut counters)))
        .copied()
}

fn print(forms: &[Form<'_>], probe: &ProbeRays, triangles: f64, rounds: usize) -> Result<(), Box<dyn Error>> {
    let heads: String = SETS.iter().map(|set| format!(" {set} nodes | triangles |")).collect();
    let timed: String =
        if rounds > 0 { SETS.iter().map(|set| format!(" {set} speed |")).collect() } else { String::new() };
    println!("| form | node bytes a triangle |{heads}{timed}");
    println!("|---|--:|{}", "--:|".repeat(6 + if rounds > 0 { 3 } else { 0 }));
    let speeds = speeds(forms, probe, rounds);
    for (form, speeds) in forms.iter().zip(speeds) {
        let mut row = format!("| {} | {:.1} |", form.name, form.bytes as f64 / triangles);
        for set in 0..SETS.len() {
            let mut counters = Counters::default();
            let rays = probe.rays(set);
            for ray in rays {
                if set == 2 {
                    (form.any)(ray, &mut counters)?;
                } else {
                    (form.closest)(ray, &mut counters)?;
                }
            }
            let each = |n: u64| n as f64 / rays.len().max(1) as f64;
            row.push_str(&format!(" {:.2} | {:.2} |", each(counters.inner_nodes), each(counters.triangles)));
        }
        speeds.iter().for_each(|speed| row.push_str(&format!(" {speed:.2} |")));
        println!("{row}");
    }
    Ok(())
}

/// How many times as many rays a second as the first form, by form and set.
fn speeds(forms: &[Form<'_>], probe: &ProbeRays, rounds: usize) -> Vec<Vec<f64>> {
    let mut seconds = vec![vec![Vec::new(); SETS.len()]; forms.len()];
    for _ in 0..rounds {
        for set in 0..SETS.len() {
            for (form, seconds) in forms.iter().zip(&mut seconds) {
                let start = Instant::now();
                std::hint::black_box((form.count_hits)(probe.rays(set), set == 2));
                seconds[set].push(start.elapsed().as_secs_f64());
            }
        }
    }
    if rounds == 0 {
        return vec![Vec::new(); forms.len()];
    }
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let medians: Vec<Vec<f64>> = seconds.iter_mut().map(|sets| sets.iter_mut().map(median).collect()).collect();
    medians.iter().map(|sets| sets.iter().zip(&medians[0]).map(|(own, first)| first / own).collect()).collect()
}
