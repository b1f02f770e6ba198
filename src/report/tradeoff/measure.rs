//! Trees built in rounds, and rays traced in them.

use super::chart::mark_front;
use super::peer::{Pipe, Worker};
use super::times::{Times, indistinct};
use super::{LeftOut, Origin, Reason, Recipe, Row, TradeOff};
use crate::build::{BuildError, BuildOptions, Levels, Preset, Progress};
use crate::cache::{CacheError, Image, View};
use crate::compile::{LaidOut, compile_laid_out, lay_out};
use crate::exec::Executor;
use crate::report::file::FileReport;
use crate::report::overlap::{EpoMode, EpoReport};
use crate::report::rays::RayReport;
use crate::scene::Scene;
use crate::search::NAMED_RECIPE;
use crate::trace::probe::{Camera, ProbeRays, SETS};
use crate::tree::Accel;
use std::time::{Duration, Instant};

/// How thoroughly.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Rays in each of three sets, about.
    pub rays: usize,
    /// How often each recipe is built at most.
    pub rounds: u32,
    /// When to stop. The first recipe is finished in any case.
    pub until: Instant,
}

/// Who watches, and may interrupt.
pub trait Watch: Sync {
    /// Asked often; what is measured then stays.
    fn is_cancelled(&self) -> bool;
    /// The build of a recipe begins, in this round, counted from 1; `done` of `of` builds are finished.
    fn step(&self, recipe: &str, round: u32, done: u64, of: u64);
}

/// The recipes of one scene, while they are measured: [`first_round`](Contest::first_round), then [`more_rounds`](Contest::more_rounds), then
/// [`finish`](Contest::finish).
pub struct Contest<'a> {
    scene: &'a Scene,
    effort: Effort,
    exec: &'a Executor,
    watch: &'a dyn Watch,
    /// The quickest first, as far as that is known before.
    recipes: Vec<Recipe>,
    /// The scene as its trees index it, for each layout that some recipe asks for.
    laid: Vec<(Levels, LaidOut)>,
    measured: Vec<Measured>,
    left_out: Vec<LeftOut>,
    /// The trees of the default recipe, or else those that were built first.
    kept: Option<(String, Image)>,
    /// What searches ended with, by their names.
    choices: Vec<(String, BuildOptions)>,
    /// Builders of others, at work on the scene as one mesh.
    peers: Vec<Pipe>,
}

struct Measured {
    recipe: Recipe,
    /// The peer that builds it, and the number of its setting.
    peer: Option<(usize, u8)>,
    rounds: Vec<f64>,
    row: Row,
}

impl<'a> Contest<'a> {
    /// Of recipes in any order, whose names differ.
    pub fn new(
        scene: &'a Scene,
        recipes: &[Recipe],
        effort: Effort,
        exec: &'a Executor,
        watch: &'a dyn Watch,
    ) -> Contest<'a> {
        let mut recipes = recipes.to_vec();
        recipes.sort_by(|a, b| a.weight().total_cmp(&b.weight()));
        let (laid, measured, left_out, kept, choices) = (Vec::new(), Vec::new(), Vec::new(), None, Vec::new());
        let peers = Vec::new();
        Contest { scene, effort, exec, watch, recipes, laid, measured, left_out, kept, choices, peers }
    }

    /// Build each recipe once and trace rays in its trees, the quickest first, for as long as there is time. A recipe that a search ends with joins
    /// the others, as what a user says for options is made by `spell`.
    ///
    /// # Errors
    /// Where trees cannot be laid out as records, which is a fault of the builder.
    pub fn first_round(&mut self, spell: &dyn Fn(&BuildOptions) -> String) -> Result<(), CacheError> {
        let mut next = 0;
        while let Some(recipe) = self.recipes.get(next).cloned() {
            self.watch.step(&recipe.name, 1, next as u64, self.recipes.len() as u64);
            next += 1;
            // Something is measured in any case.
            let deadline = (!self.measured.is_empty()).then_some(self.effort.until);
            match self.build(&recipe.options, deadline) {
                Ok((seconds, accel)) => {
                    let choice = chosen(&accel.notes);
                    self.judge(recipe.clone(), seconds, accel)?;
                    if let Some(options) = choice {
                        self.choose(&recipe, options, spell);
                    }
                }
                Err(error) => self.leave_out(recipe, &error),
            }
        }
        Ok(())
    }

    /// Let other builders build the scene once, baked into one mesh, as points beside the recipes. One that fails is left out with the reason.
    pub fn peers(&mut self, workers: &[Worker]) {
        let options = BuildOptions { levels: Levels::One, ..BuildOptions::preset(Preset::Draft) };
        let baked = |_: &Worker| lay_out(self.scene.clone(), &options, self.exec).ok()?.meshes.into_iter().next();
        let Some(mesh) = workers.first().and_then(baked) else { return };
        for worker in workers {
            let recipe = |setting: &str| Recipe {
                name: format!("{} {setting}", worker.name),
                origin: Origin::Peer,
                flags: String::new(),
                options: options.clone(),
            };
            let pipe = Pipe::open(worker, self.exec.threads(), &mesh, &self.goes_on());
            let mut pipe = match pipe {
                Ok(pipe) => pipe,
                Err(error) => {
                    self.fail(recipe("worker"), error.to_string());
                    continue;
                }
            };
            for (number, setting) in worker.settings.iter().enumerate() {
                let (recipe, number) = (recipe(setting), number as u8);
                if !self.goes_on()() {
                    self.leave_out(recipe, &BuildError::Cancelled);
                    continue;
                }
                self.watch.step(&recipe.name, 1, self.measured.len() as u64, self.recipes.len() as u64);
                let built =
                    pipe.build(number, &self.goes_on()).map_err(|e| e.to_string()).and_then(|(milliseconds, tree)| {
                        let image = Image::of_tree(&mesh, &tree, self.exec).map_err(|e| e.to_string())?;
                        Ok((milliseconds, image))
                    });
                match built {
                    Ok((milliseconds, image)) => {
                        let peer = Some((self.peers.len(), number));
                        self.judge_image(recipe, peer, 1e-3 * milliseconds, Vec::new(), &image);
                    }
                    Err(why) => self.fail(recipe, why),
                }
            }
            self.peers.push(pipe);
        }
    }

    /// The trees of the default recipe, or else those of the quickest, with the recipe's name; nothing before the first round.
    pub fn kept(&self) -> Option<(&str, &Image)> {
        self.kept.as_ref().map(|(name, image)| (name.as_str(), image))
    }

    /// Give up the trees that are [kept](Contest::kept).
    pub fn release(&mut self) {
        self.kept = None;
    }

    /// Build what was built again and again, for as long as there is time and there are rounds to do. Each round begins with another recipe. A recipe that would take
    /// longer than is left is passed over.
    pub fn more_rounds(&mut self) {
        let count = self.measured.len();
        let of = u64::from(self.effort.rounds) * count as u64;
        let mut done = count as u64;
        for round in 1..self.effort.rounds {
            let before = done;
            for turn in 0..count {
                let which = (round as usize + turn) % count;
                let Measured { recipe, rounds, peer, .. } = &self.measured[which];
                let peer = *peer;
                let (which_recipe, name, options) = (recipe.clone(), recipe.name.clone(), recipe.options.clone());
                let expected = rounds.iter().copied().fold(f64::INFINITY, f64::min);
                let left = self.effort.until.saturating_duration_since(Instant::now()).as_secs_f64();
                if self.watch.is_cancelled() || expected > left {
                    continue;
                }
                self.watch.step(&name, round + 1, done, of);
                let seconds = match peer {
                    Some((peer, setting)) => self.build_again(peer, setting, &which_recipe),
                    None => self.build(&options, Some(self.effort.until)).ok().map(|(seconds, _)| seconds),
                };
                if let Some(seconds) = seconds {
                    self.measured[which].rounds.push(seconds);
                    done += 1;
                }
            }
            if done == before {
                return;
            }
        }
    }

    /// The seconds that a peer takes for one more build; nothing where it fails, which is told once.
    fn build_again(&mut self, peer: usize, setting: u8, recipe: &Recipe) -> Option<f64> {
        let goes_on = self.goes_on();
        match self.peers[peer].build(setting, &goes_on) {
            Ok((milliseconds, _)) => Some(1e-3 * milliseconds),
            Err(error) => {
                if !self.left_out.iter().any(|left| left.name == recipe.name) && goes_on() {
                    self.fail(recipe.clone(), error.to_string());
                }
                None
            }
        }
    }

    /// Whether there is time left, and nobody interrupted.
    fn goes_on(&self) -> impl Fn() -> bool + Sync + use<'a> {
        let (watch, until) = (self.watch, self.effort.until);
        move || !watch.is_cancelled() && Instant::now() < until
    }

    /// What was measured.
    pub fn finish(self) -> TradeOff {
        let chosen_by = |recipe: &Recipe| {
            self.choices
                .iter()
                .filter(|(_, options)| recipe.origin != Origin::Peer && recipe.builds_as(options))
                .map(|(search, _)| search.clone())
                .collect()
        };
        let with_times = |m: Measured| Row { build: Times::of(&m.rounds), chosen_by: chosen_by(&m.recipe), ..m.row };
        let mut recipes: Vec<Row> = self.measured.into_iter().map(with_times).collect();
        mark_front(&mut recipes);
        let times: Vec<Times> = recipes.iter().map(|row| row.build).collect();
        let names = |group: Vec<usize>| group.into_iter().map(|i| recipes[i].name.clone()).collect();
        let indistinct = indistinct(&times).into_iter().map(names).collect();
        TradeOff { recipes, left_out: self.left_out, indistinct }
    }

    /// The trees, and the seconds that they took, layout excepted.
    fn build(&mut self, options: &BuildOptions, deadline: Option<Instant>) -> Result<(f64, Accel), BuildError> {
        let ear = Ear { watch: self.watch, deadline };
        if ear.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let laid = match self.laid.iter().find(|(levels, _)| *levels == options.levels) {
            Some((_, laid)) => laid.clone(),
            None => {
                let laid = lay_out(self.scene.clone(), options, self.exec)?;
                self.laid.push((options.levels, laid.clone()));
                laid
            }
        };
        let start = Instant::now();
        let accel = compile_laid_out(laid, options, self.exec, &ear)?;
        Ok((start.elapsed().as_secs_f64(), accel))
    }

    fn judge(&mut self, recipe: Recipe, seconds: f64, mut accel: Accel) -> Result<(), CacheError> {
        let notes = std::mem::take(&mut accel.notes);
        let image = Image::of_compiled(accel, self.exec)?;
        self.judge_image(recipe.clone(), None, seconds, notes, &image);
        if self.kept.is_none() || recipe.builds_as(&BuildOptions::default()) {
            self.kept = Some((recipe.name, image));
        }
        Ok(())
    }

    /// `peer` is the place of a worker and its setting, where it built the trees.
    fn judge_image(
        &mut self,
        recipe: Recipe,
        peer: Option<(usize, u8)>,
        seconds: f64,
        notes: Vec<String>,
        image: &Image,
    ) {
        let view = image.view();
        let file = FileReport::of_view(String::new(), 0, &view);
        let goes_on = || !self.watch.is_cancelled();
        let rays = RayReport::of_view_while(&view, self.effort.rays, self.exec, &goes_on);
        let trace_seconds = traced(&view, self.effort.rays, &goes_on);
        let row = Row {
            name: recipe.name.clone(),
            origin: recipe.origin,
            flags: recipe.flags.clone(),
            chosen_by: Vec::new(),
            front: false,
            build: Times::default(),
            rays,
            nodes: file.blas.nodes,
            references: file.blas.references,
            depth: file.blas.max_depth,
            sah: file.blas.sah,
            epo: EpoReport::of_view(&view, EpoMode::Points(EPO_POINTS), self.exec).value,
            trace_seconds,
            notes,
        };
        // What was cut short is no figure.
        if self.watch.is_cancelled() {
            return self.leave_out(recipe, &BuildError::Cancelled);
        }
        self.measured.push(Measured { recipe, peer, rounds: vec![seconds], row });
    }

    /// A worker that was killed for want of time, or by the signal that interrupts this program as well, has not failed.
    fn fail(&mut self, recipe: Recipe, why: String) {
        let goes_on = self.goes_on();
        let asked = Instant::now();
        while goes_on() && asked.elapsed() < SIGNALLED {
            std::thread::sleep(SIGNALLED / 10);
        }
        if goes_on() {
            let Recipe { name, origin, flags, .. } = recipe;
            self.left_out.push(LeftOut { name, origin, flags, reason: Reason::Failed(why) });
        } else {
            self.leave_out(recipe, &BuildError::Cancelled);
        }
    }

    /// Mark what a search ended with, where it is a recipe of the list; else put it there.
    fn choose(&mut self, search: &Recipe, options: BuildOptions, spell: &dyn Fn(&BuildOptions) -> String) {
        let options = BuildOptions { levels: search.options.levels, ..options };
        let is_there =
            self.recipes.iter().chain(self.measured.iter().map(|m| &m.recipe)).any(|r| r.builds_as(&options));
        self.choices.push((search.name.clone(), options.clone()));
        if is_there {
            return;
        }
        let name = format!("{}'s choice", search.name);
        let (origin, flags) = (Origin::Choice, spell(&options));
        let recipe = Recipe { name, origin, flags, options };
        let deadline = Some(self.effort.until);
        self.watch.step(&recipe.name, 1, self.measured.len() as u64, self.recipes.len() as u64 + 1);
        match self.build(&recipe.options, deadline) {
            // A fault of records would have shown in the trees of the search.
            Ok((seconds, accel)) => _ = self.judge(recipe, seconds, accel),
            Err(error) => self.leave_out(recipe, &error),
        }
    }

    fn leave_out(&mut self, recipe: Recipe, error: &BuildError) {
        let reason = match error {
            BuildError::Cancelled if self.watch.is_cancelled() => Reason::Interrupted,
            BuildError::Cancelled => Reason::Budget,
            other => Reason::Failed(other.to_string()),
        };
        let Recipe { name, origin, flags, .. } = recipe;
        self.left_out.push(LeftOut { name, origin, flags, reason });
    }
}

/// How long a signal to this program may come after its workers have died of it.
const SIGNALLED: Duration = Duration::from_millis(100);
/// Points at which the end-point overlap is asked, and how often rays are timed: a small part of what the quickest build takes.
const EPO_POINTS: u32 = 4096;
const TRACED: u32 = 3;

/// The least time of a few that about so many rays in each set take on this thread.
fn traced(view: &View<'_>, rays: usize, goes_on: &dyn Fn() -> bool) -> f64 {
    let probe = ProbeRays::around_while(view, &Camera::around(view), rays, goes_on);
    let once = |_| {
        let start = Instant::now();
        let sets = (0..SETS.len()).take_while(|_| goes_on());
        sets.for_each(|set| _ = std::hint::black_box(probe.trace(set, view)));
        start.elapsed().as_secs_f64()
    };
    (0..TRACED).take_while(|_| goes_on()).map(once).fold(f64::INFINITY, f64::min)
}

/// The recipe that a search ended with, from what it wrote down; nothing where it chose for several trees.
pub(super) fn chosen(notes: &[String]) -> Option<BuildOptions> {
    let mut named = notes.iter().filter_map(|note| note.split_once(NAMED_RECIPE));
    let (search, recipe) = named.next()?;
    if named.next().is_some() || search.contains(", tree ") {
        return None;
    }
    let mut pairs = recipe.split(' ').map(|pair| pair.split_once('=')).collect::<Option<Vec<_>>>()?.into_iter();
    let (_, method) = pairs.next().filter(|(name, _)| *name == "method")?;
    let options: Vec<(String, String)> = pairs.map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
    BuildOptions::recorded(method, &options).ok()
}

/// What a build listens to.
struct Ear<'a> {
    watch: &'a dyn Watch,
    deadline: Option<Instant>,
}

impl Progress for Ear<'_> {
    fn is_cancelled(&self) -> bool {
        self.watch.is_cancelled() || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}
