// SPDX-License-Identifier: Apache-2.0
// The common subset of C++, ISPC and GLSL in which every other file of this folder is written.
//
//   real, vec3, vec4, ivec3  scalar and short vectors; components are .x .y .z .w; + - * / work elementwise,
//                          with a real too
//   R(0.5)                 a literal of type real
//   FN, FN_OUTLINE         a function; one that is better not inlined
//   UNIFORM                a variable that is the same for all rays (a loop counter)
//   UNMASKED { ... }       a block that also runs for the rays of a gang that take no part here; their
//                          results must do no harm. What a loop carries from one turn to the next then does
//                          not wait until it is known which rays go on
//   INOUT(T), OUT(T)       a parameter that is read and written, or written
//   blendInto(to, x)       to = x, where `to` is a member of a structure that outlives the branch or turn of
//                          the loop. In ISPC a plain assignment would be a masked store to memory, ten times
//                          as slow on a processor without masks. A variable by itself (real, int, vec3) needs
//                          no blendInto
//   make_v3, make_v4, make_i3   constructors
//   toReal(i), toInt(x)    conversions: int or uint (slow) to real; real to int, towards zero
//   asUint, asReal         the bits of a float as an integer and back (not in the twin)
//   asInt, toUint          the bits of a uint as an int, and of an int as a uint
//   min1, max1             of two reals, with one meaning everywhere
//   floatOf(d)             a double, rounded to float; doubles have only + - * /, sqrt, floor, min and max
//   infinity()             +infinity
//   GXY_TWIN               defined where real is double
//
// C++ reads the kernels through single.h (namespace gxy::single, float) and twin.h (namespace gxy::twin,
// double), which define GXY_REAL and include the files in order inside the namespace. So a file of this
// folder has no #pragma once. GLSL and ISPC include each file once, in the same order.
//
// In GLSL nothing needs to be `precise`: the build marks every float operation of a module NoContraction
// (cmake/MakeShader.cmake), so no compiler may contract or reorder.
//
// The subset lacks pointers and buffers (each dialect has its own data access), recursion, structs with
// member functions, default arguments, `uniform`, and implicit conversion between int and real (write
// toReal(i)).
#if defined(GXY_GLSL)
#define real float
#define make_v3 vec3
#define make_v4 vec4
#define R(x) x
#define FN
#define FN_OUTLINE
#define INOUT(T) inout T
#define OUT(T) out T
#define make_i3 ivec3
#define UNIFORM
#define UNMASKED
#define asUint floatBitsToUint
#define asReal uintBitsToFloat
#define asInt int
#define toReal float
#define toInt int
#define toUint uint
#define floatOf float
#define blendInto(to, x) to = x
FN real infinity() { return asReal(0x7f800000u); }
#elif defined(ISPC)
typedef float<3> vec3;
typedef float<4> vec4;
typedef int<3> ivec3;
#define real float
#define R(x) x##f
#define FN static inline
#define FN_OUTLINE static noinline
#define INOUT(T) T&
#define OUT(T) T&
#define UNIFORM uniform
#define UNMASKED unmasked
FN vec3 make_v3(float x, float y, float z) {
  vec3 v = {x, y, z};
  return v;
}
FN vec4 make_v4(float x, float y, float z, float w) {
  vec4 v = {x, y, z, w};
  return v;
}
FN ivec3 make_i3(int x, int y, int z) {
  ivec3 v = {x, y, z};
  return v;
}
FN uint asUint(float x) { return intbits(x); }
FN float asReal(uint x) { return floatbits(x); }
FN int asInt(uint x) { return (int)x; }
FN real infinity() { return floatbits(0x7f800000u); }
FN real toReal(int i) { return (float)i; }
FN real toReal(uint i) { return (float)i; }
FN int toInt(real x) { return (int)x; }
FN uint toUint(int i) { return (uint)i; }
FN real floatOf(double x) { return (float)x; }
// Stores every ray's value, for an idle ray its old one. (If takesPart were assigned where it is declared, it
// would be true for all.)
FN void setTrue(bool& b) { b = true; }
#define GXY_BLEND_INTO(T)                 \
  FN void blendInto(T& to, T x) {         \
    bool takesPart;                       \
    unmasked { takesPart = false; }       \
    setTrue(takesPart);                   \
    unmasked { to = takesPart ? x : to; } \
  }
GXY_BLEND_INTO(float)
GXY_BLEND_INTO(int)
GXY_BLEND_INTO(bool)
GXY_BLEND_INTO(vec3)
GXY_BLEND_INTO(ivec3)
#else
using real = GXY_REAL;
using vec3 = glm::vec<3, GXY_REAL>;
using vec4 = glm::vec<4, GXY_REAL>;
using ivec3 = glm::ivec3;
using uint = unsigned int;
#define R(x) real(x)
#ifndef FN
#define FN inline
#define FN_OUTLINE inline
#endif
#define INOUT(T) T&
#define OUT(T) T&
#define UNIFORM
#define UNMASKED
using std::abs;
using std::ceil;
using std::floor;
using std::max;
using std::min;
using std::sqrt;
FN vec3 make_v3(real x, real y, real z) { return vec3(x, y, z); }
FN vec4 make_v4(real x, real y, real z, real w) { return vec4(x, y, z, w); }
FN ivec3 make_i3(int x, int y, int z) { return ivec3(x, y, z); }
FN real infinity() { return std::numeric_limits<real>::infinity(); }
FN real toReal(int i) { return real(i); }
FN real toReal(uint i) { return real(i); }
FN int toInt(real x) { return int(x); }
FN uint toUint(int i) { return uint(i); }
FN real floatOf(double x) { return real(float(x)); }
template <class T>
FN void blendInto(T& to, T x) {
  to = x;
}
FN int asInt(uint x) { return int(x); }
#if !defined(GXY_TWIN)
FN uint asUint(float x) { return std::bit_cast<uint>(x); }
FN float asReal(uint x) { return std::bit_cast<float>(x); }
#endif
#endif

#define NO_HIT R(1e30)  // the t of a ray that meets nothing
#if defined(GXY_GLSL) || defined(ISPC)
#define ROOT_ITERATIONS 32
#define ROOT_TOLERANCE R(1e-6)
#else
#define ROOT_ITERATIONS 100
#define ROOT_TOLERANCE (sizeof(real) == 8 ? real(1e-15) : real(1e-6))
#endif

// They return the second argument if both are equal (0 and -0) or one is NaN. The languages' own min and max
// differ there.
FN real min1(real a, real b) { return a < b ? a : b; }
FN real max1(real a, real b) { return a > b ? a : b; }
FN real dot3(vec3 a, vec3 b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
FN vec3 cross3(vec3 a, vec3 b) {
  return make_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
FN real lerp1(real a, real b, real f) { return a + f * (b - a); }
FN real clamp1(real x, real lo, real hi) { return min1(max1(x, lo), hi); }
FN vec3 normalize3(vec3 a) {
  real s = R(1.0) / sqrt(dot3(a, a));
  return make_v3(a.x * s, a.y * s, a.z * s);
}
// The unit vector along a, without underflow or overflow of the squares; 0 stays 0.
FN vec3 unit3(vec3 a) {
  real largest = max1(max1(abs(a.x), abs(a.y)), abs(a.z));
  real scale = R(1.0) / (largest > R(1e-37) ? largest : R(1.0));
  vec3 b = make_v3(a.x * scale, a.y * scale, a.z * scale);
  real size = sqrt(dot3(b, b));
  real s = R(1.0) / (size > R(0.5) ? size : R(1.0));
  return make_v3(b.x * s, b.y * s, b.z * s);
}
