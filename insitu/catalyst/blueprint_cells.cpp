// SPDX-License-Identifier: Apache-2.0
#include "insitu/catalyst/blueprint_cells.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <stdexcept>
#include <type_traits>

#include "insitu/api/galaxy_insitu.h"

namespace gxy::catalyst {

namespace {

constexpr uint8_t kDuplicate = 1, kRefined = 8, kHidden = 32;  // bits of vtkGhostType
constexpr const char* kShapes = "\"line\", \"tri\", \"quad\", \"tet\", \"hex\", \"wedge\" or \"pyramid\"";

struct Shape {
  const char* name;
  uint8_t type, points;
  bool isVolume;
};
// The points of all of them are in VTK's order.
constexpr Shape kTaken[] = {{"line", GXY_LINE, 2, false},     {"tri", GXY_TRIANGLE, 3, false},
                            {"quad", GXY_QUAD, 4, false},     {"tet", GXY_TETRAHEDRON, 4, true},
                            {"hex", GXY_HEXAHEDRON, 8, true}, {"wedge", GXY_WEDGE, 6, true},
                            {"pyramid", GXY_PYRAMID, 5, true}};

const Shape* shapeNamed(const std::string& name) {
  const auto* found =
      std::find_if(std::begin(kTaken), std::end(kTaken), [&](const Shape& s) { return name == s.name; });
  return found == std::end(kTaken) ? nullptr : found;
}

const Shape* shapeOfType(uint8_t type) {
  return std::find_if(std::begin(kTaken), std::end(kTaken), [&](const Shape& s) { return type == s.type; });
}

[[noreturn]] void failAt(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

template <class T>
int64_t integerAt(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return int64_t(value);
}

// By gxy_type, from GXY_INT8 to GXY_UINT64.
constexpr int64_t (*kReaders[])(const std::byte*) = {
    integerAt<int8_t>,  integerAt<uint8_t>,  integerAt<int16_t>, integerAt<uint16_t>,
    integerAt<int32_t>, integerAt<uint32_t>, integerAt<int64_t>, integerAt<uint64_t>};

// The integers of an array, of any type.
std::vector<int64_t> integersOf(const Node& node) {
  const Array array = node.array();
  if (array.type < GXY_INT8 || array.type > GXY_UINT64) failAt(node.path(), "expected integers");
  std::vector<int64_t> integers(static_cast<size_t>(array.count));
  for (size_t i = 0; i < integers.size(); i++)
    integers[i] = kReaders[array.type](array.data + int64_t(i) * array.stride);
  return integers;
}

std::vector<double> coordinatesOf(const Array& array, const std::string& path) {
  std::vector<double> all(static_cast<size_t>(array.count));
  for (size_t i = 0; i < all.size(); i++) {
    const std::byte* at = array.data + int64_t(i) * array.stride;
    float single = 0;
    if (array.type == GXY_FLOAT64)
      std::memcpy(&all[i], at, sizeof(double));
    else if (array.type == GXY_FLOAT32)
      std::memcpy(&single, at, sizeof single), all[i] = double(single);
    else
      failAt(path, "expected coordinates that are float32 or float64");
  }
  return all;
}

template <class T>
Array arrayOf(const std::vector<T>& values) {
  constexpr int kType = std::is_same_v<T, uint8_t>    ? GXY_UINT8
                        : std::is_same_v<T, uint32_t> ? GXY_UINT32
                        : std::is_same_v<T, int64_t>  ? GXY_INT64
                                                      : GXY_FLOAT64;
  return {reinterpret_cast<const std::byte*>(values.data()), kType, int64_t(values.size()), sizeof(T)};
}

// Arrays that are made of the simulation's.
struct MadeCells {
  std::vector<uint8_t> types;
  std::vector<int64_t> offsets{0};
};

Cells cellsOfOneShape(const Node& topology, const Shape& shape) {
  const Node connectivity = topology.at("elements/connectivity");
  Cells cells;
  cells.type = shape.type;
  cells.isVolume = shape.isVolume;
  cells.connectivity = connectivity.array();
  cells.count = cells.connectivity.count / shape.points;
  if (cells.count * shape.points != cells.connectivity.count)
    failAt(connectivity.path(), "found " + std::to_string(cells.connectivity.count) + " points, expected " +
                                    std::to_string(shape.points) + " for each of the elements");
  return cells;
}

// The shapes by their numbers; nothing, and a warning, if one is not taken.
std::optional<std::map<int64_t, const Shape*>> shapeMapOf(const Node& topology, const Warn& warn) {
  std::map<int64_t, const Shape*> shapes;
  for (const Node& one : topology.at("elements/shape_map").children()) {
    const Shape* shape = shapeNamed(one.name());
    if (!shape) {
      warn(topology.path() + ": elements of shape \"" + one.name() + "\" are not taken so far, expected " +
           kShapes + ", left out");
      return {};
    }
    shapes[one.integer()] = shape;
  }
  return shapes;
}

std::optional<Cells> mixedCells(const Node& topology, const Warn& warn) {
  const auto shapes = shapeMapOf(topology, warn);
  if (!shapes) return {};
  const Node shapesNode = topology.at("elements/shapes");
  const std::vector<int64_t> each = integersOf(shapesNode);
  const auto offsets = topology.find("elements/offsets");
  const std::vector<int64_t> begins = offsets ? integersOf(*offsets) : std::vector<int64_t>();
  if (offsets && begins.size() != each.size())
    failAt(offsets->path(), "found " + std::to_string(begins.size()) + " numbers, expected " +
                                std::to_string(each.size()) + ", one for each of the elements");
  auto made = std::make_shared<MadeCells>();
  Cells cells;
  cells.count = int64_t(each.size());
  for (size_t c = 0; c < each.size(); c++) {
    const auto shape = shapes->find(each[c]);
    if (shape == shapes->end())
      failAt(shapesNode.path(), "element " + std::to_string(c) + " is of " + std::to_string(each[c]) +
                                    ", expected one of the numbers in shape_map");
    if (offsets && begins[c] != made->offsets.back())
      failAt(offsets->path(), "element " + std::to_string(c) + " begins at " + std::to_string(begins[c]) +
                                  ", expected " + std::to_string(made->offsets.back()) +
                                  ", where the one before ends");
    made->types.push_back(shape->second->type);
    made->offsets.push_back(made->offsets.back() + shape->second->points);
    cells.isVolume = cells.isVolume || shape->second->isVolume;
  }
  if (each.empty())
    for (const auto& [number, shape] : *shapes) cells.isVolume = cells.isVolume || shape->isVolume;
  const Node connectivity = topology.at("elements/connectivity");
  cells.connectivity = connectivity.array();
  if (cells.connectivity.count != made->offsets.back())
    failAt(connectivity.path(), "found " + std::to_string(cells.connectivity.count) + " points, expected " +
                                    std::to_string(made->offsets.back()) + ", those of all elements");
  cells.types = arrayOf(made->types);
  cells.offsets = arrayOf(made->offsets);
  cells.made = {std::move(made)};
  return cells;
}

}  // namespace

std::optional<Cells> unstructuredCells(const Node& topology, const Warn& warn) {
  const std::string name = topology.at("elements/shape").text();
  if (name == "mixed") return mixedCells(topology, warn);
  if (const Shape* shape = shapeNamed(name)) return cellsOfOneShape(topology, *shape);
  warn(topology.path() + ": elements of shape \"" + name + "\" are not taken so far, expected " + kShapes +
       ", or \"mixed\", left out");
  return {};
}

Cells latticeCells(const Index& points, Lattices& lattices) {
  std::shared_ptr<const std::vector<uint32_t>>& known = lattices.corners[points];
  Index n{};
  for (size_t a = 0; a < 3; a++) n[a] = std::max(points[a] - 1, int64_t(0));
  if (!known) {
    auto corners = std::make_shared<std::vector<uint32_t>>();
    corners->reserve(size_t(8 * n[0] * n[1] * n[2]));
    for (int64_t k = 0; k < n[2]; k++)
      for (int64_t j = 0; j < n[1]; j++)
        for (int64_t i = 0; i < n[0]; i++)
          for (const int64_t above : {0, 1})
            for (const int64_t corner : {0, 1, 2, 3}) {
              const int64_t x = corner == 1 || corner == 2, y = corner >= 2;
              corners->push_back(uint32_t(i + x + points[0] * (j + y + points[1] * (k + above))));
            }
    known = std::move(corners);
  }
  Cells cells;
  cells.type = GXY_HEXAHEDRON;
  cells.isVolume = true;
  cells.count = n[0] * n[1] * n[2];
  cells.connectivity = arrayOf(*known);
  cells.made = {known};
  return cells;
}

Values latticePositions(const Values& planes, Lattices& lattices, std::shared_ptr<const void>& made) {
  Lattices::Placed now;
  for (size_t a = 0; a < 3; a++) now.planes[a] = coordinatesOf(planes.components[a], planes.path);
  Lattices::Placed& known = lattices.placed[planes.path];
  if (!known.points || known.planes != now.planes) {
    auto points = std::make_shared<std::vector<double>>();
    points->reserve(3 * now.planes[0].size() * now.planes[1].size() * now.planes[2].size());
    for (const double z : now.planes[2])
      for (const double y : now.planes[1])
        for (const double x : now.planes[0]) points->insert(points->end(), {x, y, z});
    now.points = std::move(points);
    known = std::move(now);
  }
  Values values{planes.path, planes.name, false, {}};
  for (size_t a = 0; a < 3; a++)
    values.components.push_back(
        {known.points->empty() ? nullptr : reinterpret_cast<const std::byte*>(known.points->data() + a),
         GXY_FLOAT64, int64_t(known.points->size() / 3), 3 * sizeof(double)});
  made = known.points;
  return values;
}

void forgetUnused(Lattices& lattices) {
  std::erase_if(lattices.corners, [](const auto& one) { return one.second.use_count() == 1; });
  std::erase_if(lattices.placed, [](const auto& one) { return one.second.points.use_count() == 1; });
}

Values ghostBits(const Values& ghosts, std::shared_ptr<const void>& made) {
  const Array& array = ghosts.components[0];
  const bool isInteger = array.type >= GXY_INT8 && array.type <= GXY_UINT64, areBits = ghosts.name == kGhosts;
  auto bits = std::make_shared<std::vector<uint8_t>>();
  bits->reserve(size_t(array.count));
  for (int64_t c = 0; c < array.count; c++) {
    const std::byte* at = array.data + c * array.stride;
    int64_t value = 0;
    if (isInteger)
      value = kReaders[array.type](at);
    else if (std::any_of(at, at + bytesOf(array.type), [](std::byte b) { return b != std::byte(0); }))
      value = 1;  // Of a number with a fraction only this is known.
    bits->push_back(areBits ? uint8_t(value) : value == 0 ? 0 : value == 1 ? kDuplicate : kHidden);
  }
  made = bits;
  return {ghosts.path, kGhosts, true, {arrayOf(*bits)}};
}

Cells withoutGhosts(const Cells& cells, const Values& bits) {
  const Array& ghosts = bits.components[0];
  const auto isGhost = [&](int64_t c) {
    return (ghosts.data[c] & std::byte(kDuplicate | kRefined | kHidden)) != std::byte(0);
  };
  struct Kept {
    MadeCells cells;
    std::vector<std::byte> connectivity;
  };
  auto kept = std::make_shared<Kept>();
  const Array& corners = cells.connectivity;
  const size_t bytes = bytesOf(corners.type);
  int64_t begin = 0;
  for (int64_t c = 0; c < cells.count; c++) {
    uint8_t type = cells.type;
    if (type == 0) std::memcpy(&type, cells.types.data + c, 1);
    const int64_t points = shapeOfType(type)->points;
    if (!isGhost(c)) {
      kept->cells.types.push_back(type);
      kept->cells.offsets.push_back(kept->cells.offsets.back() + points);
      for (int64_t i = begin; i < begin + points; i++) {
        const std::byte* at = corners.data + i * corners.stride;
        kept->connectivity.insert(kept->connectivity.end(), at, at + bytes);
      }
    }
    begin += points;
  }
  Cells left;
  left.isVolume = cells.isVolume;
  left.count = int64_t(kept->cells.types.size());
  left.types = arrayOf(kept->cells.types);
  left.offsets = arrayOf(kept->cells.offsets);
  left.connectivity = {kept->connectivity.data(), corners.type, kept->cells.offsets.back(), int64_t(bytes)};
  left.made = {std::move(kept)};
  return left;
}

}  // namespace gxy::catalyst
