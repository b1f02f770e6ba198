//! When a tree that is refitted from frame to frame is built anew, where frames come one after another and nobody knows the next.
//!
//! The tree's cost in a frame is compared with what it was where the tree was built (as Lauterbach, Yoon, Tuft and Manocha, "RT-DEFORM", 2006, compare a
//! tree with its own start). Two things keep builds from being wasted. Trees of earlier frames are kept and taken again where they are good, so
//! that a cyclic motion is built for once. And a build that brought little, because the frame itself is dear, is thrown away and not tried
//! again before the refitted tree has become dearer still, each time by more.

use super::policy::{Refit, RefitPolicy};

/// Most trees that are kept. The one that has not served for longest goes first.
const KEPT: usize = 8;
/// A new tree must be so much cheaper than the refitted one, or that stays: what a mesh costs in a frame is not always the refit's fault.
const WORTHWHILE: f64 = 0.97;
/// Where building was in vain, the refitted tree is borne until it costs so many times more, and from time to time the square of that.
const PATIENCE: f64 = 1.05;
/// The exponent of that doubles at most so often, which comes to about five times as much.
const MOST_DOUBLINGS: u32 = 5;
/// A cost that rises by this from one frame to the next ends all patience: it is another thing that happens now.
const JUMP: f64 = 1.5;
/// Another kept tree takes over if it is cheaper by this, so that two that are about as good do not take turns.
const LEAD: f64 = 0.99;

/// What a tree costs in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// The SAH, over the area of the root.
    pub sah: f64,
    /// The SAH over what the frame's [triangles alone](super::triangle_cost) cost.
    pub excess: f64,
}

impl Cost {
    /// Of a tree that was refitted to a frame in which the triangles alone cost `unit`. Where that is nothing, frames are compared by the SAH alone.
    pub fn new(sah: f64, unit: f64) -> Cost {
        Cost { sah, excess: if unit > 0.0 { sah / unit } else { sah } }
    }

    /// The smaller of each.
    pub fn min(self, other: Cost) -> Cost {
        Cost { sah: self.sah.min(other.sah), excess: self.excess.min(other.excess) }
    }

    /// How many times another cost it is, by the measure that says more. The SAH alone takes a smaller root for a worse tree, and what is over the triangles'
    /// cost takes triangles that grew for a better one. What is suspected wrongly is built once and found futile.
    pub fn ratio(self, to: Cost) -> f64 {
        let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 1.0 };
        let (sah, excess) = (ratio(self.sah, to.sah), ratio(self.excess, to.excess));
        // Unlike `max`, what is no number stays none.
        if sah > excess || sah.is_nan() { sah } else { excess }
    }
}

/// What to do in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Refit the tree that stands at this place among the kept ones. Its cost is so many times that in the frames that it was made for.
    Refit(usize, f64),
    /// Build a new one, and tell [`Rebuild::built`] what it costs.
    Build,
}

/// What becomes of a tree that was built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// It serves the frame and stands last among the kept ones. Where one had to go for it, that stood at this place before.
    Kept(Option<usize>),
    /// It serves the frame, and all others go: nothing after it needs what was before.
    Key,
    /// It is hardly better than a refitted one: throw it away, and refit as if [`Step::Refit`] had said so.
    Futile(usize, f64),
}

/// A tree that may serve other frames than the one that it was built for.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// Its cost where it was built; of a tree for many frames the least in those.
    base: Cost,
    /// The frame in which it served last.
    last: u64,
    /// The largest cost, relative to its base, up to which building anew is not worth it.
    borne: f64,
    /// How often that was found.
    futile: u32,
}

impl Kept {
    fn new(base: Cost, last: u64) -> Kept {
        Kept { base, last, borne: 0.0, futile: 0 }
    }
}

/// The trees of a mesh from frame to frame, by their places and costs alone. Whoever has the trees does what it says.
#[derive(Clone, Debug)]
pub struct Rebuild {
    policy: RefitPolicy,
    kept: Vec<Kept>,
    /// The place of the one that served last.
    current: usize,
    frame: u64,
    /// The frame in which all trees were built anew last.
    key: u64,
    /// The SAH of the last frame.
    paid: f64,
    /// The kept tree that is best in this frame, and what it costs.
    best: Option<(usize, Cost)>,
}

impl Rebuild {
    /// Before the first frame, without a tree.
    pub fn new(policy: RefitPolicy) -> Rebuild {
        Rebuild::with(policy, [])
    }

    /// Before the first frame, with trees that were made for the whole animation: for each the least of its costs in the frames that it was made for.
    pub fn with(policy: RefitPolicy, trees: impl IntoIterator<Item = Cost>) -> Rebuild {
        let kept = trees.into_iter().map(|base| Kept::new(base, 0)).collect();
        Rebuild { policy, kept, current: 0, frame: 0, key: 1, paid: f64::INFINITY, best: None }
    }

    /// How many trees are kept: places are below that.
    pub fn kept(&self) -> usize {
        self.kept.len()
    }

    /// The next frame. `cost` says what the kept tree at a place costs there, refitted, and is asked for each at most once.
    pub fn step(&mut self, cost: impl FnMut(usize) -> Cost) -> Step {
        self.frame += 1;
        self.best = None;
        if self.policy.refit == Refit::Never || self.is_key() {
            return Step::Build;
        }
        let costs: Vec<Cost> = (0..self.kept.len()).map(cost).collect();
        let cheapest = (0..costs.len()).min_by(|a, b| costs[*a].sah.total_cmp(&costs[*b].sah));
        let Some(cheapest) = cheapest else { return Step::Build };
        let current = self.current.min(costs.len() - 1);
        let stays = costs[current].sah * LEAD <= costs[cheapest].sah && !self.is_dear(current, costs[current]);
        let place = if stays { current } else { cheapest };
        self.best = Some((place, costs[place]));
        if self.is_dear(place, costs[place]) { Step::Build } else { self.serve(place, costs[place]) }
    }

    /// The new tree of this frame costs so much there.
    pub fn built(&mut self, cost: Cost) -> Verdict {
        if self.is_key() {
            self.kept = vec![Kept::new(cost, self.frame)];
            (self.current, self.paid, self.key) = (0, cost.sah, self.frame);
            return Verdict::Key;
        }
        if let Some((place, refitted)) = self.best.take().filter(|(_, refitted)| cost.sah >= refitted.sah * WORTHWHILE)
        {
            let ratio = refitted.ratio(self.kept[place].base);
            let kept = &mut self.kept[place];
            kept.borne = ratio * PATIENCE.powi(1 << kept.futile);
            kept.futile = (kept.futile + 1).min(MOST_DOUBLINGS);
            self.serve(place, refitted);
            return Verdict::Futile(place, ratio);
        }
        let oldest = (0..self.kept.len()).reduce(|a, b| if self.kept[b].last < self.kept[a].last { b } else { a });
        // What is never refitted serves its own frame alone.
        let most = if self.policy.refit == Refit::Never { 1 } else { KEPT };
        let gone = oldest.filter(|_| self.kept.len() >= most);
        if let Some(place) = gone {
            self.kept.remove(place);
        }
        self.kept.push(Kept::new(cost, self.frame));
        (self.current, self.paid) = (self.kept.len() - 1, cost.sah);
        Verdict::Kept(gone)
    }

    /// Whether this frame is due to be built, whatever it costs.
    fn is_key(&self) -> bool {
        self.policy.keyframe_every.is_some_and(|every| self.frame.saturating_sub(self.key) >= u64::from(every.get()))
    }

    /// Whether a tree costs so much that it is due to be built anew.
    fn is_dear(&self, place: usize, cost: Cost) -> bool {
        let Kept { base, borne, .. } = self.kept[place];
        let ratio = cost.ratio(base);
        // What is no number is dear.
        let is_above = |limit: f64| !(ratio <= limit);
        let jumps = cost.sah > JUMP * self.paid;
        self.policy.refit == Refit::Auto && is_above(f64::from(self.policy.rebuild_ratio)) && (is_above(borne) || jumps)
    }

    fn serve(&mut self, place: usize, cost: Cost) -> Step {
        (self.current, self.paid) = (place, cost.sah);
        self.kept[place].last = self.frame;
        Step::Refit(place, cost.ratio(self.kept[place].base))
    }
}

/// What a policy makes of an animation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schedule {
    /// By frame, the frame whose tree serves it. What serves itself was built there.
    pub serves: Vec<usize>,
    /// Trees that were built, those that were thrown away included.
    pub builds: usize,
}

/// What a policy makes of frames whose costs can be asked.
///
/// `cost(key, frame)` is what the tree of frame `key` costs refitted to `frame`. It is asked for frames in order, and for keys that come before.
pub fn schedule(frames: usize, policy: RefitPolicy, mut cost: impl FnMut(usize, usize) -> Cost) -> Schedule {
    let mut state = Rebuild::new(policy);
    // By place, the frame in which the tree was built.
    let mut keys: Vec<usize> = Vec::new();
    let mut schedule = Schedule::default();
    for frame in 0..frames {
        let place = match state.step(|place| cost(keys[place], frame)) {
            Step::Refit(place, _) => place,
            Step::Build => {
                schedule.builds += 1;
                match state.built(cost(frame, frame)) {
                    Verdict::Futile(place, _) => place,
                    Verdict::Key => {
                        keys = vec![frame];
                        0
                    }
                    Verdict::Kept(gone) => {
                        if let Some(place) = gone {
                            keys.remove(place);
                        }
                        keys.push(frame);
                        keys.len() - 1
                    }
                }
            }
        };
        schedule.serves.push(keys[place]);
    }
    schedule
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ratio: f32) -> RefitPolicy {
        RefitPolicy { rebuild_ratio: ratio, ..RefitPolicy::default() }
    }

    /// In frames whose triangles cost alike.
    fn plan(frames: usize, policy: RefitPolicy, mut sah: impl FnMut(usize, usize) -> f64) -> Schedule {
        schedule(frames, policy, |key, frame| Cost::new(sah(key, frame), 1.0))
    }

    /// How much the tree of a key costs more than a new one, on average over the frames.
    fn mean(plan: &Schedule, sah: impl Fn(usize, usize) -> f64) -> f64 {
        let over = |(frame, key): (usize, &usize)| sah(*key, frame) / sah(frame, frame);
        plan.serves.iter().enumerate().map(over).sum::<f64>() / plan.serves.len() as f64
    }

    #[test]
    fn what_stands_still_is_built_once() {
        assert_eq!(plan(100, at(1.0), |_, _| 20.0), Schedule { serves: vec![0; 100], builds: 1 });
        assert_eq!(plan(3, at(1.2), |_, _| 0.0).serves, [0; 3]);
        assert_eq!(plan(0, at(1.2), |_, _| 1.0), Schedule::default());
    }

    #[test]
    fn the_mode_decides_before_the_ratio_does() {
        let sah = |key: usize, frame: usize| 20.0 * (1.0 + (frame - key) as f64);
        let policy = |refit| RefitPolicy { refit, ..RefitPolicy::default() };
        assert_eq!(plan(30, policy(Refit::Never), sah).serves, (0..30).collect::<Vec<usize>>());
        assert_eq!(plan(30, policy(Refit::Always), sah), Schedule { serves: vec![0; 30], builds: 1 });
        assert_eq!(plan(30, policy(Refit::Never), |_, _| 20.0).builds, 30, "nothing is compared");
    }

    #[test]
    fn after_so_many_frames_a_tree_is_built_and_none_from_before_serves_again() {
        let policy = |refit| RefitPolicy { refit, keyframe_every: std::num::NonZeroU32::new(4), ..at(1.2) };
        let keys = [0, 0, 0, 0, 4, 4, 4, 4, 8, 8];
        assert_eq!(plan(10, policy(Refit::Always), |_, _| 20.0).serves, keys);
        assert_eq!(plan(10, policy(Refit::Auto), |_, _| 20.0), Schedule { serves: keys.to_vec(), builds: 3 });
        // What comes back is built for once in each stretch.
        let shot = |frame: usize| frame % 2;
        let sah = |key: usize, frame: usize| if shot(key) == shot(frame) { 20.0 } else { 400.0 };
        assert_eq!(plan(8, policy(Refit::Auto), sah).serves, [0, 1, 0, 1, 4, 5, 4, 5]);
    }

    #[test]
    fn the_ratio_is_kept_by_either_measure_and_what_is_no_number_is_dear() {
        for (costs, want) in [
            ([(1.2, 1.0), (1.0, 1.0)], 1),
            ([(1.2001, 1.0), (1.0, 1.0)], 2),
            ([(0.5, 1.2001), (0.4, 1.0)], 2),
            ([(f64::NAN, 1.0), (1.0, 1.0)], 2),
        ] {
            let [refitted, fresh] = costs.map(|(sah, excess)| Cost { sah, excess });
            let plan = schedule(2, at(1.2), |key, frame| match (key, frame) {
                (0, 0) => Cost { sah: 1.0, excess: 1.0 },
                (0, _) => refitted,
                _ => fresh,
            });
            assert_eq!(plan.builds, want, "{refitted:?}");
        }
    }

    #[test]
    fn a_walk_is_built_for_in_its_first_cycle_alone() {
        let period = 24;
        let phase = |frame: usize| (frame % period) as f64 / period as f64;
        let sah = |key: usize, frame: usize| {
            let apart = (phase(key) - phase(frame)).abs();
            20.0 * (1.0 + apart.min(1.0 - apart))
        };
        let all = plan(40 * period, at(1.1), sah);
        let first = plan(period, at(1.1), sah);
        assert!((2..=8).contains(&first.builds), "{} builds", first.builds);
        assert_eq!(all.builds, first.builds, "later cycles take the trees of the first");
        assert!(mean(&all, sah) <= 1.1);
        // A cycle is played like the one before.
        assert_eq!(all.serves[20 * period..21 * period], all.serves[21 * period..22 * period]);
    }

    #[test]
    fn what_explodes_is_not_built_over_and_over() {
        // A new tree costs as much as an old one: every frame is dearer than the one before.
        let sah = |_: usize, frame: usize| 20.0 * 1.2f64.powi(frame as i32);
        let exploding = plan(60, at(1.2), sah);
        assert!(exploding.builds <= 12 && exploding.serves == [0; 60], "{} builds", exploding.builds);

        // Dearer by a jump that a build does not mend, and then still.
        assert_eq!(plan(200, at(1.2), |_, frame| if frame < 10 { 20.0 } else { 60.0 }).builds, 2);

        // A cut is seen at once, whatever was borne before.
        let shot = |frame: usize| usize::from(frame >= 27);
        let sah = |key: usize, frame: usize| match shot(key) == shot(frame) {
            true => 20.0 * if frame < 20 { 1.2f64.powi(frame as i32) } else { 38.0 },
            false => 9000.0,
        };
        assert_eq!(plan(40, at(1.2), sah).serves[26..29], [0, 27, 27]);
    }

    #[test]
    fn what_is_shuffled_is_built_in_every_frame_and_what_comes_back_is_taken_again() {
        // Each frame's triangles stand where another's stood: no tree serves another frame.
        assert_eq!(plan(50, at(1.2), |key, frame| if key == frame { 20.0 } else { 400.0 }).builds, 50);

        // Two shots that alternate.
        let shot = |frame: usize| frame / 5 % 2;
        let sah = |key: usize, frame: usize| if shot(key) == shot(frame) { 20.0 } else { 400.0 };
        let alternating = plan(200, at(1.2), sah);
        assert_eq!((alternating.builds, mean(&alternating, sah)), (2, 1.0));
    }

    #[test]
    fn slow_decay_is_mended_at_the_ratio() {
        let sah = |key: usize, frame: usize| 20.0 * (1.0 + 0.0101 * (frame - key) as f64);
        let decaying = plan(200, at(1.1), sah);
        // After ten frames a tree is more than a tenth dearer.
        assert_eq!(decaying.builds, 20);
        assert!(mean(&decaying, sah) < 1.06);
    }

    #[test]
    fn two_trees_that_are_about_as_good_do_not_take_turns() {
        let mut state = Rebuild::with(at(1.2), [20.0, 20.0].map(|sah| Cost::new(sah, 1.0)));
        let mut step = |a: f64, b: f64| match state.step(|place| Cost::new([a, b][place], 1.0)) {
            Step::Refit(place, _) => place,
            Step::Build => unreachable!("neither is dear"),
        };
        assert_eq!(step(21.0, 20.0), 1);
        for frame in 0..20 {
            assert_eq!(step(if frame % 2 == 0 { 19.9 } else { 20.1 }, 20.0), 1);
        }
        assert_eq!(step(20.0, 21.0), 0);
    }

    #[test]
    fn the_tree_that_has_not_served_for_longest_goes() {
        let mut state = Rebuild::new(at(1.2));
        let cost = |sah| Cost::new(sah, 1.0);
        for place in 0..KEPT {
            assert_eq!(state.step(|_| cost(90.0)), Step::Build);
            assert_eq!(state.built(cost(10.0)), Verdict::Kept(None), "{place}");
        }
        assert_eq!(state.step(|place| cost(if place == 0 { 10.0 } else { 90.0 })), Step::Refit(0, 1.0));
        assert_eq!(state.step(|_| cost(90.0)), Step::Build);
        assert_eq!((state.built(cost(10.0)), state.kept()), (Verdict::Kept(Some(1)), KEPT));
    }
}
