//! How far the searches `auto` and `best` stay from the cheapest recipe, by counts that carry no noise:
//! `cargo run --release --example margins -- [--jobs N] [--rays N] [--notes] [SCENE or FILE]…`
//!
//! For each scene every recipe of the peers' bench is built once and asked with so many rays a set from the bench's camera. The searches
//! decide by other rays from four cameras; where the bench has no camera of its own for a scene, its is one of the four. A ray costs
//! 1.2·(inner nodes) + triangles, the mean of the three sets. `over` is how much more it costs than in the cheapest tree of all recipes.
//! All rays of one camera start in one point, and what leaf a tree happens to have there is paid by each of them; so `64 eyes` says the
//! same of as many rays from 64 cameras, sixteen strewn about each of the four.
//! The thresholds of `auto` were set from the scenes marked `chosen on`; its recipes and their order were laid out knowing all of them and the
//! samples, so that none is a blind test. Without scenes: those of the bench that are there, and the samples.

#[path = "../benches/peers/recipes.rs"]
mod recipes;
#[path = "../benches/peers/scenes.rs"]
mod scenes;

use bvhc::build::{BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::decide_tree;
use bvhc::random::Random;
use bvhc::scene::Mesh;
use bvhc::search::Choice;
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

    println!(
        "| scene | triangles | overlap | cheapest recipe | cost | `auto` took | over | 64 eyes | `best` took | over | 64 eyes |"
    );
    println!("|---|--:|--:|---|--:|---|--:|--:|---|--:|--:|");
    let mut worst = [[[0.0f64; 2]; 2]; 2];
    for scene in &list {
        let judged = Judged::of(scene, rays, &exec)?;
        let chosen_on = CHOSEN_ON.contains(&scene.name.as_str());
        for (worst, search) in worst[usize::from(chosen_on)].iter_mut().zip(&judged.searches) {
            worst.iter_mut().zip(search.over).for_each(|(worst, over)| *worst = worst.max(over));
        }
        println!("{}", judged.row(&scene.name, chosen_on));
        if notes {
            for search in &judged.searches {
                bvhc::search::notes(std::slice::from_ref(&search.choice)).iter().for_each(|note| eprintln!("{note}"));
            }
        }
    }
    println!();
    for (i, method) in ["auto", "best"].into_iter().enumerate() {
        let [here, elsewhere] = [1, 0].map(|chosen_on| worst[chosen_on][i].map(|x| format!("{:.1} %", x * 100.0)));
        println!(
            "Worst of `{method}`: {} on the scenes that the thresholds were chosen on and {} on the others; by 64 eyes {} and {}.",
            here[0], elsewhere[0], here[1], elsewhere[1]
        );
    }
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
    /// Cost beyond the cheapest recipe's, as a share of it: by the bench's rays, and by those of 64 eyes.
    over: [f64; 2],
}

impl Judged {
    fn of(scene: &scenes::Scene, rays: usize, exec: &Executor) -> Result<Judged, String> {
        let mesh = scene.load()?;
        let build = |options: &BuildOptions| decide_tree(&mesh, options, exec, &NoProgress).map_err(|e| e.to_string());
        let draft = build(&BuildOptions::preset(Preset::Draft))?.0;
        let sets = probe(scene, &image_of(&mesh, &draft, exec)?, rays);

        let (mut cheapest, mut least) = (String::new(), [f64::INFINITY; 2]);
        let mut searches = Vec::new();
        for recipe in recipes::recipes(&[], &[])? {
            let (tree, choice) = build(&recipe.options)?;
            let image = image_of(&mesh, &tree, exec)?;
            let cost = sets.each_ref().map(|rays| rays.cost(&image.view(), exec).mean());
            if let Some(choice) = choice {
                searches.push(Searched { choice, over: cost });
                continue;
            }
            if cost[0] < least[0] {
                cheapest = recipe.name;
            }
            least = [least[0].min(cost[0]), least[1].min(cost[1])];
        }
        searches.iter_mut().for_each(|s| s.over = [s.over[0] / least[0] - 1.0, s.over[1] / least[1] - 1.0]);
        Ok(Judged { triangles: mesh.triangles.len(), cheapest: (cheapest, least[0]), searches })
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
            let [over, by_eyes] = search.over.map(|over| over * 100.0);
            row.push_str(&format!(" {} | {over:+.1} % | {by_eyes:+.1} % |", search.choice.recipe()));
        }
        row
    }
}

fn image_of(mesh: &Mesh, tree: &Tree, exec: &Executor) -> Result<Image, String> {
    Image::of_tree(mesh, tree, exec).map_err(|e| e.to_string())
}

/// The rays of the peers' bench, and as many of 64 eyes.
fn probe(scene: &scenes::Scene, image: &Image, count: usize) -> [ProbeRays; 2] {
    let view = image.view();
    let bounds = image.nodes.first().map_or(([0.0; 3], [1.0; 3]), |n| (n.min.map(f64::from), n.max.map(f64::from)));
    let camera = scene.camera(bounds.0, bounds.1).unwrap_or_else(|| Camera::automatic(&view));
    [ProbeRays::new(&view, &camera, count), ProbeRays::around(&view, &strewn(Camera::around(&view)), count)]
}

/// Sixteen cameras about each of four: eye and aim are moved by up to 15 % of what all eyes and aims spread over, on each axis.
fn strewn(around: [Camera; 4]) -> Vec<Camera> {
    let mut random = Random::new(64);
    let spread = [0, 1, 2].map(|k| {
        let places = around.iter().flat_map(|c| [c.eye[k], c.look_at[k]]);
        places.clone().fold(f64::NEG_INFINITY, f64::max) - places.fold(f64::INFINITY, f64::min)
    });
    let mut moved = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] + 0.3 * (random.unit() - 0.5) * spread[k]);
    let each = around.into_iter().flat_map(|c| [c; 16]);
    each.map(|c| Camera { eye: moved(c.eye), look_at: moved(c.look_at), ..c }).collect()
}
