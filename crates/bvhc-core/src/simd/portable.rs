//! The operations in plain code: what they mean, and what runs where there is no twin.

/// Four floats.
pub type Vector = [f32; 4];

#[inline(always)]
pub fn of(v: [f32; 4]) -> Vector {
    v
}

#[inline(always)]
pub fn array(v: Vector) -> [f32; 4] {
    v
}

#[inline(always)]
fn zip(a: Vector, b: Vector, f: impl Fn(f32, f32) -> f32) -> Vector {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]
}

#[inline(always)]
fn zip_bits(a: Vector, b: Vector, f: impl Fn(u32, u32) -> u32) -> Vector {
    zip(a, b, |a, b| f32::from_bits(f(a.to_bits(), b.to_bits())))
}

/// `if a < b { a } else { b }`: where one is NaN, `b`.
#[inline(always)]
pub fn min(a: Vector, b: Vector) -> Vector {
    zip(a, b, |a, b| if a < b { a } else { b })
}

/// `if a > b { a } else { b }`: where one is NaN, `b`.
#[inline(always)]
pub fn max(a: Vector, b: Vector) -> Vector {
    zip(a, b, |a, b| if a > b { a } else { b })
}

#[inline(always)]
pub fn add(a: Vector, b: Vector) -> Vector {
    zip(a, b, |a, b| a + b)
}

#[inline(always)]
pub fn sub(a: Vector, b: Vector) -> Vector {
    zip(a, b, |a, b| a - b)
}

#[inline(always)]
pub fn mul(a: Vector, b: Vector) -> Vector {
    zip(a, b, |a, b| a * b)
}

#[inline(always)]
pub fn and(a: Vector, b: Vector) -> Vector {
    zip_bits(a, b, |a, b| a & b)
}

#[inline(always)]
pub fn xor(a: Vector, b: Vector) -> Vector {
    zip_bits(a, b, |a, b| a ^ b)
}

/// A bit per lane, the first lane's lowest: `a < b`.
#[inline(always)]
pub fn less(a: Vector, b: Vector) -> u32 {
    (0..4).fold(0, |bits, i| bits | u32::from(a[i] < b[i]) << i)
}

/// A bit per lane, the first lane's lowest: `a <= b`.
#[inline(always)]
pub fn less_or_equal(a: Vector, b: Vector) -> u32 {
    (0..4).fold(0, |bits, i| bits | u32::from(a[i] <= b[i]) << i)
}

/// Per lane `if a < b { x } else { y }`.
#[inline(always)]
pub fn if_less(a: Vector, b: Vector, x: Vector, y: Vector) -> Vector {
    [0, 1, 2, 3].map(|i| if a[i] < b[i] { x[i] } else { y[i] })
}

/// The first three lanes, and 0.
#[inline(always)]
pub fn axes(a: Vector) -> Vector {
    [a[0], a[1], a[2], 0.0]
}

/// Per lane `first·a + second·b`, with products and sum in `f64` and the result rounded once.
#[inline(always)]
pub fn mix(a: Vector, b: Vector, first: f64, second: f64) -> Vector {
    zip(a, b, |a, b| (first * f64::from(a) + second * f64::from(b)) as f32)
}

/// The low byte of each lane's bits.
#[inline(always)]
pub fn low_bytes(a: Vector) -> [u32; 4] {
    a.map(|v| v.to_bits() & 0xff)
}

/// Each integer rounded to the nearest float.
#[inline(always)]
pub fn from_counts(counts: [i32; 4]) -> Vector {
    counts.map(|c| c as f32)
}

/// Lanes 2, 3, 2, 3.
#[inline(always)]
pub fn upper(a: Vector) -> Vector {
    [a[2], a[3], a[2], a[3]]
}

/// Lanes 2, 0, 1, 1.
#[inline(always)]
pub fn previous(a: Vector) -> Vector {
    [a[2], a[0], a[1], a[1]]
}

/// Columns of the matrix with these rows.
#[inline(always)]
pub fn transpose(rows: [Vector; 4]) -> [Vector; 4] {
    [0, 1, 2, 3].map(|c| [rows[0][c], rows[1][c], rows[2][c], rows[3][c]])
}

/// The first three columns of the matrix with these rows and the last row once more.
#[inline(always)]
pub fn transpose_three(rows: [Vector; 3]) -> [Vector; 3] {
    [0, 1, 2].map(|c| [rows[0][c], rows[1][c], rows[2][c], rows[2][c]])
}
