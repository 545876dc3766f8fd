// SPDX-License-Identifier: Apache-2.0
// What a hit means to a sampling ray: the values that are recorded there, and whether it counts. fields.h must come
// before.

// The value of a volume where a ray is at t; NaN outside of the volume and in a cell without data. It has the same
// bits in all blocks that hold the cell.
FN real valueMet(VOLUME v, vec3 o, vec3 d, real t) {
  VolumeRay ray = volumeRay(v, o, d, R(0.0), R(1e30));
  real value = asReal(0x7fc00000u);
  // The end of one grid is the end of another one up to rounding.
  bool inside = t >= ray.t0 * R(0.999999) && t <= ray.t1 * R(1.000001) && ray.t0 <= ray.t1;
  if (inside) {
    ivec3 c = cellMet(v, ray.g, t);
    CellValues k = cellValues(v, c);
    if (holdsData(k)) value = valueIn(k, fractionIn(c, pointAt(ray.g, t)));
  }
  return value;
}

// The gradient where a ray is at t, per unit of render space; NaN where there is no value.
FN vec3 gradientMet(VOLUME v, vec3 o, vec3 d, real t) {
  VolumeRay ray = volumeRay(v, o, d, R(0.0), R(1e30));
  real none = asReal(0x7fc00000u);
  vec3 gradient = make_v3(none, none, none);
  bool inside = t >= ray.t0 * R(0.999999) && t <= ray.t1 * R(1.000001) && ray.t0 <= ray.t1;
  if (inside) {
    ivec3 c = cellMet(v, ray.g, t);
    if (holdsData(cellValues(v, c))) gradient = gradientIn(v, c, pointAt(ray.g, t));
  }
  return gradient;
}

// Whether a value is in a condition's range. NaN is in none.
FN bool inRange(real value, real least, real largest) { return value >= least && value <= largest; }
