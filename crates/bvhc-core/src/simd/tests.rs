//! The twin that is compiled in has the bits of the portable one.

use super::{Floats, Lanes, Level, Register, Runs, Widest, Work, at_most, level, operations as ops, portable, widest};

const SPECIAL: [f32; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.5,
    0.1,
    255.3,
    12_582_912.0,
    f32::MIN_POSITIVE,
    1e-45,
    -1e-40,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    -f32::NAN,
];

fn bits(v: [f32; 4]) -> [u32; 4] {
    v.map(f32::to_bits)
}

/// Four vectors for every pair of special values; in the first lanes of the first two stand the pair itself.
fn vectors() -> impl Iterator<Item = [[f32; 4]; 4]> {
    let count = SPECIAL.len();
    let vector = move |i: usize| [0, 1, 2, 3].map(|k| SPECIAL[(i * (k + 1) + k) % count]);
    let pairs = (0..count).flat_map(move |i| (0..count).map(move |j| (i, j)));
    pairs.map(move |(i, j)| [vector(i), vector(j), vector(i + j), vector(i * j + 1)])
}

#[test]
fn choices_and_moves_have_the_bits_of_the_portable_twin() {
    for [a, b, c, d] in vectors() {
        let [va, vb, vc, vd] = [a, b, c, d].map(ops::of);
        let check = |name, got: ops::Vector, want: [f32; 4]| {
            assert_eq!(bits(ops::array(got)), bits(want), "{name} of {a:?} {b:?} {c:?} {d:?}");
        };
        check("of", va, portable::array(portable::of(a)));
        check("min", ops::min(va, vb), portable::min(a, b));
        check("max", ops::max(va, vb), portable::max(a, b));
        check("and", ops::and(va, vb), portable::and(a, b));
        check("xor", ops::xor(va, vb), portable::xor(a, b));
        check("if_less", ops::if_less(va, vb, vc, vd), portable::if_less(a, b, c, d));
        check("axes", ops::axes(va), portable::axes(a));
        check("upper", ops::upper(va), portable::upper(a));
        check("previous", ops::previous(va), portable::previous(a));
        for (got, want) in ops::transpose([va, vb, vc, vd]).into_iter().zip(portable::transpose([a, b, c, d])) {
            check("transpose", got, want);
        }
        for (got, want) in ops::transpose_three([va, vb, vc]).into_iter().zip(portable::transpose_three([a, b, c])) {
            check("transpose_three", got, want);
        }
        assert_eq!(ops::less(va, vb), portable::less(a, b), "{a:?} {b:?}");
        assert_eq!(ops::less_or_equal(va, vb), portable::less_or_equal(a, b), "{a:?} {b:?}");
        assert_eq!(ops::low_bytes(va), portable::low_bytes(a), "{a:?}");
    }
}

#[test]
fn arithmetic_has_the_bits_of_the_portable_twin() {
    // NaN made by arithmetic has no specified bits.
    let same = |got: ops::Vector, want: [f32; 4]| {
        let got = ops::array(got);
        got.iter().zip(want).all(|(p, q)| p.to_bits() == q.to_bits() || p.is_nan() && q.is_nan())
    };
    for [a, b, ..] in vectors() {
        let [va, vb] = [a, b].map(ops::of);
        assert!(same(ops::add(va, vb), portable::add(a, b)), "{a:?} + {b:?}");
        assert!(same(ops::sub(va, vb), portable::sub(a, b)), "{a:?} - {b:?}");
        assert!(same(ops::mul(va, vb), portable::mul(a, b)), "{a:?} * {b:?}");
        for second in [0.0, 1.0, 0.3, 1e-45, 1.0 - 2f64.powi(-24)] {
            let got = ops::mix(va, vb, 1.0 - second, second);
            assert!(same(got, portable::mix(a, b, 1.0 - second, second)), "{a:?} and {second} of {b:?}");
        }
    }
    for counts in [[0, 1, 2, 3], [i32::MAX, (1 << 24) + 1, 12_345_678, 7], [-1, i32::MIN, -(1 << 24) - 3, 5]] {
        assert_eq!(bits(ops::array(ops::from_counts(counts))), bits(portable::from_counts(counts)));
    }
}

/// What the portable twin does is what its documentation says: the others are compared with it alone.
#[test]
fn operations_do_what_they_say() {
    let (nan, r) = (f32::NAN, Register::of([1.0, -2.0, 3.0, -4.0]));
    let other = Register::of([nan, -0.0, 3.0, f32::INFINITY]);
    assert_eq!(bits(r.min(other).array()), bits([nan, -2.0, 3.0, -4.0]));
    assert_eq!(bits(other.max(r).array()), bits([1.0, -0.0, 3.0, f32::INFINITY]));
    assert_eq!((r.less(other), r.less_or_equal(other)), (0b1010, 0b1110));
    let (x, y) = (Register::splat(5.0), Register::splat(6.0));
    assert_eq!(r.if_less(other, x, y).array(), [6.0, 5.0, 6.0, 5.0]);
    assert_eq!(r.abs().array(), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(r.negated().array(), [-1.0, 2.0, -3.0, 4.0]);
    assert_eq!(r.axes().array(), [1.0, -2.0, 3.0, 0.0]);
    assert_eq!(r.upper().array(), [3.0, -4.0, 3.0, -4.0]);
    assert_eq!(r.previous().array(), [3.0, 1.0, -2.0, -2.0]);
    assert_eq!((r + r).array(), [2.0, -4.0, 6.0, -8.0]);
    assert_eq!((r - x).array(), [-4.0, -7.0, -2.0, -9.0]);
    assert_eq!((r * r).array(), [1.0, 4.0, 9.0, 16.0]);
    assert_eq!(r.mix(x, 0.75, 0.25).array(), [2.0, -0.25, 3.5, -1.75]);
    let rows = [0.0, 4.0, 8.0, 12.0].map(|first| Register::of([first, first + 1.0, first + 2.0, first + 3.0]));
    let columns = Register::transpose(rows).map(Register::array);
    assert_eq!(columns, [0.0, 1.0, 2.0, 3.0].map(|first| [first, first + 4.0, first + 8.0, first + 12.0]));
    let three = Register::transpose_three([rows[0], rows[1], rows[2]]).map(Register::array);
    assert_eq!(three, [0.0, 1.0, 2.0].map(|first| [first, first + 4.0, first + 8.0, first + 8.0]));
    assert_eq!(Lanes::of_counts([7, 8, 9, 300]).0, [7.0, 8.0, 9.0, 300.0]);
    assert_eq!(Lanes([0x1234_5678, 1, 0x100, 0x1ff].map(f32::from_bits)).low_bytes(), [0x78, 1, 0, 0xff]);
}

#[test]
fn a_test_can_lower_the_level_and_results_stay() {
    let sums = || {
        widest(
            #[inline(always)]
            || {
                let column: [f32; 64] = std::array::from_fn(|i| 0.1 * i as f32);
                column.map(|v| v * v + 1.0 / (v + 0.3))
            },
        )
    };
    let wide = sums();
    for limit in [Level::Portable, Level::BASE, Level::Avx2] {
        at_most(limit, || {
            assert!(level() >= Level::BASE && level() <= limit.max(Level::BASE));
            assert_eq!(sums().map(f32::to_bits), wide.map(f32::to_bits));
        });
    }
    assert!(level() >= Level::BASE, "the limit ends with the work");
    at_most(Level::BASE, || assert_eq!(level(), Level::BASE));
}

/// Some byte of it.
fn low_byte(v: f32) -> u8 {
    (v.to_bits() >> 16) as u8
}

/// Every operation on `N` floats, as bits.
struct Operations<const N: usize>([[f32; N]; 2]);

impl<const N: usize> Work<N> for Operations<N> {
    type Out = (Vec<u32>, u32);

    #[inline(always)]
    fn run<V: Floats<N>>(self, door: V::Door) -> (Vec<u32>, u32) {
        let [a, b] = self.0.map(|v| V::of(door, &v));
        let bytes = V::of_bytes(door, &self.0[0].map(low_byte));
        let splat = V::splat(door, self.0[1][0]);
        let results = [V::plus(a, b), V::minus(a, b), V::times(a, b), V::max(a, b), V::negated(a), splat, a, bytes];
        // NaN made by arithmetic has no specified bits.
        let bits = |v: f32| if v.is_nan() { f32::NAN.to_bits() } else { v.to_bits() };
        (results.into_iter().flat_map(V::array).map(bits).collect(), V::less_or_equal(a, b))
    }
}

/// What the operations mean, lane by lane.
fn plain<const N: usize>([a, b]: [[f32; N]; 2]) -> (Vec<u32>, u32) {
    let max = |p: f32, q: f32| if p > q { p } else { q };
    let rows: [[f32; N]; 8] = [
        std::array::from_fn(|i| a[i] + b[i]),
        std::array::from_fn(|i| a[i] - b[i]),
        std::array::from_fn(|i| a[i] * b[i]),
        std::array::from_fn(|i| max(a[i], b[i])),
        a.map(|v| -v),
        [b[0]; N],
        a,
        a.map(|v| f32::from(low_byte(v))),
    ];
    let bits = |v: f32| if v.is_nan() { f32::NAN.to_bits() } else { v.to_bits() };
    (rows.into_iter().flatten().map(bits).collect(), (0..N).map(|i| u32::from(a[i] <= b[i]) << i).sum())
}

#[test]
fn floats_have_the_same_bits_in_any_registers() {
    for [a, b, c, d] in vectors() {
        let eight = [[a, b], [c, d]].map(bytemuck::cast::<[[f32; 4]; 2], [f32; 8]>);
        let want = plain(eight);
        assert_eq!(Widest::run(Operations(eight)), want, "{eight:?}");
        assert_eq!(at_most(Level::BASE, || Widest::run(Operations(eight))), want, "{eight:?}");
        assert_eq!(Widest::run(Operations([a, b])), plain([a, b]), "{a:?} {b:?}");
    }
}
