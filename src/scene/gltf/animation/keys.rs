use crate::scene::KeyTimes;

/// The times of a sampler's keys: at least one, finite, none before the one in front of it.
#[derive(Debug)]
pub struct Keys(Vec<f32>);

/// Where a time lies among keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// At a key, or where one is held: before the first and after the last.
    Key(usize),
    /// Between a key and the next.
    Between {
        /// The key before.
        before: usize,
        /// How much of the way is done, above 0 and below 1.
        share: f64,
        /// The way, in seconds.
        span: f64,
        /// Seconds to the next key.
        left: f64,
    },
}

/// A value that jumps at a key is taken this many seconds before it, a thousandth of a frame of film: exporters round key times to `f32` and
/// worse, and a frame's own time must not fall before the key that is meant for it.
const AT_ONCE: f64 = 1e-3 / 24.0;

/// Nor before so much of the way to the key is left, where keys are dense.
const NEARLY: f64 = 1e-3;

impl Keys {
    /// What is wrong with the times is told as a phrase.
    pub fn new(times: Vec<f32>) -> Result<Keys, String> {
        if times.is_empty() {
            return Err("has no keys".into());
        }
        if let Some(i) = times.iter().position(|t| !t.is_finite()) {
            return Err(format!("has key {i} at {}; key times must be finite", times[i]));
        }
        match times.windows(2).position(|pair| pair[1] < pair[0]) {
            Some(i) => Err(format!(
                "has key {} at {} s behind one at {} s; key times must increase",
                i + 1,
                times[i + 1],
                times[i]
            )),
            None => Ok(Keys(times)),
        }
    }

    pub fn times(&self) -> &[f32] {
        &self.0
    }

    /// A time that rounds to a key's own is at the key. Where several keys have one time, the last of them counts there.
    pub fn find(&self, time: f64) -> Place {
        let rounded = time as f32;
        let next = self.0.partition_point(|key| *key <= rounded);
        let Some(before) = next.checked_sub(1) else { return Place::Key(0) };
        if next == self.0.len() || self.0[before] == rounded {
            return Place::Key(before);
        }
        let (from, to) = (f64::from(self.0[before]), f64::from(self.0[next]));
        let span = to - from;
        Place::Between { before, share: (time - from) / span, span, left: to - time }
    }
}

impl Place {
    /// The key whose value stands where values jump.
    pub fn step(self) -> usize {
        match self {
            Place::Key(key) => key,
            Place::Between { before, span, left, .. } if left <= AT_ONCE.min(NEARLY * span) => before + 1,
            Place::Between { before, .. } => before,
        }
    }
}

/// The times of all keys that move something; `None` where there are none.
pub fn of_all<'k>(keys: impl Iterator<Item = &'k Keys>) -> Option<KeyTimes> {
    let mut times: Vec<f32> = keys.flat_map(|k| k.times().iter().copied()).collect();
    times.sort_by(f32::total_cmp);
    // -0 and 0 are one time, which the order of bits does not know.
    times.dedup_by(|a, b| a == b);
    let (first, last) = (*times.first()?, *times.last()?);
    Some(KeyTimes { first, last, count: times.len() as u64, rate: rate(&times) })
}

/// How many steps a second the grid has on which all of some ascending times lie, not more than a thousandth of a step beside it.
fn rate(times: &[f32]) -> Option<f64> {
    let mut times: Vec<f64> = times.iter().map(|t| f64::from(*t)).collect();
    // Channels of one animation may round the time of one frame each in its own way.
    times.dedup_by(|next, kept| *next - *kept <= AT_ONCE);
    let (first, last) = (*times.first()?, *times.last()?);
    let smallest = times.windows(2).map(|pair| pair[1] - pair[0]).reduce(f64::min)?;

    // Count the steps from key to key, so that the error of one step does not grow along the animation.
    let mut steps = Vec::with_capacity(times.len());
    let mut step = 0.0;
    for pair in times.windows(2) {
        step += ((pair[1] - pair[0]) / smallest).round();
        steps.push(step);
    }
    let fits = |rate: f64| {
        let slack = |time: f64| NEARLY + 2.0 * rate * f64::from(f32::EPSILON) * time.abs().max(first.abs());
        times[1..].iter().zip(&steps).all(|(time, step)| ((time - first) * rate - step).abs() <= slack(*time))
    };
    let measured = step / (last - first);
    // A whole number was meant where it fits, or one such as 23.976.
    [measured.round(), (measured * 1e3).round() / 1e3, measured].into_iter().find(|rate| *rate > 0.0 && fits(*rate))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(times: &[f32]) -> Keys {
        Keys::new(times.to_vec()).unwrap()
    }

    /// Sampled at k / fps in `f64`, the key that an exporter rounded to `f32` lies before the time or behind it. Its value must stand there.
    #[test]
    fn a_key_of_a_frame_is_met_by_the_time_of_the_frame() {
        for fps in [24.0, 25.0, 30.0, 60.0, 29.97] {
            let times: Vec<f64> = (0..49).map(|k| f64::from(k) / fps).collect();
            let rounded = keys(&times.iter().map(|t| *t as f32).collect::<Vec<_>>());
            // Real exporters are farther off: up to 8e-5 of a frame.
            let shaken = |by: f64| keys(&times.iter().map(|t| (*t + by / fps) as f32).collect::<Vec<_>>());
            for keys in [rounded, shaken(8e-5), shaken(-8e-5)] {
                let met: Vec<usize> = times.iter().map(|t| keys.find(*t).step()).collect();
                assert_eq!(met, (0..49).collect::<Vec<_>>(), "{fps}");
            }
        }
    }

    #[test]
    fn a_step_is_not_taken_early() {
        let step = |times: &[f32], t: f64| keys(times).find(t).step();
        assert_eq!(step(&[0.0, 10.0], 9.999), 0, "a millisecond is not at once, however far the keys lie apart");
        assert_eq!(step(&[0.0, 10.0], 9.99999), 1);
        assert_eq!(step(&[0.0, 0.001], 0.00099), 0, "dense keys are told apart");
        assert_eq!(step(&[0.0, 0.5], 0.49), 0);
    }

    #[test]
    fn a_time_at_a_key_is_no_time_between_keys() {
        let keys = keys(&[0.1, 0.2, 0.2, 0.4]);
        assert_eq!(keys.find(0.1), Place::Key(0));
        assert_eq!(keys.find(0.2), Place::Key(2), "of two keys at one time the last");
        assert_eq!(keys.find(-5.0), Place::Key(0));
        assert_eq!(keys.find(1e300), Place::Key(3));
        let Place::Between { before, share, span, left } = keys.find(0.25) else { panic!() };
        assert_eq!(before, 2);
        assert!((share - 0.25).abs() < 1e-6 && (span - 0.2).abs() < 1e-6 && (left - 0.15).abs() < 1e-6);
        let Place::Between { before: 0, share, .. } = keys.find(0.19999) else { panic!() };
        assert!(share > 0.999 && share < 1.0, "a jump between two keys at one time is not taken early");
    }

    #[test]
    fn times_that_are_none_are_refused() {
        for (times, says) in [
            (vec![], "no keys"),
            (vec![0.0, f32::NAN], "key 1 at NaN"),
            (vec![f32::INFINITY], "key 0 at inf"),
            (vec![0.0, 1.0, 0.5], "key 2 at 0.5 s behind one at 1 s"),
        ] {
            let error = Keys::new(times).unwrap_err();
            assert!(error.contains(says), "{error}");
        }
        assert!(Keys::new(vec![-1.0, 0.0, 0.0]).is_ok());
    }

    #[test]
    fn uniform_keys_have_a_rate() {
        let rate = |times: &[f64]| of_all([keys(&times.iter().map(|t| *t as f32).collect::<Vec<_>>())].iter())?.rate;
        for fps in [1.0, 12.5, 24.0, 30.0, 60.0, 29.97] {
            let frames: Vec<f64> = (3..500).map(|k| f64::from(k) / fps).collect();
            let found = rate(&frames).unwrap();
            assert!((found - fps).abs() < 1e-4, "{found} for {fps}");
            assert!(fps.fract() != 0.0 || found == fps, "{found} for {fps}");
            // A key may be missing, and far from 0 a float is coarse.
            let holes: Vec<f64> = frames.iter().enumerate().filter(|(i, _)| i % 7 != 3).map(|(_, t)| *t).collect();
            assert!((rate(&holes).unwrap() - fps).abs() < 1e-4);
            let far: Vec<f64> = frames.iter().map(|t| t + 3600.0).collect();
            assert!((rate(&far).unwrap() - fps).abs() < 0.1, "{:?} for {fps}", rate(&far));
        }
        assert_eq!(rate(&[0.0, 0.1, 0.25]), None);
        assert_eq!(rate(&[0.5]), None);
        assert_eq!(rate(&[0.5, 0.5]), None);
    }

    #[test]
    fn the_keys_of_all_channels_are_told_together() {
        let all = of_all([keys(&[0.0, 0.5]), keys(&[0.25, 0.5]), keys(&[1.0])].iter()).unwrap();
        assert_eq!(all, KeyTimes { first: 0.0, last: 1.0, count: 4, rate: Some(4.0) });
        assert_eq!(of_all(std::iter::empty()), None);
        // Two channels that round one frame each in its own way.
        let shaken = of_all([keys(&[0.0, 0.5, 1.0]), keys(&[0.0, 0.500001, 1.0])].iter()).unwrap();
        assert_eq!((shaken.count, shaken.rate), (4, Some(2.0)));
    }
}
