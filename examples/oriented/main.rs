//! What boxes that need not lie along the axes do, on scenes that are made to be hard for boxes that do: `cargo run --release --example oriented
//! -- [TRIANGLES] [MODEL…]`.
//!
//! Counts and areas alone, so the tables are the same on every machine.
//!
//! 1. The method `oabb`: the surface of each cluster's box over that of a box fitted around the same triangles, the mean over clusters of so many
//!    triangles; and how many common boxes were measured for each triangle.
//! 2. The trees along the axes that come of it: 1.2 · inner nodes + triangle tests a ray, the mean of three sets of rays, over that of `sweep`.
//! 3. The tree of `sweep` in bounds of several kinds: their surface over that of its boxes, and that times the operations of a test.
//! 4. Trees of `best` whose subtrees lie along bases of their own where counted rays say that it pays: what other rays pay over what they pay
//!    along the axes, with any rotation and with one of a small set; a ray that is turned pays for that. Models that are named are in this
//!    table and the next alone.
//! 5. What closest-hit rays pay in the files that `build --orient` writes of these trees, over what they pay along the axes, turns weighed as before;
//!    the turned subtrees, the file's bytes over those without them, and answers that differ from those along the axes.

mod growth;
mod kinds;
mod saving;

use bvhc::build::{BuildOptions, Executor, HullBasis, Levels, Method, NoProgress, Preset};
use bvhc::compile::{build_tree, lay_out};
use bvhc::geom::Aabb;
use bvhc::oriented::{Basis, Dop14, OrientedBox, discrete};
use bvhc::scene::{self, Mesh};
use bvhc::stability::{Effort, Failure, Judge, recipes};
use growth::growth;
use kinds::bounded;
use saving::{InFile, saving};
use std::error::Error;

const SCENES: [&str; 6] = ["curtain", "pillar", "roof", "scaffold", "hairball", "city"];
const RECIPES: [&str; 5] = ["agglomerative", "oabb along leaves", "oabb", "sbvh", "sweep"];
const RAYS: usize = 1300;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let count = args.next().map_or(Ok(4000), |text| text.parse())?;
    let exec = Executor::new(0)?;
    let scenes: Vec<&Failure> = SCENES.iter().filter_map(|name| Failure::named(name)).collect();

    println!("| scene | triangles | basis | 2–8 | 9–64 | 65–512 | more | all | measured |");
    println!("|---|--:|---|--:|--:|--:|--:|--:|--:|");
    for failure in &scenes {
        let mesh = failure.scene(count).meshes.remove(0);
        for basis in [HullBasis::Leaf, HullBasis::Fit] {
            let found = growth(&mesh, basis, &exec);
            let means = found.means.map(|mean| mean.map_or("–".to_string(), |mean| format!("{mean:.2}")));
            let (triangles, means) = (mesh.triangles.len(), means.join(" | "));
            let (root, measured) = (found.root, found.measured);
            println!("| {} | {triangles} | `{basis}` | {means} | {root:.2} | {measured:.1} |", failure.name);
        }
    }

    println!("\n| scene | {} |\n|---|{}", RECIPES.join(" | "), "--:|".repeat(RECIPES.len()));
    for failure in &scenes {
        let scene = failure.scene(count);
        let effort = Effort { sizes: [count; 2], rays: RAYS, judged_rays: 1, rounds: 0 };
        let mut judge = Judge::new(&scene, &effort, &exec);
        let recipes = recipes();
        let named = |name: &&str| recipes.iter().find(|recipe| recipe.name == *name);
        let rows: Result<Vec<_>, _> = RECIPES.iter().filter_map(named).map(|recipe| judge.row(recipe)).collect();
        let costs: Vec<f64> = rows?.iter().map(|row| row.cost).collect();
        let sweep = costs.last().copied().unwrap_or(1.0);
        let cells: Vec<String> = costs.iter().map(|cost| format!("{:.2}", cost / sweep)).collect();
        println!("| {} | {} |", failure.name, cells.join(" | "));
    }

    println!("\n| scene | 14-DOP, surface | cost | oriented box, surface | cost |\n|---|--:|--:|--:|--:|");
    for failure in &scenes {
        let mesh = failure.scene(count).meshes.remove(0);
        let options = BuildOptions { method: Method::Sweep, ..BuildOptions::preset(Preset::Best) };
        let tree = build_tree(&mesh, &options, &exec, &NoProgress)?;
        let along_axes = bounded::<Aabb>(&mesh, &tree);
        let kinds = [bounded::<Dop14>(&mesh, &tree), bounded::<OrientedBox>(&mesh, &tree)];
        let cells = kinds.map(|k| format!("{:.2} | {:.2}", k.area / along_axes.area, k.cost / along_axes.cost));
        println!("| {} | {} |", failure.name, cells.join(" | "));
    }

    let set = discrete();
    println!(
        "\n| scene | triangles | cost along axes | any rotation | changes | of {} rotations | changes | lost |\n|---|--:|--:|--:|--:|--:|--:|--:|",
        set.len()
    );
    let mut files = Vec::new();
    for failure in &scenes {
        files.push(print_turned(failure.name, &failure.scene(count).meshes[0], &set, &exec)?);
    }
    for path in args.map(std::path::PathBuf::from) {
        let options = BuildOptions { levels: Levels::One, ..BuildOptions::default() };
        let scene = scene::read(&path, &scene::ReadOptions::default())?;
        let laid_out = lay_out(scene, &options, &exec)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        files.push(print_turned(&name, &laid_out.meshes[0], &set, &exec)?);
    }
    println!("\n| scene | paid | turns | bytes | differ |\n|---|--:|--:|--:|--:|");
    files.iter().for_each(|row| println!("{row}"));
    Ok(())
}

/// A row of the last table but one; returns that of the last.
fn print_turned(name: &str, mesh: &Mesh, set: &[Basis], exec: &Executor) -> Result<String, Box<dyn Error>> {
    let found = saving(mesh, set, exec)?;
    let [free, among] = found.turned.map(|turned| format!("{:.2} | {}", turned.over, turned.changes));
    println!("| {name} | {} | {:.1} | {free} | {among} | {} |", mesh.triangles.len(), found.cost, found.lost);
    let InFile { paid, turns, bytes, differ } = found.file;
    Ok(format!("| {name} | {paid:.2} | {turns} | {bytes:.2} | {differ} |"))
}
