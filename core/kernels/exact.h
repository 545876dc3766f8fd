// SPDX-License-Identifier: Apache-2.0
// Sums and products with their rounding errors, and the use of these: a ray is computed from near its target.
//
// The error of + and of * is itself a float (short of underflow and overflow), and can be computed with + - *
// alone: Knuth, The Art of Computer Programming vol. 2, 4.2.2; Dekker, Numerische Mathematik 18, 1971.

// a + b = sum + lost, exactly.
FN void twoSum(real a, real b, OUT(real) sum, OUT(real) lost) {
  sum = a + b;
  real bb = sum - a;
  lost = (a - (sum - bb)) + (b - bb);
}

// a * b - product, exactly, where `product` is the rounded product; for |a|, |b| < 1e30 and |a b| = 0 or
// above 1e-30.
FN real productError(real a, real b, real product) {
#if defined(GXY_TWIN)
  return std::fma(a, b, -product);
#else
  real ca = R(4097.0) * a;
  real aHigh = ca - (ca - a);
  real aLow = a - aHigh;
  real cb = R(4097.0) * b;
  real bHigh = cb - (cb - b);
  real bLow = b - bHigh;
  return aLow * bLow - (((product - aHigh * bHigh) - aLow * bHigh) - aHigh * bLow);
#endif
}

// (origin - target) + t * direction, with about one rounding, although both terms may be far larger than the
// result.
FN real pointFromTarget(real origin, real direction, real t, real target) {
  real apart;
  real apartLost;
  twoSum(origin, -target, apart, apartLost);
  real step = t * direction;
  real stepLost = productError(t, direction, step);
  real sum;
  real sumLost;
  twoSum(apart, step, sum, sumLost);
  return sum + ((sumLost + apartLost) + stepLost);
}

// The ray's point nearest to target, up to rounding of its t, and that point's position relative to target.
// The position is accurate to an ulp of itself however far away the ray starts, and intersectors continue
// from there (Haines, Gunther, Akenine-Moller, Ray Tracing Gems ch. 7, remove the same cancellation only from
// the discriminant).
FN void closestApproach(vec3 origin, vec3 direction, vec3 target, OUT(real) t, OUT(vec3) position) {
  vec3 toTarget = make_v3(target.x - origin.x, target.y - origin.y, target.z - origin.z);
  t = dot3(toTarget, direction) / dot3(direction, direction);
  real x = pointFromTarget(origin.x, direction.x, t, target.x);
  real y = pointFromTarget(origin.y, direction.y, t, target.y);
  real z = pointFromTarget(origin.z, direction.z, t, target.z);
  position = make_v3(x, y, z);
}
