//! Does a device compute as IEEE 754 says? A kernel does each operation of the others on a fixed set of numbers, and
//! the host compares the bits.

use super::driver::{Arg, Buffer, Context, DeviceId, Program, Queue, Status};
use crate::random::Random;

/// Triples of numbers that operations are tried on.
const PROBES: usize = 2048;

const F32_OPERATIONS: [&str; 8] = [
    "f32 addition",
    "f32 subtraction",
    "f32 multiplication",
    "f32 product and sum in two steps",
    "f32 difference of two products",
    "f32 comparison",
    "f32 magnitude and negation",
    "rounding f64 to f32",
];

const F64_OPERATIONS: [&str; 8] = [
    "f64 addition",
    "f64 subtraction",
    "f64 multiplication",
    "f64 division",
    "f64 product and sum in two steps",
    "f64 difference of two products",
    "f64 comparison",
    "widening f32 to f64",
];

/// An operation whose result was not the host's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Deviation {
    pub operation: &'static str,
    /// Of how many probes the bits differ.
    pub wrong: usize,
    /// Whether each of those has a denormal number among operands or result.
    pub denormal: bool,
    pub first: String,
}

/// The numbers of all probes and what the host makes of them.
struct Probes {
    f32s: Vec<[u32; 3]>,
    f64s: Vec<[u64; 3]>,
    f32_answers: Vec<[u32; 8]>,
    f64_answers: Vec<[u64; 8]>,
}

/// Run the kernel `probe` of `program` and say what deviates, worst news first: `f64` operations, then `f32`.
pub(super) fn probe(
    context: &Context,
    queue: &Queue,
    device: DeviceId,
    program: &Program,
) -> Result<Vec<Deviation>, Status> {
    let probes = Probes::new();
    let mut kernel = program.kernel(c"probe")?;
    let group_size = kernel.group_size(device, 64)?;
    let mut f32s = Buffer::new(context, PROBES * 12)?;
    let mut f64s = Buffer::new(context, PROBES * 24)?;
    let (f32_out, f64_out) = (Buffer::new(context, PROBES * 32)?, Buffer::new(context, PROBES * 64)?);
    f32s.write(queue, 0, &probes.f32s)?;
    f64s.write(queue, 0, &probes.f64s)?;
    let buffers = [&f32s, &f64s, &f32_out, &f64_out].map(Arg::Buffer);
    let args: Vec<Arg<'_>> = buffers.into_iter().chain([Arg::U32(PROBES as u32)]).collect();

    // SAFETY: these are the kernel's parameters, and each item reads 3 and writes 8 numbers of its own, for which there
    // is room.
    #[allow(unsafe_code)]
    unsafe {
        kernel.run(queue, &args, PROBES.div_ceil(group_size), group_size)?;
    }
    let (mut f32_got, mut f64_got) = (vec![[0u32; 8]; PROBES], vec![[0u64; 8]; PROBES]);
    f32_out.read(queue, 0, &mut f32_got)?;
    f64_out.read(queue, 0, &mut f64_got)?;
    Ok(probes.judge(&f32_got, &f64_got))
}

impl Probes {
    fn new() -> Probes {
        let mut random = Random::new(0x0DD5);
        let f32s: Vec<[u32; 3]> = (0..PROBES).map(|i| [0; 3].map(|_| some_f32(&mut random, i))).collect();
        let f64s: Vec<[u64; 3]> = (0..PROBES).map(|i| [0; 3].map(|_| some_f64(&mut random, i))).collect();
        let f32_answers =
            f32s.iter().zip(&f64s).map(|(f, d)| f32_answers(f.map(f32::from_bits), d.map(f64::from_bits)));
        let f64_answers =
            f32s.iter().zip(&f64s).map(|(f, d)| f64_answers(f.map(f32::from_bits), d.map(f64::from_bits)));
        Probes { f32_answers: f32_answers.collect(), f64_answers: f64_answers.collect(), f32s, f64s }
    }

    fn judge(&self, f32_got: &[[u32; 8]], f64_got: &[[u64; 8]]) -> Vec<Deviation> {
        let mut out = Vec::new();
        for (k, operation) in F64_OPERATIONS.into_iter().enumerate() {
            let numbers = k != 6;
            let same = |a: u64, b: u64| a == b || (numbers && f64::from_bits(a).is_nan() && f64::from_bits(b).is_nan());
            let wrong = (0..PROBES).filter(|&i| !same(f64_got[i][k], self.f64_answers[i][k]));
            let strange = |i: usize| {
                let operands = self.f64s[i].into_iter().chain([self.f64_answers[i][k]]);
                let narrow = k == 7 && f32::from_bits(self.f32s[i][0]).is_subnormal();
                narrow || operands.into_iter().any(|bits| f64::from_bits(bits).is_subnormal())
            };
            let first = |i: usize| {
                let [x, y, z] = self.f64s[i];
                let (got, want) = (f64_got[i][k], self.f64_answers[i][k]);
                format!("of {x:#018x}, {y:#018x}, {z:#018x}: {got:#018x}, not {want:#018x}")
            };
            out.extend(deviation(operation, wrong.collect(), strange, first));
        }
        for (k, operation) in F32_OPERATIONS.into_iter().enumerate() {
            let numbers = k != 5;
            let same = |a: u32, b: u32| a == b || (numbers && f32::from_bits(a).is_nan() && f32::from_bits(b).is_nan());
            let wrong = (0..PROBES).filter(|&i| !same(f32_got[i][k], self.f32_answers[i][k]));
            let strange = |i: usize| {
                let [a, b, c] = self.f32s[i].map(f32::from_bits);
                let products = [a * b, b * c, f32::from_bits(self.f32_answers[i][k])];
                [a, b, c].into_iter().chain(products).any(f32::is_subnormal)
            };
            let first = |i: usize| {
                let [a, b, c] = self.f32s[i];
                let (got, want) = (f32_got[i][k], self.f32_answers[i][k]);
                format!("of {a:#010x}, {b:#010x}, {c:#010x}: {got:#010x}, not {want:#010x}")
            };
            out.extend(deviation(operation, wrong.collect(), strange, first));
        }
        out
    }
}

fn deviation(
    operation: &'static str,
    wrong: Vec<usize>,
    strange: impl Fn(usize) -> bool,
    first: impl Fn(usize) -> String,
) -> Option<Deviation> {
    let at = *wrong.first()?;
    let denormal = wrong.iter().all(|&i| strange(i));
    Some(Deviation { operation, wrong: wrong.len(), denormal, first: first(at) })
}

/// In words, for a report; `None` where nothing deviates.
pub(super) fn sentence(deviations: &[Deviation]) -> Option<String> {
    let first = deviations.first()?;
    let names: Vec<&str> = deviations.iter().map(|d| d.operation).collect();
    let denormal = deviations.iter().all(|d| d.denormal);
    let cause = if denormal {
        "only where denormal numbers occur, which it flushes to zero"
    } else {
        "beyond denormal numbers"
    };
    Some(format!(
        "its arithmetic is not that of IEEE 754 {cause}: {} ({} of {PROBES} probes; {} {})",
        names.join(", "),
        first.wrong,
        first.operation,
        first.first
    ))
}

pub(super) fn concerns_f64(deviations: &[Deviation]) -> bool {
    deviations.iter().any(|d| F64_OPERATIONS.contains(&d.operation) || d.operation == F32_OPERATIONS[7])
}

#[allow(clippy::suboptimal_flops)] // Two roundings are the point.
fn f32_answers([a, b, c]: [f32; 3], [x, ..]: [f64; 3]) -> [u32; 8] {
    let comparison = u32::from(a < b) | u32::from(a <= b) << 1 | u32::from(a == b) << 2;
    let numbers = [a + b, a - b, a * b, a * b + c, a * b - b * c, 0.0, a.abs() + -b, x as f32];
    let mut bits = numbers.map(f32::to_bits);
    bits[5] = comparison;
    bits
}

#[allow(clippy::suboptimal_flops)]
fn f64_answers([a, ..]: [f32; 3], [x, y, z]: [f64; 3]) -> [u64; 8] {
    let comparison = u64::from(x < y) | u64::from(x <= y) << 1 | u64::from(x == y) << 2;
    let numbers = [x + y, x - y, x * y, x / y, x * y + z, x * y - y * z, 0.0, f64::from(a)];
    let mut bits = numbers.map(f64::to_bits);
    bits[6] = comparison;
    bits
}

/// Special numbers, numbers near 1, numbers of any size, in turn. Of the numbers near 1 a third are rounded to few
/// bits, so that ties and exact results occur.
fn some_f32(random: &mut Random, i: usize) -> u32 {
    const SPECIAL: [u32; 14] = [
        0,
        0x8000_0000,
        1,
        0x8000_0001,
        0x007F_FFFF,
        0x0080_0000,
        0x0080_0001,
        0x3F80_0000,
        0xBF80_0000,
        0x3F80_0001,
        0x7F7F_FFFF,
        0x7F80_0000,
        0xFF80_0000,
        0x7FC0_0000,
    ];
    let bits = random.bits();
    let sign = (bits >> 63 << 31) as u32;
    match (i % 4, random.below(3)) {
        (0, _) => SPECIAL[random.below(SPECIAL.len() as u64) as usize],
        (1, 0) => bits as u32,
        (1, _) => sign | ((20 + random.below(40)) as u32) << 21 | bits as u32 & 0x001F_FFFF,
        (_, 0) => sign | 0x3F80_0000 | bits as u32 & 0x007F_F000,
        _ => sign | ((126 + random.below(3)) as u32) << 23 | bits as u32 & 0x007F_FFFF,
    }
}

fn some_f64(random: &mut Random, i: usize) -> u64 {
    const SPECIAL: [u64; 16] = [
        0,
        1 << 63,
        1,
        (1 << 63) | 1,
        0x000F_FFFF_FFFF_FFFF,
        0x0010_0000_0000_0000,
        0x0010_0000_0000_0001,
        0x3FF0_0000_0000_0000,
        0xBFF0_0000_0000_0000,
        0x3FF0_0000_0000_0001,
        0x7FEF_FFFF_FFFF_FFFF,
        0x7FF0_0000_0000_0000,
        0xFFF0_0000_0000_0000,
        0x7FF8_0000_0000_0000,
        // Halfway between two f32, and the smallest that f32 rounds up from nothing.
        0x3FF0_0000_1000_0000,
        0x3690_0000_0000_0001,
    ];
    let bits = random.bits();
    let sign = bits & 1 << 63;
    let fraction = bits & 0x000F_FFFF_FFFF_FFFF;
    match (i % 4, random.below(4)) {
        (0, _) => SPECIAL[random.below(SPECIAL.len() as u64) as usize],
        (1, 0) => bits,
        // Products and quotients of these underflow, gradually or at once.
        (1, 1) => sign | (480 + random.below(60)) << 52 | fraction,
        (1, _) => sign | random.below(40) << 52 | fraction,
        // What f32 overflows at, underflows at, and has denormals for.
        (2, 0) => sign | (1023 + 120 + random.below(12)) << 52 | fraction,
        (2, 1) => sign | (1023 - 152 + random.below(32)) << 52 | fraction,
        (_, 2) => sign | 1023 << 52 | fraction & 0x000F_FFFF_F000_0000,
        _ => sign | (1022 + random.below(3)) << 52 | fraction,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_answers_are_no_deviation_and_one_wrong_bit_is() {
        let probes = Probes::new();
        assert_eq!(probes.judge(&probes.f32_answers, &probes.f64_answers), []);
        let mut wrong = probes.f32_answers.clone();
        let at = (0..PROBES).find(|&i| f32::from_bits(wrong[i][2]).is_normal()).expect("a product");
        wrong[at][2] ^= 1;
        let found = probes.judge(&wrong, &probes.f64_answers);
        assert_eq!((found.len(), found[0].operation, found[0].wrong), (1, "f32 multiplication", 1));
        assert!(!concerns_f64(&found) && sentence(&found).is_some_and(|s| s.contains("f32 multiplication")));
    }

    #[test]
    fn flushing_denormals_contracting_and_coarse_division_are_told() {
        let probes = Probes::new();
        let flush = |bits: u32| if f32::from_bits(bits).is_subnormal() { bits & 1 << 31 } else { bits };
        let flushed: Vec<[u32; 8]> = probes.f32_answers.iter().map(|row| row.map(flush)).collect();
        let found = probes.judge(&flushed, &probes.f64_answers);
        assert!(found.len() >= 6 && found.iter().all(|d| d.denormal), "{found:#?}");
        assert!(sentence(&found).is_some_and(|s| s.contains("flushes to zero")));

        let mut fused = probes.f32_answers.clone();
        for (row, bits) in fused.iter_mut().zip(&probes.f32s) {
            let [a, b, c] = bits.map(f32::from_bits);
            row[3] = a.mul_add(b, c).to_bits();
        }
        let found = probes.judge(&fused, &probes.f64_answers);
        assert!(found.len() == 1 && !found[0].denormal && found[0].wrong > PROBES / 10, "{found:#?}");

        let mut coarse = probes.f64_answers.clone();
        for (row, bits) in coarse.iter_mut().zip(&probes.f64s) {
            let [x, y, _] = bits.map(f64::from_bits);
            row[3] = (x * (1.0 / y)).to_bits();
        }
        let found = probes.judge(&probes.f32_answers, &coarse);
        assert!(found.len() == 1 && concerns_f64(&found), "{found:#?}");
    }
}
