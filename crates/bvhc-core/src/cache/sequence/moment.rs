use super::Frames;
use crate::layout::FrameRecord;

/// A moment of a sequence: two frames, and how far it lies on the way from the one to the other.
///
/// Where it is a frame's own, one of the two is that frame and `fraction` is 0 or 1. In a sequence of one frame both are that frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The frame before it, an index into [`Sequence::frames`](Frames::frames).
    pub first: usize,
    /// The frame behind it.
    pub second: usize,
    /// From 0, at the first frame, to 1, at the second.
    pub fraction: f32,
}

impl Frames<'_> {
    /// The moment at so many seconds, as [`FrameRecord::time`] counts them: between the first two neighbouring frames whose times enclose it.
    ///
    /// `None` before the first and behind the last of them, and where the frames have no times: [`Sequence::at_number`](Frames::at_number).
    pub fn at(&self, seconds: f64) -> Option<Moment> {
        moment(self.frames(), seconds, seconds_of)
    }

    /// The moment at a frame's number, as [`FrameRecord::number`] counts them, or between two: 12.25 lies a quarter on the way from 12 to 13. Where numbers
    /// are left out, the way to the next frame that is there is longer.
    ///
    /// `None` before the first frame and behind the last.
    pub fn at_number(&self, number: f64) -> Option<Moment> {
        moment(self.frames(), number, |frame| Some(f64::from(frame.number)))
    }
}

/// A frame's time, where it has one.
pub fn seconds_of(frame: &FrameRecord) -> Option<f64> {
    (frame.flags & FrameRecord::TIMED != 0).then(|| f64::from(frame.time))
}

/// How far `at` lies on the way from `start` to `end`, where it does lie on it.
pub fn fraction(at: f64, start: f64, end: f64) -> Option<f32> {
    let (low, high) = if start <= end { (start, end) } else { (end, start) };
    (low <= at && at <= high).then(|| if start == end { 0.0 } else { ((at - start) / (end - start)) as f32 })
}

/// Numbers ascend. That times fall is a warning alone: so every pair is asked.
fn moment(frames: &[FrameRecord], at: f64, place: impl Fn(&FrameRecord) -> Option<f64>) -> Option<Moment> {
    if let [alone] = frames {
        return (place(alone)? == at).then_some(Moment { first: 0, second: 0, fraction: 0.0 });
    }
    frames.windows(2).enumerate().find_map(|(first, pair)| {
        let fraction = fraction(at, place(&pair[0])?, place(&pair[1])?)?;
        Some(Moment { first, second: first + 1, fraction })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: i32, time: Option<f32>) -> FrameRecord {
        let flags = if time.is_some() { FrameRecord::TIMED } else { 0 };
        FrameRecord { number, placement: 0, time: time.unwrap_or(0.0), flags, reserved: [0; 4] }
    }

    fn found(moment: Option<Moment>) -> Option<(usize, usize, f32)> {
        moment.map(|m| (m.first, m.second, m.fraction))
    }

    #[test]
    fn a_moment_lies_between_the_frames_around_it() {
        let frames = [frame(-2, Some(0.0)), frame(0, Some(0.5)), frame(10, Some(0.75))];
        let at = |seconds: f64| found(moment(&frames, seconds, seconds_of));
        assert_eq!([at(0.0), at(0.125), at(0.5)], [Some((0, 1, 0.0)), Some((0, 1, 0.25)), Some((0, 1, 1.0))]);
        assert_eq!([at(0.625), at(0.75)], [Some((1, 2, 0.5)), Some((1, 2, 1.0))]);
        assert_eq!([-0.1, 0.7500001, f64::NAN, f64::INFINITY].map(at), [None; 4]);
        let number = |n: f64| found(moment(&frames, n, |f| Some(f64::from(f.number))));
        assert_eq!(
            [number(-1.5), number(2.5), number(10.0)],
            [Some((0, 1, 0.25)), Some((1, 2, 0.25)), Some((1, 2, 1.0))]
        );
        assert_eq!([number(-2.1), number(10.1)], [None; 2]);
    }

    #[test]
    fn frames_without_times_or_at_one_time_are_no_fault() {
        let untimed = [frame(1, None), frame(2, None)];
        assert_eq!(moment(&untimed, 0.0, seconds_of), None);
        let alone = [frame(1, Some(2.0))];
        assert_eq!(found(moment(&alone, 2.0, seconds_of)), Some((0, 0, 0.0)));
        assert_eq!(moment(&alone, 2.5, seconds_of), None);
        // Equal times, and one that goes back.
        let odd = [frame(1, Some(1.0)), frame(2, Some(1.0)), frame(3, Some(0.0))];
        assert_eq!(found(moment(&odd, 1.0, seconds_of)), Some((0, 1, 0.0)));
        assert_eq!(found(moment(&odd, 0.25, seconds_of)), Some((1, 2, 0.75)));
        assert_eq!(moment(&[], 0.0, seconds_of), None);
    }
}
