// SPDX-License-Identifier: Apache-2.0
// The origin of a secondary ray: off the surface by a number of ulps, and never by a length of the world.
//
// After Wachter & Binder, Ray Tracing Gems ch. 6, who step each coordinate by 256 of its ulps and switch to a
// world length near 0. Here the ulp is that of the largest number that the hit was computed from, which the
// caller passes in. So there is no such length, and scenes of any scale behave alike.

// The spacing of floats around x > 0 (a power of two).
FN real ulpAt(real x) {
#if defined(GXY_TWIN)
  return std::exp2(std::floor(std::log2(x)) - 23.0);
#else
  return asReal(asUint(max1(x, R(1e-30))) & 0x7f800000u) * R(1.1920929e-7);
#endif
}

// The number of ulps: the error of the intersectors of this folder (about 6), with a margin.
FN real offsetUlps() { return R(32.0); }

// Returns `point` moved off the surface. point: on the surface, up to rounding; side: unit normal on the side
// to which the ray goes; size: the largest of the primitive's absolute coordinates and radius (|point| is
// taken into account here).
FN vec3 offsetOrigin(vec3 point, vec3 side, real size) {
  real largest = max1(max1(abs(point.x), abs(point.y)), max1(abs(point.z), size));
  real step = offsetUlps() * ulpAt(largest);
  return make_v3(point.x + step * side.x, point.y + step * side.y, point.z + step * side.z);
}
