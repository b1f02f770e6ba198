// f64 arithmetic in 64-bit integers, for devices without double: IEEE 754 binary64, rounding to nearest, ties to even,
// denormals kept. The twin of double.cl. Only what a NaN's bits are is left open.

typedef ulong real; // The number's bits.

#define SIGN 0x8000000000000000UL
#define ONE_BIT 0x0010000000000000UL /* 2^52: the leading bit that a normal number does not store */
#define INFINITE 0x7FF0000000000000UL
#define NOT_A_NUMBER 0x7FF8000000000000UL

static real real_of(ulong bits) { return bits; }
static ulong bits_of(real a) { return a; }
static real magnitude(real a) { return a & ~SIGN; }
static bool is_nan(real a) { return magnitude(a) > INFINITE; }

// v / 2^n, with the lowest bit set where a bit was lost: all that rounding needs to know of those.
static ulong shifted(ulong v, int n) { return n == 0 ? v : n < 64 ? v >> n | ((v << (64 - n)) != 0) : v != 0; }

// The number (significand / 2^62) · 2^(exponent − 1023), rounded. The significand's leading bit is bit 62.
static real rounded(ulong sign, int exponent, ulong significand) {
    if (exponent >= 0x7FF)
        return sign | INFINITE;
    if (exponent < 1) {
        significand = shifted(significand, 1 - exponent);
        exponent = 1;
    }
    ulong lost = significand & 0x3FF;
    significand = (significand + 0x200) >> 10;
    if (lost == 0x200)
        significand &= ~1UL;

    // A leading bit, if there is one, adds 1 to the exponent, and a carry one more.
    return sign | ((ulong)(exponent - 1) << 52) + significand;
}

// A finite number's exponent and significand, as if denormals had the exponent 1; the leading bit of a normal number is
// bit 52.
static int exponent_of(real a) { return max((int)(a >> 52 & 0x7FF), 1); }
static ulong significand_of(real a) { return (a & (ONE_BIT - 1)) | ((a & INFINITE) != 0 ? ONE_BIT : 0); }

// The same with the leading bit at 52 for denormals, too. Not for zero.
static int normalized(real a, ulong *significand) {
    ulong s = significand_of(a);
    int shift = (int)clz(s) - 11;
    *significand = s << shift;
    return exponent_of(a) - shift;
}

static real plus(real a, real b) {
    if (is_nan(a) || is_nan(b))
        return NOT_A_NUMBER;
    if (magnitude(a) < magnitude(b)) {
        real larger = b;
        b = a;
        a = larger;
    }
    ulong sign = a & SIGN;
    bool opposite = ((a ^ b) & SIGN) != 0;
    if (magnitude(a) == INFINITE)
        return opposite && magnitude(b) == INFINITE ? NOT_A_NUMBER : a;
    int exponent = exponent_of(a);
    ulong large = significand_of(a) << 9, small = shifted(significand_of(b) << 9, exponent - exponent_of(b));
    ulong sum = opposite ? large - small : large + small;
    if (sum == 0)
        return opposite ? 0 : sign;
    int shift = (int)clz(sum) - 1;
    return rounded(sign, exponent + 1 - shift, sum << shift);
}

static real minus(real a, real b) { return plus(a, b ^ SIGN); }

static real times(real a, real b) {
    ulong sign = (a ^ b) & SIGN;
    ulong x = magnitude(a), y = magnitude(b);
    if (x > INFINITE || y > INFINITE || (x == INFINITE && y == 0) || (x == 0 && y == INFINITE))
        return NOT_A_NUMBER;
    if (x == INFINITE || y == INFINITE)
        return sign | INFINITE;
    if (x == 0 || y == 0)
        return sign;
    ulong p, q;
    int exponent = normalized(x, &p) + normalized(y, &q) - 1023;
    p <<= 10;
    q <<= 11;
    ulong product = mul_hi(p, q) | (p * q != 0); // In 2^61 .. 2^63.
    return product >> 62 != 0 ? rounded(sign, exponent + 1, product) : rounded(sign, exponent, product << 1);
}

static real over(real a, real b) {
    ulong sign = (a ^ b) & SIGN;
    ulong x = magnitude(a), y = magnitude(b);
    if (x > INFINITE || y > INFINITE || (x == INFINITE && y == INFINITE) || (x == 0 && y == 0))
        return NOT_A_NUMBER;
    if (x == INFINITE || y == 0)
        return sign | INFINITE;
    if (x == 0 || y == INFINITE)
        return sign;
    ulong p, q;
    int exponent = normalized(x, &p) - normalized(y, &q) + 1023;
    if (p < q) {
        p <<= 1;
        exponent--;
    }

    // Long division, 11 bits a step, after the leading bit: 56 bits, and whether anything is left.
    ulong quotient = 1, rest = p - q;
    for (int i = 0; i < 5; i++) {
        rest <<= 11;
        quotient = quotient << 11 | rest / q;
        rest %= q;
    }
    return rounded(sign, exponent, quotient << 7 | (rest != 0));
}

// Numbers as integers of the same order; both zeros are 0.
static long ordered(real a) { return (a & SIGN) != 0 ? -(long)magnitude(a) : (long)a; }
static bool less(real a, real b) { return !is_nan(a) && !is_nan(b) && ordered(a) < ordered(b); }
static bool at_most(real a, real b) { return !is_nan(a) && !is_nan(b) && ordered(a) <= ordered(b); }
static bool equal(real a, real b) { return !is_nan(a) && !is_nan(b) && ordered(a) == ordered(b); }

static real widen(float f) {
    uint bits = as_uint(f), size = bits & 0x7FFFFFFFu;
    ulong sign = (ulong)(bits >> 31) << 63;
    if (size > 0x7F800000u)
        return NOT_A_NUMBER;
    if (size == 0x7F800000u)
        return sign | INFINITE;
    if (size == 0)
        return sign;
    int exponent = max((int)(size >> 23), 1);
    uint significand = (size & 0x7FFFFFu) | (size >= 0x800000u ? 0x800000u : 0);
    int shift = (int)clz(significand) - 8;
    return sign | ((ulong)(exponent - shift + 895) << 52) + ((ulong)significand << (29 + shift)); // 1023 − 127 − 1
}

static float narrow(real a) {
    uint sign = (uint)(a >> 63) << 31;
    if (is_nan(a))
        return as_float(0x7FC00000u);
    int exponent = exponent_of(a) - 896; // 1023 − 127
    if (exponent >= 0xFF)
        return as_float(sign | 0x7F800000u);
    ulong significand = significand_of(a) << 10;
    if (exponent < 1) {
        significand = shifted(significand, 1 - exponent);
        exponent = 1;
    }
    ulong lost = significand & 0x7FFFFFFFFFUL;
    significand = (significand + 0x4000000000UL) >> 39;
    if (lost == 0x4000000000UL)
        significand &= ~1UL;
    return as_float(sign | ((uint)(exponent - 1) << 23) + (uint)significand);
}
