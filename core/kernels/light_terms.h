// SPDX-License-Identifier: Apache-2.0
// Contributions of rays to pixels: hits add light as if nothing blocked it, and secondary rays take away the
// light that is blocked (subtractive lighting; the Galaxy paper, section 4.4). Terms are quantised once, so exactly
// what was added can be taken away.

#define MOST_LIGHT R(31.0)  // most light of a hit, in all
FN int units(real x) { return toInt(floor(min(x, MOST_LIGHT) * CONTRIBUTION_ONE + R(0.5))); }

// The contribution of one light (q < f.lights) or one ambient-occlusion ray (other q; without occlusion rays
// there is one term for all ambient light).
struct LightTerm {
  int r, g, b;
  bool wanted;  // a secondary ray must find out whether it is blocked
  vec3 toward;  // direction of the secondary ray
  real reach;   // where the secondary ray ends (tMax)
  bool behind;  // it starts on the other side of the surface
};

// Where the secondary ray of a term starts: on the side of the surface to which it goes.
FN vec3 startOf(LightTerm term, Surface surface, vec3 from) {
  vec3 behind = make_v3(-surface.geometric.x, -surface.geometric.y, -surface.geometric.z);
  vec3 start = from;
  if (term.behind) start = offsetOrigin(surface.point, behind, surface.size);
  return start;
}
// Its RAY_START and RAY_SIDE bits.
FN uint startBitsOf(LightTerm term, Surface surface) {
  return term.behind && surface.start != 0u ? surface.start ^ (1u << 20) : surface.start;
}

// `opacity` is that of the surface, `weight` what is seen of it. Where the shading normal is not that of the surface, a secondary ray may go
// to its other side. Then the surface itself hides light, and an opaque one needs no ray.
FN LightTerm lightTermOf(SCENE s, FRAME f, UNIFORM int q, Surface surface, vec3 from, vec3 toEye, vec3 color,
                         real opacity, real weight, uint pixel, uint sampleIndex) {
  LightTerm term;
  term.toward = surface.normal;
  term.reach = NO_HIT;
  if (q < f.lights) {
    vec3 light = make_v3(lightValue(f, 4 * q + 1), lightValue(f, 4 * q + 2), lightValue(f, 4 * q + 3));
    if (lightValue(f, 4 * q) == R(0.0)) {  // LIGHT_DIRECTIONAL
      term.toward = make_v3(-light.x, -light.y, -light.z);
    } else {
      vec3 l = make_v3(light.x - from.x, light.y - from.y, light.z - from.z);
      real distance1 = sqrt(dot3(l, l));
      real inverse1 = distance1 > R(0.0) ? R(1.0) / distance1 : R(0.0);
      term.toward = make_v3(l.x * inverse1, l.y * inverse1, l.z * inverse1);
      term.reach = distance1;
    }
    term.behind = s.shadows != 0 && dot3(surface.geometric, term.toward) < R(0.0);
    real seen = term.behind ? weight * (R(1.0) - opacity) : weight;
    real diffuse = s.diffuse * lambert(surface.normal, term.toward) * seen;
    real specular = R(0.0);
    if (s.specular > R(0.0))
      specular = s.specular * phong(surface.normal, term.toward, toEye, s.shininess) * seen;
    term.r = units(diffuse * color.x + specular);
    term.g = units(diffuse * color.y + specular);
    term.b = units(diffuse * color.z + specular);
    // a light behind the surface makes no ray
    term.wanted = s.shadows != 0 && (term.r | term.g | term.b) != 0;
  } else {
    real ambient = s.ambient * weight;
    term.behind = false;
    if (s.occlusionRays > 0) {
      term.toward = occlusionDirection(surface.normal, pixel, sampleIndex, f.frame, toUint(q - f.lights),
                                       toUint(s.occlusionRays));
      term.behind = dot3(surface.geometric, term.toward) < R(0.0);
      ambient = (term.behind ? ambient * (R(1.0) - opacity) : ambient) / toReal(s.occlusionRays);
    }
    term.r = units(ambient * color.x);
    term.g = units(ambient * color.y);
    term.b = units(ambient * color.z);
    term.wanted = s.occlusionRays > 0 && (term.r | term.g | term.b) != 0;
    term.reach = s.occlusionRadius;
  }
  return term;
}

// Limits a term when the ones before have added r, g and b. What a pixel cannot hold is not added, so that
// nothing can take it away.
FN void limitLightTerm(INOUT(LightTerm) term, int r, int g, int b) {
  int most = units(MOST_LIGHT);
  term.r = min(term.r, most - r);
  term.g = min(term.g, most - g);
  term.b = min(term.b, most - b);
  term.wanted = term.wanted && (term.r | term.g | term.b) != 0;
}

// The part of a term that a secondary ray with opacity A takes away. If less than tMin passes, it takes all,
// as if it had met an opaque surface, because whether there is one behind may be known or not, depending on
// the partitions.
FN int lossOf(int term, real A, real tMin) {
  int part = toInt(toReal(term) * A);
  int loss = min(part, term);
  return R(1.0) - A < tMin || A == R(1.0) ? term : loss;
}

// The opacity behind a surface.
FN real opacityBehind(real A, real opacity) {
  return opacity >= R(1.0) ? R(1.0) : A + (R(1.0) - A) * opacity;
}
