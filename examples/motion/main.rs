//! Trees for animations beside a new tree in every frame:
//! `cargo run --release --example motion -- [--builders|--splits] [--each] [--frames N] [--rays N] [--jobs N] MODEL[:ANIMATION]…`
//!
//! MODEL is a glTF file, and ANIMATION the number of one of its animations, 0 if it is left out; or a folder of OBJ files that are frames. Of a glTF
//! animation N frames are taken (24), evenly from its first key to its last. Everything is one mesh in world space.
//!
//! A row is a model and a way to have a tree in each frame. SAH and ray cost are relative to `rebuild`, which builds `sweep` with 8 rounds of reinsertion in
//! every frame: the mean over the frames and the worst of them. Ray cost is the mean over three sets of about N rays (4096): from 16 cameras all
//! around, one diffuse bounce, and ambient occlusion; 0 traces none. `time` is what processors took to make the trees, where the system tells (Linux);
//! with one job nothing else is counted. `best frame` knows all frames' trees, and its time is not stated, nor is that of `first frame`. `refit to R` is
//! what `bvhc build --trees first --rebuild-ratio R` does: its trees are counted with those that were built in vain.
//!
//! `--builders` prints another table: what a ray costs in the trees of several builders, rebuilt in every frame or refitted to it (`builders.rs`). `--splits` prints a third:
//! what spatial splits leave once their trees hold whole triangles (`splits.rs`).

mod builders;
mod clip;
mod splits;

use bvhc::build::motion::{self, Cost, RefitPolicy, Trees};
use bvhc::build::{BuildOptions, Executor, Method, NoProgress, Preset};
use bvhc::tree::{Tree, refit};
use clip::Clip;
use std::error::Error;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

enum Table {
    Ways,
    Builders,
    Splits,
}

fn main() -> Result<()> {
    let (mut frames, mut rays, mut jobs, mut models) = (24, 4096, 1, Vec::new());
    let (mut table, mut each) = (Table::Ways, false);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut number = || args.next().and_then(|n| n.parse().ok()).ok_or("a number after the option");
        match arg.as_str() {
            "--frames" => frames = number()?,
            "--rays" => rays = number()?,
            "--jobs" => jobs = number()?,
            "--builders" => table = Table::Builders,
            "--splits" => table = Table::Splits,
            "--each" => each = true,
            _ => models.push(arg),
        }
    }
    let exec = Executor::new(jobs)?;
    match table {
        Table::Builders => builders::heading(),
        Table::Splits => splits::heading(),
        Table::Ways => {
            println!("| clip | triangles | frames | way | trees | SAH mean | worst | rays mean | worst | time |");
            println!("|---|--:|--:|---|--:|--:|--:|--:|--:|--:|");
        }
    }
    for model in &models {
        let clip = clip::read(model, frames)?;
        match table {
            Table::Builders => builders::measure(&clip, rays, each, &exec)?,
            Table::Splits => splits::measure(&clip, rays, &exec)?,
            Table::Ways => measure(&clip, rays, &exec)?,
        }
    }
    Ok(())
}

/// What a renderer would build anew in every frame if time did not matter.
fn fresh(reinsert: u32) -> BuildOptions {
    BuildOptions { method: Method::Sweep, reinsert, ..BuildOptions::preset(Preset::Auto) }
}

/// One way to have a tree in every frame.
struct Way {
    name: &'static str,
    trees: Vec<Tree>,
    serves: Vec<usize>,
    /// Trees that were built.
    builds: usize,
    /// Milliseconds that it took to make the trees.
    cpu: f64,
}

fn measure(clip: &Clip, rays: usize, exec: &Executor) -> Result<()> {
    let motion = clip.motion()?;
    let frames = motion.frames();
    let options = fresh(8);
    let timed = |name, work: &dyn Fn() -> Result<(Vec<Tree>, Vec<usize>)>| -> Result<Way> {
        let start = cpu_ms();
        let (trees, serves) = work()?;
        Ok(Way { name, builds: trees.len(), trees, serves, cpu: cpu_ms() - start })
    };
    let keyed = |trees| -> Result<(Vec<Tree>, Vec<usize>)> {
        let keyed = motion::keyed(&motion, trees, &options, exec, &NoProgress)?;
        Ok((keyed.trees, keyed.serves))
    };
    let mut ways = vec![
        timed("rebuild", &|| Ok((clip.trees(&options, exec)?, (0..frames).collect())))?,
        timed("rebuild, plain sweep", &|| Ok((clip.trees(&fresh(0), exec)?, (0..frames).collect())))?,
        timed("all frames", &|| keyed(Trees::AtMost(1)))?,
        timed("at most three", &|| keyed(Trees::AtMost(3)))?,
        timed("auto", &|| keyed(Trees::Auto))?,
    ];
    let fresh = ways[0].trees.clone();
    let all = motion::costs(&fresh, &motion, &options, exec);
    let own: Vec<f64> = (0..frames).map(|f| all[f][f]).collect();
    let mean = |t: usize| (0..frames).map(|f| all[f][t] / own[f]).sum::<f64>();
    let best = (0..frames).reduce(|a, b| if mean(b) < mean(a) { b } else { a }).unwrap_or(0);
    let units: Vec<f64> = (0..frames).map(|frame| motion::triangle_cost(&motion, frame, &options)).collect();
    for (name, rebuild_ratio) in [
        ("refit to 1.05", 1.05),
        ("refit to 1.1", 1.1),
        ("refit to 1.2", 1.2),
        ("refit to 1.3", 1.3),
        ("refit to 1.4", 1.4),
    ] {
        let policy = RefitPolicy { rebuild_ratio, ..RefitPolicy::default() };
        let plan = motion::schedule(frames, policy, |key, frame| Cost::new(all[frame][key], units[frame]));
        let built: Vec<usize> = (0..frames).filter(|frame| plan.serves[*frame] == *frame).collect();
        let serves = plan.serves.iter().map(|key| built.partition_point(|b| b < key)).collect();
        let trees = built.iter().map(|frame| fresh[*frame].clone()).collect::<Vec<Tree>>();
        let cpu = ways[0].cpu * plan.builds as f64 / frames as f64;
        ways.push(Way { name, trees, serves, builds: plan.builds, cpu });
    }
    for (name, frame) in [("first frame", 0), ("best frame", best)] {
        let trees = vec![fresh[frame].clone()];
        ways.push(Way { name, trees, serves: vec![0; frames], builds: 1, cpu: 0.0 });
    }
    let costs: Vec<Vec<[f64; 2]>> = (0..frames)
        .map(|frame| {
            let probes = (rays > 0).then(|| clip.rays(frame, &ways[0].trees[frame], rays, exec));
            let cost = |way: &Way| {
                let tree = &way.trees[way.serves[frame]];
                let mut nodes = tree.nodes.clone();
                refit(&mut nodes, |slot| motion.corners(frame, tree.refs[slot] as usize))
                    .expect("a tree that was built");
                let sah = f64::from(bvhc::tree::quality::sah(&nodes));
                let ray = probes.as_ref().map_or(0.0, |probes| clip.ray_cost(frame, tree, probes, exec));
                [sah, ray]
            };
            ways.iter().map(cost).collect()
        })
        .collect();
    for (w, way) in ways.iter().enumerate() {
        let over = |measure: usize| {
            let ratios = costs.iter().map(|row| row[w][measure] / row[0][measure]);
            let worst = ratios.clone().fold(0.0, f64::max);
            (ratios.sum::<f64>() / frames as f64, worst)
        };
        let ((sah, sah_worst), (ray, ray_worst)) = (over(0), over(1));
        println!(
            "| {} | {} | {frames} | {} | {} | {sah:.3} | {sah_worst:.3} | {ray:.3} | {ray_worst:.3} | {:.2} |",
            clip.name,
            clip.triangles(),
            way.name,
            way.builds,
            way.cpu / ways[0].cpu
        );
    }
    Ok(())
}

/// Milliseconds that processors have spent on this process so far, where the system tells.
fn cpu_ms() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    stat.split(' ').next().and_then(|n| n.parse::<f64>().ok()).unwrap_or(0.0) / 1e6
}
