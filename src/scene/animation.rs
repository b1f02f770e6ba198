//! Animations, which some call clips, and the moment of one that a model is posed at.

use std::fmt;
use std::str::FromStr;

/// The moment of an animation at which a glTF model is posed. The default is the first key of the only animation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Moment {
    /// Which animation.
    pub animation: AnimationChoice,
    /// `None` takes the animation's first key. Before its first key an animation holds its first value, and after its last its last.
    pub time: Option<Seconds>,
}

/// Which of a model's animations is meant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum AnimationChoice {
    /// The only one; a model with several is refused.
    #[default]
    Only,
    /// By its number in the file, counted from 0.
    Number(u32),
    /// By its name, letter by letter; refused where several have it.
    Name(String),
}

/// A finite time in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, serde::Serialize)]
pub struct Seconds(f64);

/// One of a glTF model's animations.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Animation {
    /// Its number in the file, counted from 0.
    pub number: u32,
    /// Empty if the file names it not. Several animations may have one name.
    pub name: String,
    /// `None` where it moves nothing of the scene that is read.
    pub keys: Option<KeyTimes>,
}

/// When the keys of an animation are, over everything that it moves.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct KeyTimes {
    /// The first, in seconds, as the file has it.
    pub first: f32,
    /// The last.
    pub last: f32,
    /// How many different times there are.
    pub count: u64,
    /// How many to a second, where they are uniform: at equal steps, some of which may have no key. `None` where they are not, or there is but one.
    pub rate: Option<f64>,
}

/// The moment at which a scene was posed.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Posed {
    /// The animation.
    pub animation: Animation,
    /// The time that was asked for, or else that of the animation's first key.
    pub time: Seconds,
}

impl Seconds {
    /// `None` for NaN and infinities.
    pub fn new(seconds: f64) -> Option<Seconds> {
        // The sum makes -0 the 0 that it means, so that equal times are recorded alike.
        seconds.is_finite().then_some(Seconds(seconds + 0.0))
    }

    /// The number.
    pub fn get(self) -> f64 {
        self.0
    }
}

/// No NaN is among them.
impl Eq for Seconds {}

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for Seconds {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Seconds, &'static str> {
        text.parse().ok().and_then(Seconds::new).ok_or("a time is a finite number of seconds, such as 0.5")
    }
}

impl KeyTimes {
    /// Whether a time lies before the first key or after the last, where an animation holds its value.
    pub fn holds_at(&self, time: Seconds) -> bool {
        let time = time.get() as f32;
        time < self.first || time > self.last
    }
}

impl Posed {
    /// Whether the animation shows something at the time: it moves the scene, and the time does not lie outside of its keys.
    pub fn is_within(&self) -> bool {
        self.animation.keys.is_some_and(|keys| !keys.holds_at(self.time))
    }
}

/// `animation 1 'Walk' at 0.5 s (18 keys from 0 to 0.70833331 s, 24 a second)`, and what is else to be said.
impl fmt::Display for Posed {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Posed { animation, time } = self;
        match animation.keys {
            None => write!(f, "{animation} moves nothing of the scene"),
            Some(keys) if keys.holds_at(*time) => {
                let which = if time.get() < f64::from(keys.first) { "first" } else { "last" };
                write!(f, "{animation} holds its {which} value at {time} s ({keys})")
            }
            Some(keys) => write!(f, "{animation} at {time} s ({keys})"),
        }
    }
}

/// `animation 1 'Walk'`.
impl fmt::Display for Animation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "animation {}", self.number)?;
        if self.name.is_empty() { Ok(()) } else { write!(f, " '{}'", super::excerpt::clipped(&self.name)) }
    }
}

/// `from 0 to 0.70833331 s, 18 keys, 24 a second`.
impl fmt::Display for KeyTimes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.count {
            1 => write!(f, "1 key at {} s", self.first),
            count => write!(f, "{count} keys from {} to {} s", self.first, self.last),
        }?;
        self.rate.map_or(Ok(()), |rate| write!(f, ", {rate} a second"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_a_finite_number() {
        assert!([f64::NAN, f64::INFINITY, -f64::INFINITY].iter().all(|t| Seconds::new(*t).is_none()));
        assert!(["nan", "inf", "1e999", "", "1 s"].iter().all(|t| t.parse::<Seconds>().is_err()));
        assert_eq!("-0".parse::<Seconds>().unwrap().to_string(), "0");
        assert_eq!("1e-1".parse::<Seconds>(), Ok(Seconds(0.1)));
    }
}
