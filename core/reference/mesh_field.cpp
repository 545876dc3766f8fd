// SPDX-License-Identifier: Apache-2.0
#include "core/reference/mesh_field.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <numeric>
#include <set>
#include <string>
#include <tuple>

#include "core/comm/error.h"

namespace gxy::reference {
namespace {

/// a d - b c to within two ulps of the result, so that its sign is that of the exact number (Jeannerod, Louvet and Muller 2013, after
/// Kahan).
double determinant(double a, double b, double c, double d) {
  const double product = b * c;
  return std::fma(a, d, -product) - std::fma(b, c, -product);
}

/// Points at the same place get the same number.
std::vector<uint32_t> numberedByPlace(const std::vector<glm::dvec3>& points) {
  std::vector<uint32_t> order(points.size()), numbers(points.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](uint32_t i) { return std::tie(points[i].x, points[i].y, points[i].z); };
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return place(a) < place(b); });
  for (size_t k = 0; k < order.size(); k++)
    numbers[order[k]] = k > 0 && place(order[k - 1]) == place(order[k]) ? numbers[order[k - 1]] : order[k];
  return numbers;
}

/// The box of a cell, widened beyond the rounding errors with which rays are compared with it.
Box boxAround(const std::array<uint32_t, 4>& cell, const std::vector<glm::dvec3>& points) {
  Box box;
  for (const uint32_t corner : cell) box.extend(points[corner]);
  const glm::dvec3 size = box.hi - box.lo, far = glm::max(glm::abs(box.lo), glm::abs(box.hi));
  const double slack = 1e-9 * std::max({size.x, size.y, size.z}) + 0x1p-50 * std::max({far.x, far.y, far.z});
  return {box.lo - slack, box.hi + slack};
}

double trueValue(const Mesh& mesh, const MeshBlock& block, size_t point, std::optional<int> component) {
  const float* stored = &block.values[point * size_t(mesh.components)];
  const auto part = [&](int c) { return mesh.shift + mesh.scale * double(stored[c]); };
  if (component) return part(*component);
  if (mesh.components == 1) return part(0);
  double squares = 0;
  for (int c = 0; c < mesh.components; c++) squares += part(c) * part(c);
  return std::sqrt(squares);
}

}  // namespace

MeshField::MeshField(const Mesh& mesh, std::optional<int> component)
    : box_(mesh.box), typicalLength_(gxy::typicalLength(mesh)) {
  if (component && (*component < 0 || *component >= mesh.components)) {
    throw Error("reference: mesh '" + mesh.name + "' has no component " + std::to_string(*component) +
                ": expected 0 to " + std::to_string(mesh.components - 1));
  }
  std::vector<Cell> cells;
  for (const auto& [partition, block] : mesh.blocks) {
    const auto& corners = block.cells.points[size_t(CellType::Tetrahedron)];
    if (block.cells.size() * 4 != corners.size())
      throw Error("reference: mesh '" + mesh.name + "' has cells that are no tetrahedra");
    if (block.values.size() < block.points.size() * size_t(mesh.components))
      throw Error("reference: mesh '" + mesh.name + "' has fewer values than points");
    const auto first = uint32_t(points_.size());
    points_.insert(points_.end(), block.points.begin(), block.points.end());
    for (size_t i = 0; i < block.points.size(); i++) values_.push_back(trueValue(mesh, block, i, component));
    for (size_t i = 0; i < corners.size(); i += 4)
      cells.push_back(
          {first + corners[i], first + corners[i + 1], first + corners[i + 2], first + corners[i + 3]});
  }
  const std::vector<uint32_t> numbers =
      mesh.blocks.size() > 1 ? numberedByPlace(points_) : std::vector<uint32_t>();
  std::set<Cell> seen;
  std::vector<Box> boxes;
  for (Cell cell : cells) {
    if (!numbers.empty()) {
      for (uint32_t& corner : cell) corner = numbers[corner];
      Cell sorted = cell;
      std::sort(sorted.begin(), sorted.end());
      if (!seen.insert(sorted).second) continue;
    }
    if (!std::all_of(cell.begin(), cell.end(), [&](uint32_t p) { return std::isfinite(values_[p]); }))
      continue;
    boxes.push_back(boxAround(cell, points_));
    cells_.push_back(cell);
  }
  tree_.emplace(boxes);
}

std::vector<MeshSpan> MeshField::along(const Ray& ray, Interval range) const {
  std::vector<MeshSpan> spans;
  tree_->traverse(
      ray, range.lo, [&] { return range.hi; },
      [&](uint32_t cell) {
        const auto span = across(cells_[cell], ray);
        if (span && span->t1 > range.lo && span->t0 < range.hi) spans.push_back(*span);
      });
  std::sort(spans.begin(), spans.end(), [](const MeshSpan& a, const MeshSpan& b) {
    return std::tie(a.t0, a.t1, a.value0, a.value1) < std::tie(b.t0, b.t1, b.value0, b.value1);
  });
  return spans;
}

/// The corners are sheared so that the ray becomes the axis on which it is longest. Each face that the axis goes through gives an end:
/// with the exact signs of the edges these are two or none.
std::optional<MeshSpan> MeshField::across(const Cell& cell, const Ray& ray) const {
  const glm::dvec3 d = ray.direction;
  int z = std::abs(d.x) >= std::abs(d.y) ? 0 : 1;
  if (std::abs(d.z) > std::abs(d[z])) z = 2;
  const int x = (z + 1) % 3, y = (z + 2) % 3;
  const double sx = d[x] / d[z], sy = d[y] / d[z];
  std::array<double, 4> px, py, t;
  for (size_t i = 0; i < 4; i++) {
    const glm::dvec3 p = points_[cell[i]] - ray.origin;
    px[i] = p[x] - sx * p[z];
    py[i] = p[y] - sy * p[z];
    t[i] = p[z] / d[z];
  }
  std::array<std::array<double, 4>, 4> edge{}, side{};
  for (size_t i = 0; i < 4; i++) {
    for (size_t j = i + 1; j < 4; j++) {
      const double e = determinant(px[i], py[i], px[j], py[j]);
      // A ray that meets an edge counts as one beside it: a little to x, and less to y.
      const double s = e != 0 ? e : py[i] != py[j] ? py[i] - py[j] : px[j] - px[i];
      edge[i][j] = e, edge[j][i] = -e;
      side[i][j] = s, side[j][i] = -s;
    }
  }
  std::array<double, 2> ends{}, values{};
  size_t met = 0;
  for (size_t out = 0; out < 4; out++) {
    const size_t a = (out + 1) % 4, b = (out + 2) % 4, c = (out + 3) % 4;
    const bool above = side[a][b] > 0 && side[b][c] > 0 && side[c][a] > 0;
    const bool below = side[a][b] < 0 && side[b][c] < 0 && side[c][a] < 0;
    if (!above && !below) continue;
    const double sum = edge[a][b] + edge[b][c] + edge[c][a];
    if (sum == 0 || met == 2) return std::nullopt;
    // All three have the same sign, so nothing cancels even in a face that the ray meets nearly edge-on.
    const double wa = edge[b][c] / sum, wb = edge[c][a] / sum, wc = edge[a][b] / sum;
    ends[met] = wa * t[a] + wb * t[b] + wc * t[c];
    // Not beyond those of the corners, as rounding may put it.
    const double va = values_[cell[a]], vb = values_[cell[b]], vc = values_[cell[c]];
    values[met] = std::clamp(wa * va + wb * vb + wc * vc, std::min({va, vb, vc}), std::max({va, vb, vc}));
    met++;
  }
  if (met < 2 || ends[0] == ends[1]) return std::nullopt;
  const size_t near = ends[0] < ends[1] ? 0 : 1, far = 1 - near;
  return MeshSpan{ends[near], ends[far], values[near], values[far]};
}

}  // namespace gxy::reference
