// SPDX-License-Identifier: Apache-2.0
#define BOOST_ALLOW_DEPRECATED_HEADERS  // Boost.Geometry includes one

#include "core/analysis/mesh_reader.h"

#include <algorithm>
#include <array>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/iterator/function_output_iterator.hpp>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <span>
#include <vector>

namespace gxy {
namespace {

namespace bg = boost::geometry;

using TreePoint = bg::model::point<float, 3, bg::cs::cartesian>;
using TreeBox = bg::model::box<TreePoint>;
using CellBox = std::pair<TreeBox, uint32_t>;
using CellTree = bg::index::rtree<CellBox, bg::index::quadratic<16>>;

float roundedDown(double x) {
  const auto f = float(x);
  return double(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float roundedUp(double x) { return -roundedDown(-x); }

/// The box of a cell, a little larger, as a point may be outside of its cell by a rounding.
TreeBox boxOf(const MeshBlock& block, uint32_t cell) {
  glm::dvec3 lo(std::numeric_limits<double>::infinity()), hi = -lo;
  for (const uint32_t p : block.cells.pointsOf(cell)) {
    lo = glm::min(lo, block.points[p]);
    hi = glm::max(hi, block.points[p]);
  }
  const glm::dvec3 more = 1e-9 * (hi - lo);
  lo -= more, hi += more;
  return {{roundedDown(lo.x), roundedDown(lo.y), roundedDown(lo.z)},
          {roundedUp(hi.x), roundedUp(hi.y), roundedUp(hi.z)}};
}

TreeBox boxAround(glm::dvec3 world, double margin) {
  const glm::dvec3 lo = world - margin, hi = world + margin;
  return {{roundedDown(lo.x), roundedDown(lo.y), roundedDown(lo.z)},
          {roundedUp(hi.x), roundedUp(hi.y), roundedUp(hi.z)}};
}

/// What valueAt() is at the corners of a place's cell; nothing if it is NaN.
std::optional<reference::OfCorners> valuesAtCorners(const Mesh& mesh, const MeshPlace& place, int component) {
  const std::span<const uint32_t> points = place.block->cells.pointsOf(place.cell);
  const auto n = size_t(mesh.components);
  reference::OfCorners corners{};
  double finite = 0;
  if (!place.block->cellValues.empty())
    for (size_t c = 0; c < n; c++) {
      const float own = place.block->cellValues[place.cell * n + c];
      finite += double(own - own);
    }
  for (size_t k = 0; k < points.size(); k++) {
    const auto valueOf = [&](size_t c) {
      return mesh.shift + mesh.scale * double(place.block->values[points[k] * n + c]);
    };
    if (component >= 0) {
      corners[k] = valueOf(size_t(component));
    } else {
      double squares = 0;
      for (size_t c = 0; c < n; c++) squares += valueOf(c) * valueOf(c);
      corners[k] = std::sqrt(squares);
    }
    finite += corners[k] - corners[k];
  }
  return finite == 0 ? std::optional(corners) : std::nullopt;
}

}  // namespace

bool isInBox(const Box& box, glm::dvec3 p) {
  for (int a = 0; a < 3; a++) {
    const double margin = 1e-9 * (box.hi[a] - box.lo[a]);
    if (!(p[a] >= box.lo[a] - margin && p[a] <= box.hi[a] + margin)) return false;
  }
  return true;
}

CellCorners::CellCorners(const MeshBlock& block, uint32_t cell) : type_(block.cells.typeOf(cell)) {
  const std::span<const uint32_t> numbers = block.cells.pointsOf(cell);
  for (size_t k = 0; k < numbers.size(); k++) points_[k] = block.points[numbers[k]];
}

std::optional<glm::dvec3> CellCorners::placeOf(glm::dvec3 world, double slack) const {
  const size_t n = points().size();
  glm::dvec3 middle(0);
  for (size_t k = 0; k < n; k++) middle += reference::placeOfCorner(type_, k);
  const auto inverse = reference::invert(type_, points(), world, middle / double(n), slack);
  return inverse ? std::optional(inverse->place) : std::nullopt;
}

class MeshReader::Tree {
 public:
  Tree(const MeshBlock& block, const std::function<void()>& check)
      : block_(block), tree_(boxesOf(block, check)) {}

  std::optional<MeshPlace> place(glm::dvec3 world) const {
    for (const uint32_t cell : cellsNear(world, 0)) {
      const CellCorners corners(block_, cell);
      if (const auto place = corners.placeOf(world))
        return MeshPlace{&block_, cell, reference::shapeAt(corners.type(), *place), *place};
    }
    return std::nullopt;
  }

  std::vector<uint32_t> cellsNear(glm::dvec3 world, double margin) const {
    std::vector<uint32_t> cells;
    tree_.query(
        bg::index::intersects(boxAround(world, margin)),
        boost::make_function_output_iterator([&](const CellBox& found) { cells.push_back(found.second); }));
    std::sort(cells.begin(), cells.end());
    return cells;
  }

 private:
  static std::vector<CellBox> boxesOf(const MeshBlock& block, const std::function<void()>& check) {
    std::vector<CellBox> boxes;
    boxes.reserve(block.cells.size());
    for (uint32_t cell = 0; cell < block.cells.size(); cell++) {
      if (cell % 65536 == 0) check();
      boxes.emplace_back(boxOf(block, cell), cell);
    }
    return boxes;
  }

  const MeshBlock& block_;
  const CellTree tree_;
};

MeshReader::MeshReader(const Mesh& mesh, const std::function<void()>& check) {
  for (const auto& [partition, block] : mesh.blocks)
    trees_.emplace(partition, std::make_unique<const Tree>(block, check));
}

MeshReader::~MeshReader() = default;

int64_t MeshReader::bytesFor(const Mesh& mesh) {
  // The boxes of the cells, once more while the tree is built, and nodes of 16 boxes that are at least a third full.
  constexpr int64_t kBytesOfCell = 3 * sizeof(CellBox);
  int64_t bytes = 0;
  for (const auto& [partition, block] : mesh.blocks) bytes += int64_t(block.cells.size()) * kBytesOfCell;
  return bytes;
}

std::optional<MeshPlace> MeshReader::place(int partition, glm::dvec3 world) const {
  const auto tree = trees_.find(partition);
  return tree == trees_.end() ? std::nullopt : tree->second->place(world);
}

std::vector<uint32_t> MeshReader::cellsNear(int partition, glm::dvec3 world, double margin) const {
  const auto tree = trees_.find(partition);
  return tree == trees_.end() ? std::vector<uint32_t>() : tree->second->cellsNear(world, margin);
}

double valueAt(const Mesh& mesh, const MeshPlace& place, int component) {
  const auto corners = valuesAtCorners(mesh, place, component);
  if (!corners) return std::numeric_limits<double>::quiet_NaN();
  const size_t n = place.block->cells.pointsOf(place.cell).size();
  const auto [least, most] = std::minmax_element(corners->begin(), corners->begin() + std::ptrdiff_t(n));
  return std::clamp(place.shape.mean(*corners), *least, *most);
}

glm::dvec3 gradientAt(const Mesh& mesh, const MeshPlace& place, int component) {
  const auto corners = valuesAtCorners(mesh, place, component);
  const reference::Jacobian jacobian(place.shape, CellCorners(*place.block, place.cell).points());
  if (!corners || !jacobian.isRegular()) return glm::dvec3(std::numeric_limits<double>::quiet_NaN());
  return jacobian.inSpace(reference::derivativesOf(place.shape, *corners));
}

}  // namespace gxy
