// SPDX-License-Identifier: Apache-2.0
// Fields and grids on which lines have gone wrong elsewhere.
#pragma once
#include <string>
#include <vector>

#include "tests/kernels/random.h"
#include "tests/lines/flow_fields.h"

namespace gxy::test {

struct StressFlow {
  std::string name;
  Grid grid;
  FlowFunction flow;
  double length = 60;  ///< of the grid's spacings along x
};

/// Zeros, critical points, kinks, jumps, constant directions, holes, extreme scales and grids.
inline std::vector<StressFlow> stressFlows() {
  using V = glm::dvec3;
  std::vector<StressFlow> all;
  for (const int64_t n : {8, 9}) {  // critical points within cells, and on nodes
    const Grid g = gridOver(V(-1), V(1), {n, n, n});
    const auto add = [&](const char* name, const FlowFunction& f) {
      all.push_back({name + std::to_string(n), g, f});
    };
    add("zero", [](V) { return V(0); });
    add("saddle", [](V p) { return V(p.x, -p.y, 0); });
    add("turned saddle", [](V p) { return V(p.x, p.z, p.y); });
    add("centre", [](V p) { return V(-p.y, p.x, 0); });
    add("sink", [](V p) { return -p; });
    add("spiral sink", [](V p) { return V(-p.y - 0.1 * p.x, p.x - 0.1 * p.y, -0.1 * p.z); });
    add("limit cycle", [](V p) {
      const double q = p.x * p.x + p.y * p.y - 0.3;
      return V(-p.y - p.x * q, p.x - p.y * q, 0);
    });
    add("along an edge", [](V) { return V(1, 0, 0); });
    add("along a face", [](V) { return V(1, -1, 0); });
    add("along a diagonal", [](V) { return V(1, 1, 1); });
    add("zero on a plane", [](V p) { return V(p.x, 1, 0); });
    add("towards a plane", [](V p) { return V(-p.x, 1, 0.3); });
    add("towards an edge", [](V p) {
      return V(p.x > 0 ? -1 : p.x < 0 ? 1 : 0, p.y > 0 ? -1 : p.y < 0 ? 1 : 0, 1);
    });
    add("towards a kink", [](V p) { return V(p.x > 0.1 ? -1 : 1, 1, 0); });
    add("head on", [](V p) { return V(p.x > 0 ? -1 : 1, 0, 0); });
    add("kinks round a node", [](V p) { return V(p.y > 0 ? 1 : -1, p.x > 0 ? -1 : 1, 0); });
    add("1e30", [](V p) { return 1e30 * V(-p.y, p.x, 0.1); });
    add("1e-30", [](V p) { return 1e-30 * V(-p.y, p.x, 0.1); });
    add("3e38", [](V p) { return 3e38 * V(-p.y, p.x, 0.1); });
    add("denormal", [](V p) { return 1e-40 * V(-p.y, p.x, 0.1); });
    add("nearly nothing", [](V p) { return V(1e-19 * p.y, 1e-25, 1e-10); });
    add("of 1e-25 to 1", [](V p) { return V(p.x > 0 ? 1 : 1e-25, 1e-12, p.x > 0 ? 0 : 1e-24); });
    add("hole", [](V p) { return V(1, std::abs(p.x - 0.25) < 0.2 && p.y > 0 ? double(NAN) : 0.2, 0.1); });
    add("infinity", [](V p) { return V(1, std::abs(p.x - 0.25) < 0.2 ? double(INFINITY) : 0.2, 0.1); });
    add("nothing but NaN", [](V) { return V(NAN); });
    add("waves", [](V p) { return abcFlow(3.0 * p); });
  }
  const auto on = [&](const char* name, V half, V centre, Index3 n) {
    all.push_back({name, gridOver(centre - half, centre + half, n),
                   [=](V p) { return half * abcFlow(3.0 * (p - centre) / half); }});
  };
  on("2x2x2", V(1), V(0), {2, 2, 2});
  on("2x2x40", V(1), V(0), {2, 2, 40});
  on("3x2x2", V(1), V(0), {3, 2, 2});
  on("1:1e4:1", V(1, 1e4, 1), V(0), {9, 9, 9});
  on("offset", V(1), V(1e6), {9, 9, 9});
  on("1e-30 small", V(1e-30), V(0), {9, 9, 9});
  on("1e30 large", V(1e30), V(0), {9, 9, 9});
  const V flat(1, 1e4, 1);
  all.push_back({"1:1e4:1 of one speed", gridOver(-flat, flat, {9, 9, 9}),
                 [=](V p) { return abcFlow(3.0 * p / flat); }});
  return all;
}

/// Seeds at random places, on nodes, edges and faces, and at the domain's ends.
inline std::vector<glm::dvec3> stressSeeds(const Grid& grid, int n, uint64_t seed) {
  Random random(seed);
  std::vector<glm::dvec3> seeds;
  for (int i = 0; i < n; i++) {
    glm::dvec3 p;
    for (int a = 0; a < 3; a++) {
      const int last = int(grid.points[size_t(a)]) - 1;
      const double x = i % 16 & (1 << a) ? random.below(last + 1) : random.in(0, last);
      p[a] = grid.origin[a] + grid.spacing[a] * (i % 16 == 8 ? last * random.below(2) : x);
    }
    seeds.push_back(p);
  }
  return seeds;
}

}  // namespace gxy::test
