//! When a tree that is fitted from frame to frame is worth building anew, where frames come one after another and nobody knows the next.
//!
//! The tree's cost in a frame is compared with what a new one is expected to cost: what the last new one cost in its own frame (as Lauterbach, Yoon, Tuft
//! and Manocha, "RT-DEFORM", 2006, compare a tree with its own start). Two things keep builds from being wasted. Trees of earlier frames are kept and
//! taken again where they are good, so a cyclic motion is built for once. And a build that brought little, because the frame itself is dear, is
//! followed by a pause that doubles from time to time.

/// A cost that rises by this from one frame to the next ends a pause: it is another thing that happens now.
const JUMP: f64 = 1.5;

/// When to build anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Policy {
    /// A tree is fitted as long as it costs at most so many times what a new one is expected to.
    pub ratio: f64,
    /// A build was worth it if it lowers the cost by this share. Another kept tree takes over if it does by half of that.
    pub gain: f64,
    /// Most trees that are kept. The one that has not served for longest goes first.
    pub kept: usize,
    /// Most frames of a pause.
    pub longest_pause: u32,
}

impl Default for Policy {
    fn default() -> Policy {
        Policy { ratio: 1.1, gain: 0.04, kept: 8, longest_pause: 64 }
    }
}

/// What to do in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Fit the tree that stands at this place among the kept ones.
    Refit(usize),
    /// Build a new one, and tell [`Rebuild::built`] what it costs.
    Build,
}

/// The state of a policy between two frames.
#[derive(Clone, Debug)]
pub struct Rebuild {
    policy: Policy,
    /// The kept trees by their numbers: trees are numbered as they are built.
    kept: Vec<usize>,
    /// By kept tree, the frame in which it served last.
    last: Vec<u64>,
    /// The place of the one that served last.
    current: usize,
    built: usize,
    frame: u64,
    /// What a new tree is expected to cost.
    expected: f64,
    /// What the best kept tree costs in this frame.
    cheapest: f64,
    /// What was paid in the last frame.
    paid: f64,
    /// Length of the next pause, and what is left of this one.
    pause: u32,
    left: u32,
}

impl Rebuild {
    /// Before the first frame.
    pub fn new(policy: Policy) -> Rebuild {
        Rebuild {
            policy,
            kept: Vec::new(),
            last: Vec::new(),
            current: 0,
            built: 0,
            frame: 0,
            expected: 0.0,
            cheapest: f64::INFINITY,
            paid: f64::INFINITY,
            pause: 1,
            left: 0,
        }
    }

    /// The kept trees by their numbers, counted from 0 in the order in which they were built.
    pub fn kept(&self) -> &[usize] {
        &self.kept
    }

    /// The next frame, in which the [kept](Rebuild::kept) trees cost so much, in a unit in which frames can be compared. What has no cost is NaN.
    pub fn step(&mut self, costs: &[f64]) -> Step {
        self.frame += 1;
        let places = 0..self.kept.len().min(costs.len());
        let Some(best) = places.filter(|&i| !costs[i].is_nan()).reduce(|a, b| if costs[b] < costs[a] { b } else { a })
        else {
            self.cheapest = f64::INFINITY;
            return Step::Build;
        };
        // Two that are about as good do not take turns.
        let stays = |now: &f64| now * (1.0 - 0.5 * self.policy.gain) <= costs[best];
        let place = if costs.get(self.current).is_some_and(stays) { self.current } else { best };
        self.cheapest = costs[best];
        if costs[place] > JUMP * self.paid {
            self.left = 0;
        }
        let is_good = costs[place] <= self.policy.ratio * self.expected;
        if !is_good && self.left == 0 {
            return Step::Build;
        }
        self.left = self.left.saturating_sub(1);
        (self.current, self.paid) = (place, costs[place]);
        self.last[place] = self.frame;
        Step::Refit(place)
    }

    /// The new tree of this frame costs so much there. Returns its place among the kept ones and, where one had to go for it, the number of that.
    pub fn built(&mut self, cost: f64) -> (usize, Option<usize>) {
        (self.expected, self.paid) = (cost, cost);
        let was_worth_it = cost <= self.cheapest * (1.0 - self.policy.gain);
        if was_worth_it {
            (self.pause, self.left) = (1, 0);
        } else {
            self.left = self.pause;
            self.pause = (self.pause.saturating_mul(2)).min(self.policy.longest_pause);
        }
        let mut gone = None;
        if self.kept.len() >= self.policy.kept.max(1) {
            let oldest = (0..self.kept.len()).reduce(|a, b| if self.last[b] < self.last[a] { b } else { a });
            if let Some(place) = oldest {
                gone = Some(self.kept.remove(place));
                self.last.remove(place);
            }
        }
        self.kept.push(self.built);
        self.last.push(self.frame);
        self.built += 1;
        self.current = self.kept.len() - 1;
        (self.current, gone)
    }
}

/// What a policy makes of frames whose costs can be asked: by frame, the frame whose tree serves it. A tree is built in each frame that serves itself, and
/// nowhere else.
///
/// `cost(key, frame)` is what the tree of frame `key` costs fitted to `frame`, in a unit in which frames can be compared: see
/// [`triangle_cost`](super::triangle_cost). It is asked for frames in order, and for keys that come before.
pub fn key_frames(frames: usize, policy: Policy, mut cost: impl FnMut(usize, usize) -> f64) -> Vec<usize> {
    let mut state = Rebuild::new(policy);
    // By number of the tree, its frame.
    let mut built_in: Vec<usize> = Vec::new();
    (0..frames)
        .map(|frame| {
            let costs: Vec<f64> = state.kept().iter().map(|&tree| cost(built_in[tree], frame)).collect();
            match state.step(&costs) {
                Step::Refit(place) => built_in[state.kept()[place]],
                Step::Build => {
                    built_in.push(frame);
                    state.built(cost(frame, frame));
                    frame
                }
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn builds(keys: &[usize]) -> usize {
        keys.iter().enumerate().filter(|(frame, key)| frame == *key).count()
    }

    /// How much the tree of a key costs more than a new one, on average over the frames.
    fn mean(keys: &[usize], cost: impl Fn(usize, usize) -> f64) -> f64 {
        let over = |(frame, key): (usize, &usize)| cost(*key, frame) / cost(frame, frame);
        keys.iter().enumerate().map(over).sum::<f64>() / keys.len() as f64
    }

    #[test]
    fn what_stands_still_is_built_once() {
        assert_eq!(key_frames(100, Policy::default(), |_, _| 20.0), [0; 100]);
        assert_eq!(key_frames(3, Policy::default(), |_, _| 0.0), [0; 3]);
        assert_eq!(key_frames(0, Policy::default(), |_, _| 1.0), [0usize; 0]);
    }

    #[test]
    fn a_walk_is_built_for_in_its_first_cycle_alone() {
        let period = 24;
        let phase = |frame: usize| (frame % period) as f64 / period as f64;
        let cost = |key: usize, frame: usize| {
            let apart = (phase(key) - phase(frame)).abs();
            20.0 * (1.0 + apart.min(1.0 - apart))
        };
        let keys = key_frames(40 * period, Policy::default(), cost);
        let first = builds(&keys[..period]);
        assert!((2..=8).contains(&first), "{first} builds");
        assert_eq!(builds(&keys), first, "later cycles take the trees of the first");
        assert!(mean(&keys, cost) <= Policy::default().ratio);
        // A cycle is played like the one before.
        assert_eq!(keys[20 * period..21 * period], keys[21 * period..22 * period]);
    }

    #[test]
    fn what_explodes_is_not_built_over_and_over() {
        // A new tree costs as much as an old one: every frame is dearer than the one before.
        let cost = |_: usize, frame: usize| 20.0 * 1.2f64.powi(frame as i32);
        let keys = key_frames(200, Policy::default(), cost);
        assert!(builds(&keys) <= 10, "{} builds", builds(&keys));

        // Dearer by a jump that a build does not mend, and then still.
        let cost = |_: usize, frame: usize| if frame < 10 { 20.0 } else { 60.0 };
        let keys = key_frames(200, Policy::default(), cost);
        assert_eq!(builds(&keys), 2);

        // A cut during a pause is seen at once.
        let shot = |frame: usize| usize::from(frame >= 27);
        let cost = |key: usize, frame: usize| match shot(key) == shot(frame) {
            true => 20.0 * if frame < 20 { 1.2f64.powi(frame as i32) } else { 38.0 },
            false => 9000.0,
        };
        let keys = key_frames(40, Policy::default(), cost);
        assert_eq!(keys[26..29].iter().filter(|key| **key == 27).count(), 2, "{keys:?}");
    }

    #[test]
    fn what_is_shuffled_is_built_in_every_frame_and_what_comes_back_is_taken_again() {
        // Each frame's triangles stand where another's stood: no tree serves another frame.
        let cost = |key: usize, frame: usize| if key == frame { 20.0 } else { 400.0 };
        let keys = key_frames(50, Policy::default(), cost);
        assert_eq!(builds(&keys), 50);

        // Two shots that alternate.
        let shot = |frame: usize| frame / 5 % 2;
        let cost = |key: usize, frame: usize| if shot(key) == shot(frame) { 20.0 } else { 400.0 };
        let keys = key_frames(200, Policy::default(), cost);
        assert_eq!(builds(&keys), 2);
        assert_eq!(mean(&keys, cost), 1.0);
    }

    #[test]
    fn slow_decay_is_mended_at_about_the_ratio() {
        let cost = |key: usize, frame: usize| 20.0 * (1.0 + 0.01 * (frame - key) as f64);
        let keys = key_frames(220, Policy::default(), cost);
        // After eleven frames a tree is more than a tenth dearer.
        assert_eq!(builds(&keys), 20);
        assert!(mean(&keys, cost) < 1.06);
    }

    #[test]
    fn two_trees_that_are_about_as_good_do_not_take_turns() {
        let mut state = Rebuild::new(Policy::default());
        assert_eq!(state.step(&[]), Step::Build);
        assert_eq!(state.built(20.0), (0, None));
        assert_eq!(state.step(&[30.0]), Step::Build);
        assert_eq!(state.built(20.0), (1, None));
        for frame in 0..20 {
            let other = if frame % 2 == 0 { 19.9 } else { 20.1 };
            assert_eq!(state.step(&[other, 20.0]), Step::Refit(1));
        }
        assert_eq!(state.step(&[20.0, 21.0]), Step::Refit(0));
    }

    #[test]
    fn the_tree_that_has_not_served_for_longest_goes() {
        let mut state = Rebuild::new(Policy { kept: 2, ..Policy::default() });
        state.step(&[]);
        state.built(10.0);
        state.step(&[50.0]);
        state.built(10.0);
        assert_eq!(state.step(&[10.0, 50.0]), Step::Refit(0));
        assert_eq!(state.step(&[50.0, f64::NAN]), Step::Build);
        assert_eq!(state.built(10.0), (1, Some(1)));
        assert_eq!(state.kept(), [0, 2]);
        // What no tree has a cost for is built.
        assert_eq!(state.step(&[f64::NAN, f64::NAN]), Step::Build);
    }
}
