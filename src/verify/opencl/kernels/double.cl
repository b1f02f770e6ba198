// f64 arithmetic by the device's own double. The twin soft_double.cl has the same functions for devices without one.
//
// Every operation is a function, so that the kernels below read the same with both.

#pragma OPENCL EXTENSION cl_khr_fp64 : enable

typedef double real;

static real real_of(ulong bits) { return as_double(bits); }
static ulong bits_of(real a) { return as_ulong(a); }
static real widen(float a) { return (double)a; }
static float narrow(real a) { return (float)a; } // To nearest, ties to even: OpenCL's default.
static real plus(real a, real b) { return a + b; }
static real minus(real a, real b) { return a - b; }
static real times(real a, real b) { return a * b; }
static real over(real a, real b) { return a / b; }
static bool less(real a, real b) { return a < b; }
static bool at_most(real a, real b) { return a <= b; }
static bool equal(real a, real b) { return a == b; }
static real magnitude(real a) { return fabs(a); }
