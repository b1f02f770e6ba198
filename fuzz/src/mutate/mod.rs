//! Changes to inputs: of any bytes, and in the terms of what they are.

pub mod bytes;
pub mod document;
pub mod file;
pub mod packed;
pub mod text;

/// No input is longer: many small cases find more than few large ones.
pub const MAX_LEN: usize = 16 << 10;

/// How a target's input is changed. Any bytes may come in, and what goes out need not be right.
pub type Change = fn(&mut Vec<u8>, &mut Dice, &mut Bytes);

/// How bytes without a structure are changed: by libFuzzer, which knows what the code compares, or by [`bytes::change`].
pub struct Bytes<'a> {
    /// No input may become longer.
    pub room: usize,
    /// Change these bytes, to at most so many.
    pub any: &'a mut dyn FnMut(&mut Vec<u8>, usize),
}

impl Bytes<'_> {
    /// Change all of it.
    pub fn change(&mut self, bytes: &mut Vec<u8>) {
        (self.any)(bytes, self.room);
    }

    /// Change it and keep its length.
    pub fn change_in_place(&mut self, bytes: &mut [u8]) {
        let mut copy = bytes.to_vec();
        (self.any)(&mut copy, bytes.len().max(1));
        let len = copy.len().min(bytes.len());
        bytes[..len].copy_from_slice(&copy[..len]);
    }
}

/// A small generator of numbers, the same everywhere (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014).
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Dice {
        Dice(seed)
    }

    pub fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.roll() % n.max(1) as u64) as usize
    }

    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }
}

/// A word of four bytes that is more often at a boundary than by chance.
pub fn word(old: u32, dice: &mut Dice) -> u32 {
    let float = |v: f32| v.to_bits();
    match dice.below(12) {
        0 => dice.roll() as u32,
        1 | 2 => dice.below(70) as u32,
        3 => u32::MAX - dice.below(3) as u32,
        4 => old.wrapping_add(1),
        5 => old.wrapping_sub(1),
        6 => old ^ 1 << dice.below(32),
        7 => dice.of(&[float(f32::NAN), float(f32::INFINITY), float(f32::NEG_INFINITY), float(-0.0), float(f32::MAX)]),
        8 => float(f32::from_bits(old).next_up()),
        9 => float(f32::from_bits(old).next_down()),
        10 => float(-f32::from_bits(old)),
        _ => float(dice.of(&[0.0, 0.5, 1.0, -1.0, 2.0, 1e-40, 1e-20, 1e20, 3e38])),
    }
}
