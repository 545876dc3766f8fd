// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <numbers>

#include "core/scene/colormaps.h"

namespace gxy {
namespace {

// sRGB (IEC 61966-2-1) to CIE XYZ with the D65 white point, in the four digits that VTK uses.
constexpr double kWhiteX = 0.9505, kWhiteY = 1.0, kWhiteZ = 1.089;

double linearized(double c) { return c > 0.04045 ? std::pow((c + 0.055) / 1.055, 2.4) : c / 12.92; }
double companded(double c) { return c > 0.0031308 ? 1.055 * std::pow(c, 1 / 2.4) - 0.055 : 12.92 * c; }
double labCurve(double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; }
double labCurveInverse(double f) { return f * f * f > 0.008856 ? f * f * f : (f - 16.0 / 116) / 7.787; }

glm::dvec3 rgbToLab(const glm::dvec3& rgb) {
  const double r = linearized(rgb.r), g = linearized(rgb.g), b = linearized(rgb.b);
  const double x = labCurve((r * 0.4124 + g * 0.3576 + b * 0.1805) / kWhiteX);
  const double y = labCurve((r * 0.2126 + g * 0.7152 + b * 0.0722) / kWhiteY);
  const double z = labCurve((r * 0.0193 + g * 0.1192 + b * 0.9505) / kWhiteZ);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

glm::dvec3 labToRgb(const glm::dvec3& lab) {
  const double fy = (lab.x + 16) / 116;
  const double x = kWhiteX * labCurveInverse(lab.y / 500 + fy);
  const double y = kWhiteY * labCurveInverse(fy);
  const double z = kWhiteZ * labCurveInverse(fy - lab.z / 200);
  const glm::dvec3 rgb{companded(x * 3.2406 + y * -1.5372 + z * -0.4986),
                       companded(x * -0.9689 + y * 1.8758 + z * 0.0415),
                       companded(x * 0.0557 + y * -0.2040 + z * 1.0570)};
  const double largest = std::max({rgb.r, rgb.g, rgb.b, 1.0});  // A colour that is too bright keeps its hue.
  return glm::max(rgb / largest, glm::dvec3(0));
}

/// Lab in polar coordinates: magnitude, saturation (angle from the L axis), hue.
struct Msh {
  double m, s, h;
};

Msh rgbToMsh(const glm::dvec3& rgb) {
  const glm::dvec3 lab = rgbToLab(rgb);
  const double m = std::sqrt(lab.x * lab.x + lab.y * lab.y + lab.z * lab.z);
  const double s = m > 0.001 ? std::acos(lab.x / m) : 0;
  return {m, s, s > 0.001 ? std::atan2(lab.z, lab.y) : 0};
}

glm::dvec3 mshToRgb(const Msh& c) {
  return labToRgb(
      {c.m * std::cos(c.s), c.m * std::sin(c.s) * std::cos(c.h), c.m * std::sin(c.s) * std::sin(c.h)});
}

double hueDistance(double a, double b) {
  const double d = std::abs(a - b);
  return d > std::numbers::pi ? 2 * std::numbers::pi - d : d;
}

/// Returns the hue for an unsaturated end colour, so that the way to `saturated` does not pass through other hues.
double adjustedHue(const Msh& saturated, double unsaturatedM) {
  if (saturated.m >= unsaturatedM - 0.1) return saturated.h;
  const double spin = saturated.s * std::sqrt(unsaturatedM * unsaturatedM - saturated.m * saturated.m) /
                      (saturated.m * std::sin(saturated.s));
  return saturated.h > -0.3 * std::numbers::pi ? saturated.h + spin : saturated.h - spin;
}

glm::dvec3 interpolateDiverging(const glm::dvec3& from, const glm::dvec3& to, double fraction) {
  constexpr double kSaturated = 0.05;
  Msh a = rgbToMsh(from), b = rgbToMsh(to);
  if (a.s > kSaturated && b.s > kSaturated && hueDistance(a.h, b.h) > 0.33 * std::numbers::pi) {
    const double whiteM = std::max({a.m, b.m, 88.0});  // Hues that differ this much meet in white.
    if (fraction < 0.5) {
      b = {whiteM, 0, 0};
      fraction = 2 * fraction;
    } else {
      a = {whiteM, 0, 0};
      fraction = 2 * fraction - 1;
    }
  }
  if (a.s < kSaturated && b.s > kSaturated) a.h = adjustedHue(b, a.m);
  if (b.s < kSaturated && a.s > kSaturated) b.h = adjustedHue(a, b.m);
  const auto mix = [&](double x, double y) { return (1 - fraction) * x + fraction * y; };
  return mshToRgb({mix(a.m, b.m), mix(a.s, b.s), mix(a.h, b.h)});
}

glm::dvec3 rgbToHsv(const glm::dvec3& c) {
  const double hi = std::max({c.r, c.g, c.b}), lo = std::min({c.r, c.g, c.b}), chroma = hi - lo;
  if (chroma <= 0) return {0, 0, hi};
  double hue = c.r == hi   ? (c.g - c.b) / chroma
               : c.g == hi ? 2 + (c.b - c.r) / chroma
                           : 4 + (c.r - c.g) / chroma;
  if (hue < 0) hue += 6;
  return {hue / 6, chroma / hi, hi};
}

glm::dvec3 hsvToRgb(const glm::dvec3& hsv) {
  const auto channel = [&](double n) {
    const double k = std::fmod(n + hsv.x * 6, 6.0);
    return hsv.z - hsv.z * hsv.y * std::clamp(std::min(k, 4 - k), 0.0, 1.0);
  };
  return {channel(5), channel(3), channel(1)};
}

glm::dvec3 interpolateHsv(const glm::dvec3& from, const glm::dvec3& to, double fraction, bool wrapHue) {
  glm::dvec3 a = rgbToHsv(from), b = rgbToHsv(to);
  if (wrapHue && std::abs(a.x - b.x) > 0.5) (a.x > b.x ? a.x : b.x) -= 1;
  glm::dvec3 hsv = a * (1 - fraction) + b * fraction;
  if (hsv.x < 0) hsv.x += 1;
  return hsvToRgb(hsv);
}

}  // namespace

glm::dvec3 interpolate(const glm::dvec3& from, const glm::dvec3& to, double fraction, ColorSpace space,
                       bool wrapHue) {
  switch (space) {
    case ColorSpace::RGB:
      return from * (1 - fraction) + to * fraction;
    case ColorSpace::HSV:
      return interpolateHsv(from, to, fraction, wrapHue);
    case ColorSpace::Lab:
      return labToRgb(rgbToLab(from) * (1 - fraction) + rgbToLab(to) * fraction);
    case ColorSpace::Diverging:
      return interpolateDiverging(from, to, fraction);
    case ColorSpace::Step:
      return fraction > 0 ? to : from;
  }
  return from;
}

}  // namespace gxy
