// SPDX-License-Identifier: Apache-2.0
// Directions of ambient-occlusion rays, and the terms of local lighting.

// Integer hash PCG-RXS-M-XS (Jarzynski & Olano, JCGT 9(3), 2020).
FN uint hash1(uint x) {
  uint state = x * 747796405u + 2891336453u;
  uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}
FN uint hash2(uint x, uint y) { return hash1(x + hash1(y)); }

// The top 24 bits as a real in [0, 1).
FN real unitReal(uint bits) { return toReal(asInt(bits >> 8u)) * R(5.9604644775390625e-8); }

// Point `index` of the R2 sequence (Roberts 2018: multiples of the inverse powers of the plastic number),
// shifted modulo 1 by `scramble` (Cranley & Patterson 1976). In integers, so that index may take any value.
FN void lowDiscrepancyPoint(uint index, uint scramble, OUT(real) x, OUT(real) y) {
  x = unitReal(index * 3242174889u + hash1(scramble));
  y = unitReal(index * 2447445414u + hash1(scramble ^ 0x9e3779b9u));
}

// Two unit vectors that are orthogonal to unit vector n and to each other (Duff et al., JCGT 6(1), 2017).
// They jump at n.z = -0.01 and not at 0: normals with n.z = 0 are common, and rounding would choose between
// two sets of directions.
FN void tangents(vec3 n, OUT(vec3) s, OUT(vec3) t) {
  real side = n.z >= R(-0.01) ? R(1.0) : R(-1.0);
  real a = R(-1.0) / (side + n.z);
  real b = n.x * n.y * a;
  s = make_v3(R(1.0) + side * n.x * n.x * a, side * b, -side * n.x);
  t = make_v3(b, side + n.y * n.y * a, -n.y);
}

// A unit direction around unit normal n with density cos / pi, from a point of the unit square (Malley's
// method). Its cosine with n is at least 2e-4.
FN vec3 cosineDirection(vec3 n, real x, real y) {
  vec3 s;
  vec3 t;
  tangents(n, s, t);
  real sine;
  real cosine;
  real angle = R(6.28318531) * y;
  sincos1(angle, sine, cosine);
  real radius = sqrt(x);
  real up = sqrt(R(1.0) - x);
  real p = radius * cosine;
  real q = radius * sine;
  return make_v3((p * s.x + q * t.x) + up * n.x, (p * s.y + q * t.y) + up * n.y,
                 (p * s.z + q * t.z) + up * n.z);
}

// The direction of ambient-occlusion ray k of count, around unit normal n. `pixel` and `sampleIndex` choose
// the shift. Successive frames continue the sequence, so that the directions of each frame, and of all frames
// together, are evenly spread.
FN vec3 occlusionDirection(vec3 n, uint pixel, uint sampleIndex, uint frame, uint k, uint count) {
  real x;
  real y;
  lowDiscrepancyPoint(frame * count + k, hash2(pixel, sampleIndex), x, y);
  return cosineDirection(n, x, y);
}

// The diffuse term of unit vectors: the cosine, 0 from behind.
FN real lambert(vec3 n, vec3 toLight) { return max1(dot3(n, toLight), R(0.0)); }

// The specular term of unit vectors: the cosine between the mirrored light and the eye, to a power >= 0; 0
// from behind.
FN real phong(vec3 n, vec3 toLight, vec3 toEye, real exponent) {
  real facing = dot3(n, toLight);
  real mirrored = R(2.0) * facing * dot3(n, toEye) - dot3(toLight, toEye);
  return facing > R(0.0) && mirrored > R(0.0) ? min1(pow1(mirrored, exponent), R(1.0)) : R(0.0);
}
