// SPDX-License-Identifier: Apache-2.0
// A small closed convex mesh: the icosahedron, its faces split twice, on a sphere (320 triangles, 162 vertices).
#pragma once
#include <array>
#include <glm/glm.hpp>
#include <map>
#include <utility>
#include <vector>

namespace gxy::test {

struct Mesh {
  std::vector<glm::dvec3> vertices;
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise from outside
};

inline Mesh split(const Mesh& mesh) {
  Mesh out{mesh.vertices, {}};
  std::map<std::pair<int, int>, int> middles;
  auto middle = [&](int a, int b) {
    auto [it, isNew] = middles.try_emplace(std::minmax(a, b), int(out.vertices.size()));
    if (isNew) out.vertices.push_back(glm::normalize(mesh.vertices[a] + mesh.vertices[b]));
    return it->second;
  };
  for (auto [a, b, c] : mesh.triangles) {
    int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (auto t :
         {std::array{a, ab, ca}, std::array{b, bc, ab}, std::array{c, ca, bc}, std::array{ab, bc, ca}})
      out.triangles.push_back(t);
  }
  return out;
}

inline Mesh icosphere() {
  const double g = 1.618033988749895;
  Mesh mesh{{{-1, g, 0},
             {1, g, 0},
             {-1, -g, 0},
             {1, -g, 0},
             {0, -1, g},
             {0, 1, g},
             {0, -1, -g},
             {0, 1, -g},
             {g, 0, -1},
             {g, 0, 1},
             {-g, 0, -1},
             {-g, 0, 1}},
            {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
             {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
             {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  for (glm::dvec3& v : mesh.vertices) v = glm::normalize(v);
  return split(split(mesh));
}

}  // namespace gxy::test
