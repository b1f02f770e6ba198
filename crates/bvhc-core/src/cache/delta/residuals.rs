//! The vertices of a pose as 8 bytes and 12 planes: `scale`, then for x, y and z the lowest byte of every vertex's residual, the next one, and so on.
//!
//! A coordinate is an integer: with a `scale` of 0 the bits of the number in an order that grows with it, otherwise the multiple of 1 / `scale` that
//! it is. The residual is what the integer is more than predicted.

use super::weights::{NEIGHBOURS, Weights};
use crate::geom::Point;

/// Bytes before the planes.
pub const HEAD: usize = 8;

/// Four of each axis.
pub const PLANES: usize = 12;

/// Bytes of a pose of so many vertices.
pub fn packed_len(vertices: u64) -> u64 {
    HEAD as u64 + PLANES as u64 * vertices
}

/// What a pose is stored relative to: another pose of its topology, and how vertices follow each other.
#[derive(Clone, Copy)]
pub struct Base<'a> {
    pub vertices: &'a [Point],
    pub weights: &'a Weights,
}

/// Where each coordinate is expected, given the vertices before it.
struct Prediction<'a> {
    base: Option<Base<'a>>,
    scale: f64,
    /// How the vertices before moved, the first pose from the origin.
    motions: Vec<[f64; 3]>,
}

impl<'a> Prediction<'a> {
    fn new(base: Option<Base<'a>>, scale: f64, vertices: usize) -> Prediction<'a> {
        Prediction { base, scale, motions: Vec::with_capacity(vertices) }
    }

    /// The coordinates of the base in the unit of the pose.
    fn start(&self, v: usize) -> [f64; 3] {
        let at = self.base.and_then(|base| base.vertices.get(v)).copied().unwrap_or_default();
        if self.scale == 0.0 { at.map(f64::from) } else { at.map(|x| (f64::from(x) * self.scale + 0.5).floor()) }
    }

    fn motion(&self, v: usize) -> [f64; 3] {
        let Some(base) = self.base else { return self.motions.last().copied().unwrap_or_default() };
        let mut sum = [0.0; 3];
        for (weight, motion) in base.weights.at(v).iter().zip(self.motions.iter().rev().take(NEIGHBOURS)) {
            for axis in 0..3 {
                sum[axis] += weight * motion[axis];
            }
        }
        sum
    }

    /// The integers that are expected of vertex `v`, and the coordinates of the base.
    fn next(&self, v: usize) -> ([i32; 3], [f64; 3]) {
        let (start, motion) = (self.start(v), self.motion(v));
        let mut expected = [0; 3];
        for axis in 0..3 {
            let at = start[axis] + motion[axis];
            // A cast to an integer takes the nearest end of the range, and no number as 0.
            expected[axis] = match self.scale == 0.0 {
                true if at.is_nan() => 0,
                true => ordered(at as f32),
                false => (at + 0.5).floor() as i32,
            };
        }
        (expected, start)
    }

    /// Take the integers of the next vertex. Its position.
    fn take(&mut self, integers: [i32; 3], start: [f64; 3]) -> Point {
        let mut position = [0.0; 3];
        let mut motion = [0.0; 3];
        for axis in 0..3 {
            let at = if self.scale == 0.0 {
                position[axis] = of_ordered(integers[axis]);
                f64::from(position[axis])
            } else {
                let at = f64::from(integers[axis]);
                position[axis] = (at / self.scale) as f32;
                at
            };
            motion[axis] = at - start[axis];
        }
        self.motions.push(motion);
        position
    }
}

/// The vertices of a pose from its [`packed_len`] bytes.
///
/// # Errors
/// What is wrong with them.
pub fn decode(packed: &[u8], base: Option<Base<'_>>, out: &mut [Point]) -> Result<(), String> {
    let (head, planes) = packed.split_first_chunk::<HEAD>().ok_or("a pose is cut short")?;
    let scale = f64::from_le_bytes(*head);
    if scale.to_bits() != 0 && !(SMALLEST..=LARGEST).contains(&scale) {
        return Err(format!("a pose has the scale {scale}, which must be 0 or from {SMALLEST:e} to {LARGEST:e}"));
    }
    if planes.len() != PLANES * out.len() {
        return Err(format!("a pose of {} vertices has {} bytes of planes", out.len(), planes.len()));
    }
    let count = out.len();
    let mut prediction = Prediction::new(base, scale, count);
    for (v, position) in out.iter_mut().enumerate() {
        let (expected, start) = prediction.next(v);
        let mut integers = [0; 3];
        for axis in 0..3 {
            let byte = |i: usize| planes[(4 * axis + i) * count + v]; // 12 planes of `count` bytes, which were counted above
            let folded = u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)]);
            integers[axis] = expected[axis].wrapping_add(unfold(folded));
        }
        *position = prediction.take(integers, start);
    }
    Ok(())
}

/// The bytes of a pose. Whoever reads them gets these very vertices if [`decode`] gives them.
pub fn encode(vertices: &[Point], base: Option<Base<'_>>) -> Vec<u8> {
    let scale = scale_of(vertices);
    let mut out = vec![0; packed_len(vertices.len() as u64) as usize];
    out[..HEAD].copy_from_slice(&scale.to_le_bytes());
    let planes = &mut out[HEAD..];
    let mut prediction = Prediction::new(base, scale, vertices.len());
    for (v, position) in vertices.iter().enumerate() {
        let (expected, start) = prediction.next(v);
        let integers = position.map(|x| if scale == 0.0 { ordered(x) } else { lattice(x, scale) });
        for axis in 0..3 {
            let folded = fold(integers[axis].wrapping_sub(expected[axis])).to_le_bytes();
            for (i, byte) in folded.into_iter().enumerate() {
                planes[(4 * axis + i) * vertices.len() + v] = byte;
            }
        }
        prediction.take(integers, start);
    }
    out
}

/// 2⁻¹⁰⁰ and 2¹⁰⁰: what a scale may be.
const SMALLEST: f64 = 7.888609052210118e-31;
const LARGEST: f64 = 1.2676506002282294e30;

/// Decimals that are tried: models in text hardly have more.
const DECIMALS: i32 = 8;

/// How many multiples of a power of two a model may be wide for it to be stored in these.
const LATTICE_BITS: i32 = 21;

/// The number whose multiples of 1 / number all coordinates are, 0 if there is none that helps: a power of two for quantized vertices, a power of ten for
/// those that stood in a text.
fn scale_of(vertices: &[Point]) -> f64 {
    let all = || vertices.as_flattened().iter().copied();
    let fits = |scale: f64| all().all(|x| ((f64::from(lattice(x, scale)) / scale) as f32).to_bits() == x.to_bits());
    let (mut lowest, mut highest) = (i32::MAX, i32::MIN);
    for x in all().filter(|x| *x != 0.0) {
        let (exponent, trailing) = parts(x);
        (lowest, highest) = (lowest.min(exponent - 23 + trailing), highest.max(exponent));
        if highest - lowest >= LATTICE_BITS {
            break;
        }
    }
    if highest >= lowest && highest - lowest < LATTICE_BITS && (-100..=100).contains(&lowest) {
        let scale = 2f64.powi(-lowest);
        if fits(scale) {
            return scale;
        }
    }
    (0..=DECIMALS).map(|d| 10f64.powi(d)).find(|scale| fits(*scale)).unwrap_or(0.0)
}

/// The exponent of a number, and how many of the 23 bits behind it are zero at the end.
fn parts(x: f32) -> (i32, i32) {
    let bits = x.to_bits();
    let (exponent, mantissa) = ((bits >> 23 & 0xff) as i32 - 127, bits & 0x7f_ffff);
    (exponent, if mantissa == 0 { 23 } else { mantissa.trailing_zeros() as i32 })
}

fn lattice(x: f32, scale: f64) -> i32 {
    (f64::from(x) * scale + 0.5).floor() as i32
}

/// The bits of a number as an integer that grows with it.
fn ordered(x: f32) -> i32 {
    flip(x.to_bits() as i32)
}

fn of_ordered(integer: i32) -> f32 {
    f32::from_bits(flip(integer) as u32)
}

/// Its own inverse: of negative numbers all bits but the sign.
fn flip(bits: i32) -> i32 {
    bits ^ ((bits >> 31) & i32::MAX)
}

/// Small integers of either sign become small ones without: 0, −1, 1, −2, …
pub fn fold(integer: i32) -> u32 {
    ((integer << 1) ^ (integer >> 31)) as u32
}

pub fn unfold(folded: u32) -> i32 {
    (folded >> 1) as i32 ^ -((folded & 1) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn points(seed: u64, count: usize) -> Vec<Point> {
        let mut random = Random::new(seed);
        (0..count).map(|_| [(); 3].map(|()| random.unit() as f32 * 4.0 - 2.0)).collect()
    }

    fn is_exact(vertices: &[Point], base: Option<Base<'_>>) -> Vec<u8> {
        let packed = encode(vertices, base);
        let mut out = vec![[0.0; 3]; vertices.len()];
        decode(&packed, base, &mut out).unwrap();
        let bits = |some: &[Point]| some.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&out), bits(vertices));
        packed
    }

    #[test]
    fn integers_grow_with_the_numbers_and_fold() {
        let all = [f32::NEG_INFINITY, -3e38, -1.0, -1e-45, 0.0, 1e-45, 0.5, 1.0, f32::INFINITY];
        assert!(all.windows(2).all(|pair| ordered(pair[0]) < ordered(pair[1])));
        assert!(all.iter().all(|x| of_ordered(ordered(*x)) == *x));
        assert_eq!(ordered(-0.0), -1);
        assert_eq!([0, -1, 1, -2, i32::MAX, i32::MIN].map(fold), [0, 1, 2, 3, u32::MAX - 1, u32::MAX]);
        assert!([0, -1, 1, i32::MIN, i32::MAX, 12345].iter().all(|i| unfold(fold(*i)) == *i));
    }

    #[test]
    fn every_bit_comes_back() {
        let base = points(1, 300);
        let weights = Weights::of(&base);
        let base = Base { vertices: &base, weights: &weights };
        let mut odd = points(2, 300);
        odd[5] = [f32::MAX, f32::MIN, 1e-45];
        odd[77] = [f32::NAN, f32::INFINITY, -0.0];
        for vertices in [points(1, 300), points(9, 300), odd, vec![[0.0; 3]; 300]] {
            is_exact(&vertices, None);
            is_exact(&vertices, Some(base));
        }
        is_exact(&[], None);
    }

    #[test]
    fn a_turned_body_takes_few_bits_and_one_that_stands_none() {
        let still = points(4, 500);
        let weights = Weights::of(&still);
        let base = Base { vertices: &still, weights: &weights };
        let (sin, cos) = 0.7f32.sin_cos();
        let turned: Vec<Point> =
            still.iter().map(|[x, y, z]| [cos * x - sin * y, sin * x + cos * y, z + 3.0]).collect();
        let high = |packed: &[u8]| {
            let planes = &packed[HEAD..];
            let of_byte = |i: usize| (0..3).map(move |axis| 4 * axis + i);
            of_byte(3).chain(of_byte(2)).flat_map(|p| &planes[p * 500..(p + 1) * 500]).filter(|b| **b != 0).count()
        };
        let (moved, alone) = (high(&is_exact(&turned, Some(base))), high(&is_exact(&turned, None)));
        assert!(moved * 2 < alone, "{moved} {alone}");
        assert!(is_exact(&still, Some(base))[HEAD..].iter().all(|byte| *byte == 0));
    }

    #[test]
    fn decimals_and_quantized_numbers_are_found() {
        let decimal: Vec<Point> = points(5, 100).iter().map(|p| p.map(|x| (x * 1e4).round() / 1e4)).collect();
        assert_eq!(scale_of(&decimal), 1e4);
        let quantized: Vec<Point> = points(6, 100).iter().map(|p| p.map(|x| (x * 256.0).round() / 256.0)).collect();
        assert_eq!(scale_of(&quantized), 256.0);
        assert_eq!(scale_of(&points(7, 100)), 0.0);
        assert_eq!(scale_of(&[[-0.0, 1.0, 2.0]]), 0.0, "a zero with a sign is no multiple of anything");
        for some in [decimal, quantized] {
            is_exact(&some, None);
        }
    }

    #[test]
    fn broken_bytes_are_refused() {
        let vertices = points(8, 10);
        let packed = encode(&vertices, None);
        let mut out = vec![[0.0; 3]; 10];
        for broken in [&packed[..5], &packed[..packed.len() - 1], &packed[..HEAD]] {
            assert!(decode(broken, None, &mut out).is_err());
        }
        for scale in [f64::NAN, -1.0, -0.0, 1e-40, 1e40, f64::INFINITY] {
            let mut broken = packed.clone();
            broken[..HEAD].copy_from_slice(&scale.to_le_bytes());
            assert!(decode(&broken, None, &mut out).is_err(), "{scale}");
        }
        // Whatever the planes say, something is decoded.
        for scale in [0.0, 1e30, 1e-30] {
            let mut wild: Vec<u8> = (0..packed.len()).map(|i| (i * 97) as u8).collect();
            wild[..HEAD].copy_from_slice(&f64::to_le_bytes(scale));
            decode(&wild, None, &mut out).unwrap();
        }
    }
}
