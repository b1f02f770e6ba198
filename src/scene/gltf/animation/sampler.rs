use super::channels::Heeded;
use super::interpolation::{Interpolation, hermite};
use super::keys::{Keys, Place};
use super::motion::Path;
use super::rotation::slerp;
use crate::scene::SceneError;
use crate::scene::gltf::accessor::{self, Shape};
use crate::scene::gltf::reader::Reader;

/// Keys and values of one property, and what lies between them.
#[derive(Debug)]
pub struct Sampler {
    keys: Keys,
    /// Key by key; at each key of a spline the incoming tangent, the value, and the outgoing tangent.
    values: Vec<f64>,
    /// Numbers in a value.
    width: usize,
    interpolation: Interpolation,
    is_rotation: bool,
}

/// Read the key times of a channel. Memory is charged and stays charged.
pub fn keys(reader: &mut Reader, channel: &Heeded) -> Result<Keys, SceneError> {
    let times = accessor::numbers::<1>(reader, channel.input, Shape::TIMES)?;
    // They are floats in the file.
    let times = times.into_iter().map(|[time]| time as f32).collect();
    Keys::new(times).map_err(|why| SceneError::malformed(reader.source.path, format!("{} {why}", channel.what)))
}

impl Sampler {
    /// Read what moves one property. Memory is charged and stays charged.
    pub fn read(reader: &mut Reader, channel: &Heeded) -> Result<Sampler, SceneError> {
        let Heeded { path, output, interpolation, .. } = *channel;
        let keys = keys(reader, channel)?;
        let (values, width) = match path {
            Path::Translation | Path::Scale => {
                let values = accessor::numbers::<3>(reader, output, Shape::TRANSLATION)?;
                (values.into_flattened(), 3)
            }
            Path::Rotation => {
                let values = accessor::fractions::<4>(reader, output, Shape::KEYED_ROTATION)?;
                (values.into_flattened(), 4)
            }
            // Each key has a number for each morph target, so they alone tell how many those are.
            Path::Weights => {
                let values = accessor::fractions::<1>(reader, output, Shape::MORPH_WEIGHTS)?;
                let values = values.into_flattened();
                let width = values.len() / (keys.times().len() * interpolation.values_of_a_key());
                (values, width.max(1))
            }
        };
        let needed = keys.times().len() * interpolation.values_of_a_key() * width;
        if values.len() != needed {
            let (times, given, numbers) = (keys.times().len(), values.len(), channel.path.name());
            let why = format!("{} has {times} keys, but {given} numbers of {numbers}; it needs {needed}", channel.what);
            return Err(SceneError::malformed(reader.source.path, why));
        }
        Ok(Sampler { keys, values, width, interpolation, is_rotation: path == Path::Rotation })
    }

    pub fn keys(&self) -> &Keys {
        &self.keys
    }

    /// The value at a time in seconds. Rotations need not have unit length.
    pub fn at(&self, time: f64) -> Vec<f64> {
        let place = self.keys.find(time);
        let Place::Between { before, share, span, .. } = place else { return self.value(place.step()).to_vec() };
        let (from, to) = (self.value(before), self.value(before + 1));
        match self.interpolation {
            Interpolation::Step => self.value(place.step()).to_vec(),
            Interpolation::Linear => match (from.first_chunk(), to.first_chunk()) {
                (Some(from), Some(to)) if self.is_rotation => slerp(*from, *to, share).to_vec(),
                _ => from.iter().zip(to).map(|(a, b)| (1.0 - share) * a + share * b).collect(),
            },
            Interpolation::CubicSpline => {
                let (leaving, arriving) = (self.part(before, 2), self.part(before + 1, 0));
                let [of_from, of_leaving, of_to, of_arriving] = hermite(share, span);
                let number =
                    |i: usize| of_from * from[i] + of_leaving * leaving[i] + of_to * to[i] + of_arriving * arriving[i];
                (0..self.width).map(number).collect()
            }
        }
    }

    /// The value at a key: that of a spline stands between its tangents.
    fn value(&self, key: usize) -> &[f64] {
        self.part(key, if self.interpolation == Interpolation::CubicSpline { 1 } else { 0 })
    }

    fn part(&self, key: usize, part: usize) -> &[f64] {
        let first = (key * self.interpolation.values_of_a_key() + part) * self.width;
        &self.values[first..first + self.width]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampler(interpolation: Interpolation, values: &[f64], width: usize) -> Sampler {
        let keys = Keys::new(vec![1.0, 3.0]).unwrap();
        Sampler { keys, values: values.to_vec(), width, interpolation, is_rotation: false }
    }

    #[test]
    fn values_between_keys() {
        let at = |interpolation, time| sampler(interpolation, &[0.0, 10.0, 4.0, 20.0], 2).at(time);
        assert_eq!(at(Interpolation::Linear, 1.5), [1.0, 12.5]);
        assert_eq!(at(Interpolation::Step, 2.9), [0.0, 10.0]);
        for interpolation in [Interpolation::Linear, Interpolation::Step] {
            assert_eq!(at(interpolation, -1.0), [0.0, 10.0]);
            assert_eq!(at(interpolation, 1.0), [0.0, 10.0]);
            assert_eq!(at(interpolation, 3.0), [4.0, 20.0]);
            assert_eq!(at(interpolation, 1e9), [4.0, 20.0]);
        }
    }

    /// A cubic polynomial is its own spline: x³ over the two seconds from 1 to 3.
    #[test]
    fn a_spline_of_tangents_per_second_follows_a_cubic() {
        let spline = sampler(Interpolation::CubicSpline, &[99.0, 1.0, 3.0, 27.0, 27.0, 99.0], 1);
        for time in [1.0, 1.25, 2.0, 2.9, 3.0] {
            let [got] = spline.at(time)[..] else { panic!() };
            assert!((got - time.powi(3)).abs() < 1e-12, "{got} at {time}");
        }
    }
}
