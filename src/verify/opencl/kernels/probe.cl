// Each operation that the other kernels use, on numbers that the host knows the answers for.

__kernel void probe(__global const uint *f32, __global const ulong *f64, __global uint *f32_out,
                    __global ulong *f64_out, uint count) {
    size_t id = get_global_id(0);
    if (id >= count)
        return;
    float a = as_float(f32[3 * id]), b = as_float(f32[3 * id + 1]), c = as_float(f32[3 * id + 2]);
    real x = real_of(f64[3 * id]), y = real_of(f64[3 * id + 1]), z = real_of(f64[3 * id + 2]);
    __global uint *f = f32_out + 8 * id;
    f[0] = as_uint(a + b);
    f[1] = as_uint(a - b);
    f[2] = as_uint(a * b);
    f[3] = as_uint(a * b + c);
    f[4] = as_uint(a * b - b * c);
    f[5] = (a < b ? 1 : 0) | (a <= b ? 2 : 0) | (a == b ? 4 : 0);
    f[6] = as_uint(fabs(a) + -b);
    f[7] = as_uint(narrow(x));
    __global ulong *d = f64_out + 8 * id;
    d[0] = bits_of(plus(x, y));
    d[1] = bits_of(minus(x, y));
    d[2] = bits_of(times(x, y));
    d[3] = bits_of(over(x, y));
    d[4] = bits_of(plus(times(x, y), z));
    d[5] = bits_of(minus(times(x, y), times(y, z)));
    d[6] = (less(x, y) ? 1 : 0) | (at_most(x, y) ? 2 : 0) | (equal(x, y) ? 4 : 0);
    d[7] = bits_of(widen(a));
}
