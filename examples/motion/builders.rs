//! What rays cost where a builder's trees are rebuilt in every frame, and where that of the first frame is refitted: table 2 of M. Molenaar and C. Freda,
//! "Bounding Volume Hierarchies" (Utrecht University, 2018), with counts where they measured a graphics card.
//!
//! Their builders bin: 16 bins on the longest axis alone or on all three, and 8 with spatial splits, an alpha of 0.01 and a node's cost of 1.5. Ours run with the
//! same values. `ours` is what `bvhc build` makes of a sequence: trees for the whole animation, refitted, and built anew where the rule says so.
//!
//! A cell is the ray cost (1.2 · inner nodes + triangles), the mean over the frames and the worst of them; with `--each` there is a row a frame.

use crate::clip::Clip;
use crate::{Result, fresh};
use bvhc::build::motion::{self, Cost, Motion, Rebuild, RefitPolicy, Step, Trees, Verdict};
use bvhc::build::{Axes, BuildOptions, Executor, Method, NoProgress, Preset};
use bvhc::tree::Tree;

/// The columns, in their order.
const WAYS: [&str; 6] =
    ["longest axis, rebuilt", "three axes, rebuilt", "three axes, refitted", "SBVH, rebuilt", "SBVH, refitted", "ours"];

/// The first lines of the table.
pub fn heading() {
    println!("| clip | triangles | frames | {} |", WAYS.join(" | "));
    println!("|---|--:|--:|{}", "--:|".repeat(WAYS.len()));
}

/// Print the rows of a clip.
pub fn measure(clip: &Clip, rays: usize, each: bool, exec: &Executor) -> Result<()> {
    let binned = BuildOptions { method: Method::Binned, bins: 16, ..BuildOptions::preset(Preset::Draft) };
    let longest = BuildOptions { axes: Axes::Longest, ..binned.clone() };
    let sbvh = BuildOptions {
        method: Method::Sbvh,
        bins: 8,
        spatial_bins: 8,
        split_alpha: 0.01,
        traversal_cost: 1.5,
        ..BuildOptions::preset(Preset::Balanced)
    };
    let [longest, three, sbvh] = [longest, binned, sbvh].map(|options| clip.trees(&options, exec));
    let (longest, three, sbvh) = (longest?, three?, sbvh?);
    let (trees, serves) = ours(clip, exec)?;
    let costs: Vec<[f64; 6]> = (0..clip.meshes.len())
        .map(|frame| {
            let probes = clip.rays(frame, &three[frame], rays, exec);
            let ways = [&longest[frame], &three[frame], &three[0], &sbvh[frame], &sbvh[0], &trees[serves[frame]]];
            // A tree with parts of triangles is judged as it was built: refitted, its leaves hold whole ones.
            std::array::from_fn(|way| match WAYS[way].ends_with("rebuilt") {
                true => clip.ray_cost_as_built(frame, ways[way], &probes, exec),
                false => clip.ray_cost(frame, ways[way], &probes, exec),
            })
        })
        .collect();
    let row = |frames: &str, cell: &dyn Fn(usize) -> String| {
        let cells: Vec<String> = (0..WAYS.len()).map(cell).collect();
        println!("| {} | {} | {frames} | {} |", clip.name, clip.triangles(), cells.join(" | "));
    };
    if each {
        for (frame, costs) in costs.iter().enumerate() {
            row(&format!("frame {frame}"), &|way| format!("{:.2}", costs[way]));
        }
    } else {
        let mean = |way: usize| costs.iter().map(|costs| costs[way]).sum::<f64>() / costs.len() as f64;
        let worst = |way: usize| costs.iter().map(|costs| costs[way]).fold(0.0, f64::max);
        row(&costs.len().to_string(), &|way| format!("{:.1} · {:.1}", mean(way), worst(way)));
    }
    Ok(())
}

/// The trees of a sequence, and which of them serves each frame.
fn ours(clip: &Clip, exec: &Executor) -> Result<(Vec<Tree>, Vec<usize>)> {
    let options = fresh(8);
    let motion = clip.motion()?;
    let surveyed = motion::keyed(&motion, Trees::Auto, &options, exec, &NoProgress)?;
    let mut trees = surveyed.trees;
    let cost = |tree: &Tree, frame: usize| cost_of(tree, &motion, frame, &options);
    let least = (0..trees.len()).map(|tree| {
        let served = (0..motion.frames()).filter(|frame| surveyed.serves[*frame] == tree);
        served.map(|frame| cost(&trees[tree], frame)).reduce(Cost::min).unwrap_or_default()
    });
    let mut rule = Rebuild::with(RefitPolicy::default(), least);
    let mut kept: Vec<usize> = (0..trees.len()).collect();
    let mut serves = Vec::new();
    for frame in 0..motion.frames() {
        let place = match rule.step(|place| cost(&trees[kept[place]], frame)) {
            Step::Refit(place, _) => place,
            Step::Build => {
                let tree = bvhc::compile::build_tree(&clip.meshes[frame], &options, exec, &NoProgress)?;
                match rule.built(cost(&tree, frame)) {
                    Verdict::Futile(place, _) => place,
                    Verdict::Key => {
                        kept = vec![trees.len()];
                        trees.push(tree);
                        0
                    }
                    Verdict::Kept(gone) => {
                        if let Some(place) = gone {
                            kept.remove(place);
                        }
                        kept.push(trees.len());
                        trees.push(tree);
                        kept.len() - 1
                    }
                }
            }
        };
        serves.push(kept[place]);
    }
    Ok((trees, serves))
}

fn cost_of(tree: &Tree, motion: &Motion, frame: usize, options: &BuildOptions) -> Cost {
    Cost::new(motion::cost(tree, motion, frame, options), motion::triangle_cost(motion, frame, options))
}
