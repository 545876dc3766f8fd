// SPDX-License-Identifier: Apache-2.0
#include "core/reference/streamline.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace gxy::reference {

namespace {

bool isInside(glm::dvec3 f) { return f.x >= 0 && f.x <= 1 && f.y >= 0 && f.y <= 1 && f.z >= 0 && f.z <= 1; }

}  // namespace

Streamlines::Streamlines(std::shared_ptr<const Volume> volume, int steps, bool backward)
    : components_{Field(volume, 0), Field(volume, 1), Field(volume, 2)},
      steps_(steps),
      sign_(backward ? -1 : 1) {}

StreamlinePlace Streamlines::start(glm::dvec3 world) const {
  const Grid& g = components_[0].grid();
  StreamlinePlace place;
  for (int a = 0; a < 3; a++) {
    const double x = (world[a] - g.origin[a]) / g.spacing[a];
    place.cell[size_t(a)] = std::clamp<int64_t>(int64_t(std::floor(x)), 0, g.points[size_t(a)] - 2);
    place.fraction[a] = x - double(place.cell[size_t(a)]);
  }
  return place;
}

glm::dvec3 Streamlines::world(const StreamlinePlace& p) const {
  const Grid& g = components_[0].grid();
  return g.origin + g.spacing * (glm::dvec3(p.cell[0], p.cell[1], p.cell[2]) + p.fraction);
}

std::optional<Streamlines::Corners> Streamlines::corners(const Index3& cell) const {
  Corners all;
  for (size_t a = 0; a < 3; a++) {
    const auto c = components_[a].corners(cell);
    if (!c) return std::nullopt;
    all[a] = *c;
  }
  return all;
}

glm::dvec3 Streamlines::cellVelocity(const Corners& c, glm::dvec3 f) const {
  const glm::dvec3 v(trilinear(c[0], f), trilinear(c[1], f), trilinear(c[2], f));
  return sign_ * v / components_[0].grid().spacing;
}

glm::dvec3 Streamlines::velocity(const StreamlinePlace& place) const {
  const auto c = corners(place.cell);
  return c ? cellVelocity(*c, place.fraction) * components_[0].grid().spacing : glm::dvec3(NAN);
}

Streamlines::State Streamlines::step(const Corners& c, const State& s, double h) const {
  const glm::dvec3 spacing = components_[0].grid().spacing;
  const glm::dvec3 a = cellVelocity(c, s.f), b = cellVelocity(c, s.f + h / 2 * a);
  const glm::dvec3 d = cellVelocity(c, s.f + h / 2 * b), e = cellVelocity(c, s.f + h * d);
  const auto speed = [&](glm::dvec3 v) { return glm::length(v * spacing); };
  return {s.f + h / 6 * (a + 2.0 * (b + d) + e),
          s.length + h / 6 * (speed(a) + 2 * (speed(b) + speed(d)) + speed(e))};
}

Streamlines::End Streamlines::leave(StreamlinePlace& place, int axis, bool up) const {
  const int64_t next = place.cell[size_t(axis)] + (up ? 1 : -1);
  place.fraction[axis] = up ? 1 : 0;
  if (next < 0 || next >= components_[0].grid().cells()[size_t(axis)]) return End::Left;
  place.cell[size_t(axis)] = next;
  place.fraction[axis] = up ? 0 : 1;
  return End::None;
}

Streamlines::End Streamlines::crossCell(StreamlinePlace& place, double time) const {
  const auto c = corners(place.cell);
  if (!c) return End::NoData;
  const double until = place.time + time;
  for (;;) {
    const glm::dvec3 v = cellVelocity(*c, place.fraction);
    for (int a = 0; a < 3; a++)
      if ((place.fraction[a] == 1 && v[a] > 0) || (place.fraction[a] == 0 && v[a] < 0))
        return leave(place, a, v[a] > 0);
    const double fastest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (fastest < 1e-300) return End::Zero;
    const State from{place.fraction, place.length};
    double h = std::min(1 / (steps_ * fastest), until - place.time);
    State to = step(*c, from, h);
    const bool leaves = !isInside(to.f);
    int axis = -1;
    bool up = false;
    if (leaves) {
      double inside = 0, outside = h;
      for (int k = 0; k < 60; k++) {
        const double middle = (inside + outside) / 2;
        (isInside(step(*c, from, middle).f) ? inside : outside) = middle;
      }
      h = outside;
      to = step(*c, from, h);
      for (int a = 0; a < 3; a++)
        if (to.f[a] > 1 || to.f[a] < 0) axis = a, up = to.f[a] > 1;
    }
    place.fraction = glm::clamp(to.f, 0.0, 1.0);
    place.length = to.length;
    place.time += h;
    if (leaves && axis >= 0) return leave(place, axis, up);
    if (place.time >= until) return End::Time;
  }
}

Streamlines::End Streamlines::follow(StreamlinePlace& place, double time, int64_t cells) const {
  const double until = place.time + time;
  for (int64_t k = 0; k < cells; k++) {
    const End end = crossCell(place, until - place.time);
    if (end != End::None) return end;
    if (place.time >= until) return End::Time;
  }
  return End::None;
}

}  // namespace gxy::reference
