//! The random numbers of ray sets and of made scenes.

use crate::geom::vector::dot;

/// SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014). Fifteen lines of our own, because
/// ray sets must never change under a library's update.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Any seed is as good as any other; equal seeds give equal numbers on every machine.
    #[inline]
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// The next 64 bits, uniform.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in 0..1, 53 bits.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2f64.powi(-53)
    }

    /// Uniform in 0..n for n > 0; the bias of at most n·2⁻⁶⁴ is accepted.
    #[inline]
    pub fn below(&mut self, n: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(n)) >> 64) as u64
    }

    /// A whole number in `-most..=most`, as a float.
    #[inline]
    pub fn whole(&mut self, most: u32) -> f32 {
        self.below(2 * u64::from(most) + 1) as f32 - most as f32
    }

    /// True once in two.
    #[inline]
    pub fn coin(&mut self) -> bool {
        self.bits() & 1 == 0
    }

    /// Zeros of both signs.
    #[inline]
    pub fn zeros(&mut self) -> [f32; 3] {
        let bits = self.bits();
        [0, 1, 2].map(|a| if bits >> a & 1 == 0 { 0.0 } else { -0.0f32 })
    }

    /// Uniform on the unit sphere: a point of the ball, found by rejection and scaled, so that no `sin` of some platform enters.
    #[inline]
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let p = [0; 3].map(|_| 2.0 * self.unit() - 1.0);
            let squared = dot(p, p);
            if (1e-6..=1.0).contains(&squared) {
                return p.map(|c| c / squared.sqrt());
            }
        }
    }
}
