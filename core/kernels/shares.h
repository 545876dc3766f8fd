// SPDX-License-Identifier: Apache-2.0
// Contributions of rays to pixels: hits add light as if nothing blocked it, and secondary rays take away the
// light that is blocked (subtractive lighting; paper, section 4.4). Shares are quantised once, so exactly the
// given share can be taken away.

#define MOST_LIGHT R(31.0)  // most light of a hit, in all
FN int units(real x) { return toInt(floor(min(x, MOST_LIGHT) * CONTRIBUTION_ONE + R(0.5))); }

// The contribution of one light (q < f.lights) or one ambient-occlusion ray (other q; without occlusion rays
// there is one share for all ambient light).
struct Share {
  int r, g, b;
  bool wanted;  // a secondary ray must find out whether it is blocked
  vec3 toward;  // direction of the secondary ray
  real reach;   // where the secondary ray ends (tMax)
};

FN Share shareOf(SCENE s, FRAME f, UNIFORM int q, Surface surface, vec3 from, vec3 toEye, vec3 color,
                 real weight, uint pixel, uint sampleIndex) {
  Share share;
  share.toward = surface.normal;
  share.reach = NO_HIT;
  if (q < f.lights) {
    vec3 light = make_v3(lightValue(f, 4 * q + 1), lightValue(f, 4 * q + 2), lightValue(f, 4 * q + 3));
    if (lightValue(f, 4 * q) == R(0.0)) {  // LIGHT_DIRECTIONAL
      share.toward = make_v3(-light.x, -light.y, -light.z);
    } else {
      vec3 l = make_v3(light.x - from.x, light.y - from.y, light.z - from.z);
      real distance1 = sqrt(dot3(l, l));
      real inverse1 = distance1 > R(0.0) ? R(1.0) / distance1 : R(0.0);
      share.toward = make_v3(l.x * inverse1, l.y * inverse1, l.z * inverse1);
      share.reach = distance1;
    }
    real diffuse = s.diffuse * lambert(surface.normal, share.toward) * weight;
    real specular = R(0.0);
    if (s.specular > R(0.0))
      specular = s.specular * phong(surface.normal, share.toward, toEye, s.shininess) * weight;
    share.r = units(diffuse * color.x + specular);
    share.g = units(diffuse * color.y + specular);
    share.b = units(diffuse * color.z + specular);
    // a light behind the surface makes no ray
    share.wanted = s.shadows != 0 && (share.r | share.g | share.b) != 0;
  } else {
    real ambient = s.ambient * weight;
    if (s.occlusionRays > 0) ambient = ambient / toReal(s.occlusionRays);
    share.r = units(ambient * color.x);
    share.g = units(ambient * color.y);
    share.b = units(ambient * color.z);
    share.wanted = s.occlusionRays > 0 && (share.r | share.g | share.b) != 0;
    if (share.wanted)
      share.toward = occlusionDirection(surface.normal, pixel, sampleIndex, f.frame, toUint(q - f.lights),
                                        toUint(s.occlusionRays));
    share.reach = s.occlusionRadius;
  }
  return share;
}

// Limits a share when the ones before have given r, g and b. What a pixel cannot hold is not given, so that
// nothing can take it away.
FN void limitShare(INOUT(Share) share, int r, int g, int b) {
  int most = units(MOST_LIGHT);
  share.r = min(share.r, most - r);
  share.g = min(share.g, most - g);
  share.b = min(share.b, most - b);
  share.wanted = share.wanted && (share.r | share.g | share.b) != 0;
}

// The part of a share that a secondary ray with opacity A takes away. If less than tMin passes, it takes all,
// as if it had met an opaque surface, because whether there is one behind may be known or not, depending on
// the partitions.
FN int lossOf(int share, real A, real tMin) {
  int part = toInt(toReal(share) * A);
  int loss = min(part, share);
  return R(1.0) - A < tMin || A == R(1.0) ? share : loss;
}

// The opacity behind a surface.
FN real opacityBehind(real A, real opacity) {
  return opacity >= R(1.0) ? R(1.0) : A + (R(1.0) - A) * opacity;
}
