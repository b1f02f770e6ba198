//! The operations in plain code: what they mean, and what runs where there is no twin.

type V = [f32; 4];

#[inline(always)]
fn zip(a: V, b: V, f: impl Fn(f32, f32) -> f32) -> V {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]
}

#[inline(always)]
pub fn min(a: V, b: V) -> V {
    zip(a, b, |a, b| if a < b { a } else { b })
}

#[inline(always)]
pub fn max(a: V, b: V) -> V {
    zip(a, b, |a, b| if a > b { a } else { b })
}

#[inline(always)]
pub fn add(a: V, b: V) -> V {
    zip(a, b, |a, b| a + b)
}

#[inline(always)]
pub fn sub(a: V, b: V) -> V {
    zip(a, b, |a, b| a - b)
}

#[inline(always)]
pub fn mul(a: V, b: V) -> V {
    zip(a, b, |a, b| a * b)
}

/// Per lane `if a < b { x } else { y }`.
#[inline(always)]
pub fn if_less(a: V, b: V, x: V, y: V) -> V {
    [0, 1, 2, 3].map(|i| if a[i] < b[i] { x[i] } else { y[i] })
}

/// The first three lanes, and 0.
#[inline(always)]
pub fn axes(a: V) -> V {
    [a[0], a[1], a[2], 0.0]
}

/// The low byte of each lane's bits.
#[inline(always)]
pub fn low_bytes(a: V) -> [u32; 4] {
    a.map(|v| v.to_bits() & 0xff)
}

#[inline(always)]
pub fn from_counts(counts: [i32; 4]) -> V {
    counts.map(|c| c as f32)
}

/// Columns of the matrix with these rows.
#[inline(always)]
pub fn transpose(r: [V; 4]) -> [V; 4] {
    [0, 1, 2, 3].map(|c| [r[0][c], r[1][c], r[2][c], r[3][c]])
}
