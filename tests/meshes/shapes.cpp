// SPDX-License-Identifier: Apache-2.0
#include "tests/meshes/shapes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "core/comm/random.h"
#include "tests/support/meshes.h"

namespace gxy::test {

namespace {

constexpr size_t kTets = size_t(CellType::Tetrahedron);

double unit(Random& random) { return double(random.next() >> 11) * 0x1p-53; }

glm::dvec3 centreOf(const MeshPiece& piece, const uint32_t* corners) {
  glm::dvec3 sum(0);
  for (int k = 0; k < 4; k++) sum += piece.points[corners[k]];
  return sum * 0.25;
}

}  // namespace

MeshPiece cubeMesh(uint32_t n, double far, const Field& field, uint64_t seed) {
  Random random(seed);
  const auto move = [&](glm::dvec3 p) {
    glm::dvec3 step(0);
    for (int a = 0; a < 3; a++) {
      const double r = 2 * unit(random) - 1;
      if (p[a] > 0 && p[a] < 1) step[a] = r * far / n;
    }
    return step;
  };
  MeshPiece piece = cubeOfTets(n, move, [](glm::dvec3) { return 0.0; });
  for (size_t i = 0; i < piece.points.size(); i++) {
    piece.points[i] = 2.0 * piece.points[i] - 1.0;
    piece.values[i] = float(field(piece.points[i]));
  }
  return piece;
}

MeshPiece graded(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z,
                 const Field& field) {
  const auto n = uint32_t(x.size() - 1), m = n + 1;
  MeshPiece piece = cubeMesh(n, 0, [](glm::dvec3) { return 0.0; });
  for (uint32_t i = 0; i < m * m * m; i++) {
    piece.points[i] = {x[i % m], y[i / m % m], z[i / (m * m)]};
    piece.values[i] = float(field(piece.points[i]));
  }
  return piece;
}

MeshPiece oneCell() {
  MeshPiece piece;
  piece.points = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  piece.values = {0, 1 / 3.f, 2 / 3.f, 1};
  piece.numbers = {0, 1, 2, 3};
  piece.cells.points[kTets] = {0, 1, 2, 3};
  return piece;
}

MeshPiece kept(MeshPiece piece, const std::function<bool(glm::dvec3)>& keep) {
  auto& cells = piece.cells.points[kTets];
  std::vector<uint32_t> left;
  for (size_t i = 0; i < cells.size(); i += 4)
    if (keep(centreOf(piece, &cells[i]))) left.insert(left.end(), &cells[i], &cells[i] + 4);
  cells = std::move(left);
  return piece;
}

MeshPiece withHoleAt(MeshPiece piece, glm::dvec3 place) {
  auto& cells = piece.cells.points[kTets];
  size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < cells.size(); i += 4) {
    const double d = glm::distance(centreOf(piece, &cells[i]), place);
    if (d < least) least = d, nearest = i;
  }
  cells.erase(cells.begin() + ptrdiff_t(nearest), cells.begin() + ptrdiff_t(nearest + 4));
  return piece;
}

MeshPiece invertedHere(MeshPiece piece, uint64_t seed) {
  Random random(seed);
  auto& cells = piece.cells.points[kTets];
  for (size_t i = 0; i < cells.size(); i += 4)
    if (random.oneIn(2)) std::swap(cells[i + random.below(2)], cells[i + 2]);
  return piece;
}

MeshPiece placed(MeshPiece piece, const std::function<glm::dvec3(glm::dvec3)>& move) {
  for (glm::dvec3& p : piece.points) p = move(p);
  return piece;
}

MeshPiece together(MeshPiece a, const MeshPiece& b) {
  const auto before = uint32_t(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  a.values.insert(a.values.end(), b.values.begin(), b.values.end());
  for (const uint64_t number : b.numbers) a.numbers.push_back(before + number);
  for (const uint32_t corner : b.cells.points[kTets]) a.cells.points[kTets].push_back(before + corner);
  return a;
}

MeshPiece withGaps(MeshPiece piece, const std::function<bool(glm::dvec3)>& none) {
  for (size_t i = 0; i < piece.points.size(); i++)
    if (none(piece.points[i]))
      piece.values[i] =
          i % 2 ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
  return piece;
}

MeshPiece withFlatCells(MeshPiece piece, size_t count, uint64_t seed) {
  Random random(seed);
  auto& cells = piece.cells.points[kTets];
  const size_t whole = cells.size() / 4;
  for (size_t k = 0; k < count; k++) {
    const uint32_t* c = &cells[4 * random.below(whole)];
    const std::array<uint32_t, 3> face{c[0], c[1], c[2]};
    piece.points.push_back(0.5 * (piece.points[face[0]] + piece.points[face[1]]));
    piece.values.push_back(0.5f * (piece.values[face[0]] + piece.values[face[1]]));
    piece.numbers.push_back(piece.numbers.size());
    cells.insert(cells.end(), {face[0], face[1], face[2], uint32_t(piece.points.size() - 1)});
  }
  return piece;
}

MeshPiece comb(uint32_t teeth, const Field& field) {
  const uint32_t n = 2 * teeth - 1;
  return kept(cubeMesh(n, 0, field), [n](glm::dvec3 c) {
    const auto layer = int((c.x + 1) * n / 2);
    return layer % 2 == 0 || c.y < -1 + 2.0 / n;
  });
}

MeshPiece nestedShells(uint32_t n, const Field& field) {
  return kept(cubeMesh(n, 0.15, field), [](glm::dvec3 c) {
    const double r = glm::length(c);
    return r < 0.25 || (r > 0.45 && r < 0.65) || (r > 0.8 && r < 1);
  });
}

MeshPiece slivers(uint32_t n, const Field& field) {
  std::vector<double> planes;
  for (uint32_t i = 0; i <= n; i++) planes.push_back(-1 + 2.0 * i / n);
  planes.push_back(planes[n / 2] + 2e-6 / n);
  std::sort(planes.begin(), planes.end());
  return graded(planes, planes, planes, field);
}

MeshPiece shrinking(uint32_t n, const Field& field) {
  std::vector<double> planes{-1};
  for (uint32_t i = 0; i < n; i++) planes.push_back(-1 + 2 * std::pow(1e-6, double(n - 1 - i) / (n - 1)));
  return graded(planes, planes, planes, field);
}

}  // namespace gxy::test
