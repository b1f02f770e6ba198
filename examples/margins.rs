//! How far the searches `auto` and `best` stay from the best recipe for each family of rays, by counts that carry no noise:
//! `cargo run --release --example margins -- [--jobs N] [--rays N] [--recipes A,B] [--recipe NAME=FLAGS]… [--families] [--notes] [SCENE or FILE]…`
//!
//! For each scene every recipe of the peers' bench is built once and asked with so many rays of each family (`trace::probe::Family`). They have
//! other seeds than those that the searches judge by and those that trees are adapted to, so that no ray is asked twice. A ray costs
//! 1.2·(inner nodes) + triangles. The *regret* of a family is how much more its rays cost than in the best of all trees for it, the searches'
//! own among them. No tree is the best for every family; `least` is the least worst regret that any recipe has, and who has it.
//! `--families` prints what each family pays in every tree. Without scenes: those of the bench that are there, and the samples.
//!
//! The thresholds of `auto` were set from the scenes marked `chosen on`; its recipes and their order were laid out knowing all of them and the
//! samples, so that none is a blind test.

#[path = "../benches/peers/recipes.rs"]
mod recipes;
#[path = "../benches/peers/scenes.rs"]
#[expect(dead_code, reason = "rays of families need no camera of the bench")]
mod scenes;

use bvhc::build::{BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::decide_tree;
use bvhc::scene::Mesh;
use bvhc::search::Choice;
use bvhc::trace::probe::{FAMILIES, Family, FamilyRays};
use bvhc::tree::Tree;
use bvhc::tree::quality::sah;

/// The thresholds of `auto` were set from these.
const CHOSEN_ON: [&str; 5] = ["sponza_dabrovic", "obvhs_kitchen", "bunny", "bitterli_kitchen", "macross_city"];

/// The seed of the rays that trees are judged by here.
const SEED: u64 = 64;

struct Options {
    jobs: usize,
    rays: usize,
    recipes: Vec<String>,
    more: Vec<String>,
    families: bool,
    notes: bool,
    scenes: Vec<String>,
}

fn main() -> Result<(), String> {
    let options = options()?;
    let mut list = scenes::scenes(&options.scenes)?;
    if options.scenes.is_empty() {
        let samples = ["colonnade", "corrugated_roof", "curtain", "stadium"].map(String::from);
        let more = samples.into_iter().filter(|name| list.iter().all(|scene| scene.name != *name));
        list.extend(scenes::scenes(&more.collect::<Vec<_>>())?);
    }
    let exec = Executor::new(options.jobs).map_err(|e| e.to_string())?;
    let recipes = recipes::recipes(&options.recipes, &options.more)?;

    println!("| scene | triangles | least | by | `auto` took | worst | mean | `best` took | worst | mean |");
    println!("|---|--:|--:|---|---|--:|--:|---|--:|--:|");
    let mut worst = [[0.0f64; 2]; 2];
    for scene in &list {
        let judged = Judged::of(scene, &recipes, &options, &exec)?;
        let chosen_on = CHOSEN_ON.contains(&scene.name.as_str());
        for (i, tree) in judged.searches().enumerate() {
            let behind = judged.worst(tree).0 - judged.least().0;
            worst[usize::from(chosen_on)][i] = worst[usize::from(chosen_on)][i].max(behind);
        }
        println!("{}", judged.row(&scene.name, chosen_on));
        if options.families {
            eprint!("{}", judged.families(&scene.name));
        }
        if options.notes {
            let choices = judged.searches().filter_map(|tree| tree.choice.as_ref());
            choices
                .for_each(|c| bvhc::search::notes(std::slice::from_ref(c)).iter().for_each(|note| eprintln!("{note}")));
        }
    }
    println!();
    for (i, method) in ["auto", "best"].into_iter().enumerate() {
        let [here, elsewhere] = [1, 0].map(|chosen_on: usize| format!("{:.1} %", worst[chosen_on][i] * 100.0));
        println!(
            "Worst regret of `{method}` beyond the least of any recipe, at most: {here} on the scenes that the thresholds were chosen on, {elsewhere} on the others."
        );
    }
    Ok(())
}

fn options() -> Result<Options, String> {
    let (recipes, more, scenes) = (Vec::new(), Vec::new(), Vec::new());
    let mut options = Options { jobs: 0, rays: 1 << 14, recipes, more, families: false, notes: false, scenes };
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg}: a value goes with it"));
        let number = |text: String| text.parse().map_err(|_| format!("{arg} takes a number"));
        match arg.as_str() {
            "--jobs" => options.jobs = number(value()?)?,
            "--rays" => options.rays = number(value()?)?,
            "--recipes" => options.recipes = value()?.split(',').map(String::from).collect(),
            "--recipe" => options.more.push(value()?),
            "--families" => options.families = true,
            "--notes" => options.notes = true,
            _ => options.scenes.push(arg),
        }
    }
    Ok(options)
}

/// The trees of one scene.
struct Judged {
    triangles: usize,
    trees: Vec<Judge>,
}

struct Judge {
    name: String,
    sah: f64,
    references: f64,
    /// NaN where the family has no rays.
    families: [f64; FAMILIES],
    /// Of a search.
    choice: Option<Choice>,
}

impl Judged {
    fn of(
        scene: &scenes::Scene,
        recipes: &[recipes::Recipe],
        options: &Options,
        exec: &Executor,
    ) -> Result<Judged, String> {
        let mesh = scene.load()?;
        let build = |options: &BuildOptions| decide_tree(&mesh, options, exec, &NoProgress).map_err(|e| e.to_string());
        let draft = image_of(&mesh, &build(&BuildOptions::preset(Preset::Draft))?.0, exec)?;
        let rays = FamilyRays::new(&draft.view(), options.rays, SEED, exec);
        let mut trees = Vec::new();
        for recipe in recipes {
            let (tree, choice) = build(&recipe.options)?;
            let cost = rays.cost(&image_of(&mesh, &tree, exec)?.view(), exec);
            let families = Family::ALL.map(|family| cost.mean(family).unwrap_or(f64::NAN));
            let references = tree.refs.len() as f64 / mesh.triangles.len() as f64;
            trees.push(Judge { name: recipe.name.clone(), sah: sah(&tree.nodes).into(), references, families, choice });
        }
        Ok(Judged { triangles: mesh.triangles.len(), trees })
    }

    fn searches(&self) -> impl Iterator<Item = &Judge> {
        self.trees.iter().filter(|tree| tree.choice.is_some())
    }

    fn regrets(&self, tree: &Judge) -> Vec<(f64, Family)> {
        let best = |family: usize| self.trees.iter().map(|t| t.families[family]).fold(f64::INFINITY, f64::min);
        let all = Family::ALL.into_iter().filter(|family| tree.families[*family as usize].is_finite());
        all.map(|family| (tree.families[family as usize] / best(family as usize) - 1.0, family)).collect()
    }

    fn worst(&self, tree: &Judge) -> (f64, &'static str) {
        let worst = self.regrets(tree).into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        worst.map_or((0.0, "none"), |(regret, family)| (regret, family.name()))
    }

    fn mean(&self, tree: &Judge) -> f64 {
        let all = self.regrets(tree);
        all.iter().map(|(regret, _)| regret).sum::<f64>() / all.len() as f64
    }

    /// The least worst regret of the recipes that are no searches, and whose it is.
    fn least(&self) -> (f64, &str) {
        let plain = self.trees.iter().filter(|tree| tree.choice.is_none());
        let least = plain.map(|tree| (self.worst(tree).0, tree.name.as_str())).min_by(|a, b| a.0.total_cmp(&b.0));
        least.unwrap_or((0.0, "none"))
    }

    fn row(&self, name: &str, chosen_on: bool) -> String {
        let mark = if chosen_on { " (chosen on)" } else { "" };
        let (least, by) = self.least();
        let mut row = format!("| {name}{mark} | {} | {:.1} % | {by} |", self.triangles, least * 100.0);
        for tree in self.searches() {
            let ((worst, family), mean) = (self.worst(tree), self.mean(tree));
            let recipe = tree.choice.as_ref().map_or("nothing", Choice::recipe);
            row.push_str(&format!(" {recipe} | {:.1} % ({family}) | {:.1} % |", worst * 100.0, mean * 100.0));
        }
        row
    }

    /// A row for each tree: what a ray of each family pays.
    fn families(&self, name: &str) -> String {
        let names = Family::ALL.map(Family::name).join(" | ");
        let mut out =
            format!("\n| {name} | {names} | SAH | refs/tri | worst | mean |\n|---|{}\n", "--:|".repeat(FAMILIES + 4));
        for tree in &self.trees {
            let costs = tree.families.map(|cost| if cost.is_nan() { "–".to_string() } else { format!("{cost:.2}") });
            let (worst, mean) = (self.worst(tree).0 * 100.0, self.mean(tree) * 100.0);
            out.push_str(&format!(
                "| {} | {} | {:.2} | {:.3} | {worst:.1} % | {mean:.1} % |\n",
                tree.name,
                costs.join(" | "),
                tree.sah,
                tree.references
            ));
        }
        out
    }
}

fn image_of(mesh: &Mesh, tree: &Tree, exec: &Executor) -> Result<Image, String> {
    Image::of_tree(mesh, tree, exec).map_err(|e| e.to_string())
}
