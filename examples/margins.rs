//! How far the searches `auto` and `best` stay from the cheapest recipe, by counts that carry no noise:
//! `cargo run --release --example margins -- [--jobs N] [--rays N] [--notes] [SCENE or FILE]…`
//!
//! For each scene every recipe of the peers' bench is built once and asked with so many rays a set from the bench's camera. The searches
//! decide by other rays from four cameras; where the bench has no camera of its own for a scene, its is one of the four. A ray costs
//! 1.2·(inner nodes) + triangles, the mean of the three sets. `over` is how much more it costs than in the cheapest tree of all recipes.
//! The thresholds of `auto` were set from the scenes marked `chosen on`; its recipes and their order were laid out knowing all scenes of the
//! bench but ldraw_cafe_corner, so that the others of them are no blind test, while it and the samples are. Without scenes: those of the bench
//! that are there, and the samples.

#[path = "../benches/peers/recipes.rs"]
mod recipes;
#[path = "../benches/peers/scenes.rs"]
mod scenes;

use bvhc::build::{BuildOptions, Choice, Executor, NoProgress, Preset, decide_tree};
use bvhc::cache::Image;
use bvhc::scene::Mesh;
use bvhc::trace::probe::{Camera, ProbeRays};
use bvhc::tree::Tree;

/// The thresholds of `auto` were set from these.
const CHOSEN_ON: [&str; 5] = ["sponza_dabrovic", "obvhs_kitchen", "bunny", "bitterli_kitchen", "macross_city"];

fn main() -> Result<(), String> {
    let (mut jobs, mut rays, mut notes, mut wanted) = (0, 1 << 16, false, Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut number = || args.next().and_then(|v| v.parse().ok()).ok_or(format!("{arg}: a number goes with it"));
        match arg.as_str() {
            "--jobs" => jobs = number()?,
            "--rays" => rays = number()?,
            "--notes" => notes = true,
            _ => wanted.push(arg),
        }
    }
    let mut list = scenes::scenes(&wanted)?;
    if wanted.is_empty() {
        let samples = ["colonnade", "corrugated_roof", "curtain", "stadium"].map(String::from);
        let more = samples.into_iter().filter(|name| list.iter().all(|scene| scene.name != *name));
        list.extend(scenes::scenes(&more.collect::<Vec<_>>())?);
    }
    let exec = Executor::new(jobs).map_err(|e| e.to_string())?;

    println!("| scene | triangles | overlap | cheapest recipe | cost | `auto` took | over | `best` took | over |");
    println!("|---|--:|--:|---|--:|---|--:|---|--:|");
    let mut worst = [[0.0f64; 2]; 2];
    for scene in &list {
        let judged = Judged::of(scene, rays, &exec)?;
        let chosen_on = CHOSEN_ON.contains(&scene.name.as_str());
        for (worst, search) in worst[usize::from(chosen_on)].iter_mut().zip(&judged.searches) {
            *worst = worst.max(search.over);
        }
        println!("{}", judged.row(&scene.name, chosen_on));
        if notes {
            for search in &judged.searches {
                bvhc::build::notes(std::slice::from_ref(&search.choice)).iter().for_each(|note| eprintln!("{note}"));
            }
        }
    }
    let percent = |x: f64| format!("{:.1} %", x * 100.0);
    println!();
    println!(
        "Worst of `auto`: {} on the scenes that its thresholds were chosen on, {} on the others; of `best`: {} and {}.",
        percent(worst[1][0]),
        percent(worst[0][0]),
        percent(worst[1][1]),
        percent(worst[0][1])
    );
    Ok(())
}

struct Judged {
    triangles: usize,
    cheapest: (String, f64),
    /// `auto` and `best`.
    searches: Vec<Searched>,
}

struct Searched {
    choice: Choice,
    /// Cost beyond the cheapest recipe's, as a share of it.
    over: f64,
}

impl Judged {
    fn of(scene: &scenes::Scene, rays: usize, exec: &Executor) -> Result<Judged, String> {
        let mesh = scene.load()?;
        let build = |options: &BuildOptions| decide_tree(&mesh, options, exec, &NoProgress).map_err(|e| e.to_string());
        let cost_by = |rays: &ProbeRays, tree: &Tree| rays.cost(&Image::of_tree(&mesh, tree).view(), exec).mean();
        let rays = probe(scene, &mesh, &build(&BuildOptions::preset(Preset::Draft))?.0, rays);

        let mut cheapest = (String::new(), f64::INFINITY);
        let mut searches = Vec::new();
        for recipe in recipes::recipes(&[], &[])? {
            let (tree, choice) = build(&recipe.options)?;
            let cost = cost_by(&rays, &tree);
            match choice {
                Some(choice) => searches.push(Searched { choice, over: cost }),
                None if cost < cheapest.1 => cheapest = (recipe.name, cost),
                None => {}
            }
        }
        searches.iter_mut().for_each(|s| s.over = s.over / cheapest.1 - 1.0);
        Ok(Judged { triangles: mesh.triangles.len(), cheapest, searches })
    }

    fn row(&self, name: &str, chosen_on: bool) -> String {
        let overlap = self.searches.iter().find_map(|s| s.choice.overlap);
        let mut row = format!(
            "| {name}{} | {} | {} | {} | {:.2} |",
            if chosen_on { " (chosen on)" } else { "" },
            self.triangles,
            overlap.map_or_else(|| "-".to_string(), |share| format!("{:.1} %", share * 100.0)),
            self.cheapest.0,
            self.cheapest.1,
        );
        for search in &self.searches {
            row.push_str(&format!(" {} | {:+.1} % |", search.choice.recipe(), search.over * 100.0));
        }
        row
    }
}

/// The rays of the peers' bench.
fn probe(scene: &scenes::Scene, mesh: &Mesh, tree: &Tree, count: usize) -> ProbeRays {
    let image = Image::of_tree(mesh, tree);
    let bounds = image.nodes.first().map_or(([0.0; 3], [1.0; 3]), |n| (n.min.map(f64::from), n.max.map(f64::from)));
    let camera = scene.camera(bounds.0, bounds.1).unwrap_or_else(|| Camera::automatic(&image.view()));
    ProbeRays::new(&image.view(), &camera, count)
}
