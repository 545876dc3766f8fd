// SPDX-License-Identifier: Apache-2.0
// Vector fields on meshes of cells, and lines through them.
#pragma once
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/analysis/mesh_fields.h"
#include "core/comm/random.h"
#include "tests/analysis/traces.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/data_sets.h"
#include "tests/support/meshes.h"

namespace gxy::test {

inline Box unitBox() { return {{0, 0, 0}, {1, 1, 1}}; }

/// The cells with the field's vectors at their points, or a number.
template <class Field>
MeshPiece withField(MeshPiece piece, int components, Field&& field) {
  piece.components = components;
  piece.values.clear();
  for (const glm::dvec3& p : piece.points) {
    const glm::dvec3 v(field(p));
    for (int a = 0; a < components; a++) piece.values.push_back(float(v[a]));
  }
  return piece;
}

inline double noValue(glm::dvec3) { return 0; }
inline glm::dvec3 noMove(glm::dvec3) { return glm::dvec3(0); }

/// Moves points inside the unit cube by up to `size`, so that faces of four corners are bent, onto multiples of 2^-12.
inline auto bentBy(double size) {
  return [size](glm::dvec3 p) {
    const double in = 64 * p.x * (1 - p.x) * p.y * (1 - p.y) * p.z * (1 - p.z);
    return glm::round(4096.0 * size * std::min(1.0, 2 * in) *
                      glm::dvec3(std::sin(40 * p.y), std::cos(31 * p.z), std::sin(27 * p.x))) /
           4096.0;
  };
}

/// Meshes of the unit cube, each kind of cells by itself and all together. The sides of cubes are 1/8 at least.
struct NamedMesh {
  std::string name;
  MeshPiece piece;
  double cell;  ///< the side of its cubes
};
template <class Move>
std::vector<NamedMesh> cubesOfCells(Move&& move) {
  return {{"tetrahedra", cubeOfTets(4, move, noValue), 0.25},
          {"hexahedra", cubeOfHexes(4, move, noValue), 0.25},
          {"wedges", cubeOfWedges(4, move, noValue), 0.25},
          {"pyramids", cubeOfPyramids(4, move, noValue), 0.25},
          {"all cells", cubeOfAllCells(4, move, noValue), 0.25}};
}

/// A field on a mesh, cut over ranks; beside it the scalar x y + z at the points, which is recorded.
template <class Field>
std::vector<RankFlow> meshFlowOnRanks(const MeshPiece& cells, Field&& field, const Cut& cut) {
  const auto partitioning = std::make_shared<const Partitioning>(cut.partitioning);
  const auto vectors = test::cut(WholeMesh{withField(cells, 3, field)}, cut.partitioning, cut.ranks);
  const auto scalar =
      test::cut(WholeMesh{withField(cells, 1, [](glm::dvec3 p) { return glm::dvec3(p.x * p.y + p.z); })},
                cut.partitioning, cut.ranks);
  std::vector<RankFlow> ranks;
  for (int r = 0; r < cut.ranks; r++) {
    const auto fields =
        std::make_shared<const MeshFields>(std::vector{vectors[size_t(r)], scalar[size_t(r)]}, partitioning);
    ranks.push_back({fields, fields});
  }
  return ranks;
}

/// A field on a mesh in one piece.
class MeshFlow {
 public:
  template <class Field>
  MeshFlow(const MeshPiece& cells, Field&& field, const Cut& cut = whole(unitBox()))
      : flow_(meshFlowOnRanks(cells, field, cut).at(0)) {}

  Lines trace(const std::vector<glm::dvec3>& seeds, const TraceOptions& options = {},
              TraceDirection direction = TraceDirection::Forward, int packet = 4096) const {
    return test::trace(*flow_.device, *flow_.fields, seeds, options, direction, packet);
  }

 private:
  RankFlow flow_;
};

/// Places in a box, a little off its sides.
inline std::vector<glm::dvec3> placesIn(glm::dvec3 lo, glm::dvec3 hi, int n, uint64_t seed) {
  Random random(seed);
  std::vector<glm::dvec3> places;
  for (int i = 0; i < n; i++) {
    glm::dvec3 p;
    for (int a = 0; a < 3; a++)
      p[a] = lo[a] + (hi[a] - lo[a]) * (0.5 + double(random.below(1 << 20))) / double(1 << 20);
    places.push_back(p);
  }
  return places;
}

/// All bits of what became of lines.
inline std::string bitsOf(const Lines& lines) {
  const PathPoints& p = lines.points;
  std::string all = bytesIn(p.line) + bytesIn(p.number) + bytesIn(p.position) + bytesIn(p.time) +
                    bytesIn(p.length) + bytesIn(p.speed);
  for (const auto& values : p.values) all += bytesIn(values);
  for (const LineEnd& e : lines.ends) {
    const double numbers[] = {double(e.line), double(e.backward), double(e.reason), double(e.points), e.time,
                              e.length,       e.position.x,       e.position.y,     e.position.z};
    all.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
  }
  return all;
}

}  // namespace gxy::test
