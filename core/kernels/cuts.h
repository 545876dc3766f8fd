// SPDX-License-Identifier: Apache-2.0
// Slices and isosurfaces of a volume within its clip planes.

// The ray inside a volume and its clip planes.
FN VolumeRay clippedRay(CLIPS clips, VOLUME v, vec3 o, vec3 d) {
  real clip0, clip1;
  clipInterval(clips, o, d, clip0, clip1);
  return volumeRay(v, o, d, clip0, clip1);
}

// The t at which the ray crosses the plane n . p = offset where the volume has data; NO_HIT unless it is in
// [tIn, tOut) and greater than tLast.
FN real hitSlice(VOLUME v, VolumeRay ray, vec3 o, vec3 d, vec3 n, real offset, real tIn, real tOut,
                 real tLast) {
  real along = dot3(n, d);
  real t = (offset - dot3(n, o)) / along;
  real hit = NO_HIT;
  if (abs(along) > R(1e-20) && t >= tIn && t < tOut && t > tLast && t >= ray.t0 && t <= ray.t1) {
    real value = sampleAt(v, pointAt(ray.g, t));
    if (value - value == R(0.0)) hit = t;
  }
  return hit;
}

// The first t in [tIn, tOut) that is greater than tLast and a multiple of `every`, but not 0, and at which the
// volume has data; NO_HIT if there is none. The k-th multiple is the same number in all partitions.
FN real hitStep(VOLUME v, VolumeRay ray, real every, real tIn, real tOut, real tLast) {
  real hit = NO_HIT;
  if (ray.t0 <= ray.t1) {
    real from = max(max(max(tIn, tLast), ray.t0), every);
    real k = max(floor(min(from, ray.t1) / every) - R(1.0), R(1.0));
    real t = k * every;
    while (hit == NO_HIT && t < tOut && t <= ray.t1) {
      if (t >= tIn && t > tLast && t >= ray.t0) {
        if (holdsData(cellValues(v, cellMet(v, ray.g, t)))) hit = t;
      }
      k += R(1.0);
      t = k * every;
    }
  }
  return hit;
}

// The first isosurface at t in [tIn, tOut) that is greater than tLast and not behind tHit.
FN IsoHit hitIsosurface(CLIPS clips, VOLUME v, vec3 o, vec3 d, real tIn, real tOut, real tLast, real tHit,
                        IsoStart start, UNIFORM bool anyHit, INOUT(int) cells, INOUT(int) skipped) {
  real clip0, clip1;
  clipInterval(clips, o, d, clip0, clip1);
  VolumeRay ray = volumeRay(v, o, d, R(0.0), R(1e30));
  // A hit on the clip plane itself is kept: the interval is closed there, and empty if the ray begins behind
  // its end.
  real kept = clip1 < R(0.0) ? R(-1.0) : asReal(asUint(max(clip1, R(1e-30))) + 1u);
  real to = min(min(tOut, tHit * R(1.0000005)), kept);
  IsoHit hit = isosurfaceAlong(v, ray, max(tIn, clip0), to, tLast, start, anyHit, cells, skipped);
  if (!(hit.t < tOut)) hit.t = NO_HIT;
  return hit;
}
