// SPDX-License-Identifier: Apache-2.0
#include "insitu/catalyst/blueprint.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "insitu/catalyst/blueprint_cells.h"

namespace gxy::catalyst {

namespace {

constexpr int64_t kMostPoints = int64_t(1) << 31;  // by axis
const std::array<std::string, 3> kI{"i", "j", "k"}, kX{"x", "y", "z"};

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

// Values that are an array, or an array for each of the components.
Values valuesAt(const Node& node, const std::string& name, const std::vector<Node>& children) {
  Values values{node.path(), name, false, {}};
  for (const Node& child : children) values.components.push_back(child.array());
  if (children.empty()) values.components.push_back(node.array());
  for (const Array& c : values.components)
    if (c.type != values.components[0].type || c.count != values.components[0].count)
      fail(node.path(), "expected components of one type and length");
  return values;
}

// Coordinates by their names, in whatever order they stand.
std::vector<Node> axesAt(const Node& node) {
  std::vector<Node> axes;
  for (const std::string& axis : kX)
    if (const auto child = node.find(axis)) axes.push_back(*child);
  if (axes.size() != 3 || node.children().size() != 3) fail(node.path(), "expected x, y and z");
  return axes;
}

Values positionsAt(const Node& node) { return valuesAt(node, "positions", axesAt(node)); }

// Those of the planes of a lattice, which has another number of them along each axis.
Values planesAt(const Node& node) {
  Values values{node.path(), "positions", false, {}};
  for (const Node& axis : axesAt(node)) values.components.push_back(axis.array());
  return values;
}

// Points or cells of a block; -1: too many for an integer.
int64_t countOf(const Index& points, bool ofElements) {
  int64_t count = 1;
  for (size_t a = 0; a < 3; a++)
    if (__builtin_mul_overflow(count, ofElements ? cells(points, a) : points[a], &count)) return -1;
  return count;
}

void checkCount(const Values& values, int64_t count) {
  if (values.components[0].count != count)
    fail(values.path, "found " + std::to_string(values.components[0].count) + " values, expected " +
                          std::to_string(count) + ", one for each of the " +
                          (values.ofElements ? "elements" : "points"));
}

bool isGhosts(const std::string& name, const std::string& ghosts) {
  return ghosts.empty() ? name == "ascent_ghosts" || name == kGhosts : name == ghosts;
}

// The fields on a topology, ghosts too.
std::vector<Values> fieldsOf(const Node& mesh, const std::string& topology, const Warn& warn) {
  std::vector<Values> fields;
  const auto all = mesh.find("fields");
  if (!all) return fields;
  for (const Node& field : all->children()) {
    const bool ofMaterials = field.find("matset") && !field.find("topology");
    if (!ofMaterials && field.at("topology").text() != topology) continue;
    const auto leaveOut = [&](const std::string& why) { warn(field.path() + ": " + why + ", left out"); };
    if (field.find("basis")) {
      leaveOut("a grid function of finite elements");
    } else if (ofMaterials || !field.find("values")) {
      leaveOut("a field of materials");
    } else {
      Values values = valuesAt(field.at("values"), field.name(), field.at("values").children());
      const std::string association = field.at("association").text();
      if (association != "vertex" && association != "element")
        fail(field.path() + "/association",
             "found \"" + association + "\", expected \"vertex\" or \"element\"");
      values.ofElements = association == "element";
      fields.push_back(std::move(values));
    }
  }
  return fields;
}

GridBlock gridOf(const Node& coordset, const Node& topology) {
  GridBlock block;
  block.path = topology.path();
  const auto origin = coordset.find("origin"), spacing = coordset.find("spacing");
  for (size_t a = 0; a < 3; a++) {
    const std::string dim = "dims/" + kI[a];
    block.points[a] = a == 2 ? coordset.integerOr(dim, 1) : coordset.at(dim).integer();
    if (block.points[a] < 0 || block.points[a] > kMostPoints)
      fail(coordset.path() + "/" + dim, "expected 0 to 2^31 points");
    block.origin[a] = origin ? origin->numberOr(kX[a], 0) : 0;
    block.spacing[a] = spacing ? spacing->numberOr("d" + kX[a], 1) : 1;
  }
  for (size_t a = 0; a < 3 && countOf(block.points, false) != 0; a++)
    if (!std::isfinite(block.origin[a]) || !(block.spacing[a] > 0) || !std::isfinite(block.spacing[a]))
      fail(coordset.path(), "expected a finite origin and a positive spacing");
  if (origin && !origin->children().empty() && !origin->find("x"))
    fail(origin->path(), "expected x, y and z: other coordinates are not taken");
  if (const auto index = topology.find("elements/origin")) {
    block.index = Index{};
    for (size_t a = 0; a < 3; a++) (*block.index)[a] = index->integerOr(kI[a] + "0", 0);
  }
  if (countOf(block.points, false) < 0) fail(coordset.path() + "/dims", "too many points");
  return block;
}

void addGrid(GridBlock block, std::vector<Values> fields, const std::string& ghosts,
             std::vector<GridBlock>& grids) {
  for (Values& values : fields) {
    checkCount(values, countOf(block.points, values.ofElements));
    if (isGhosts(values.name, ghosts))
      block.ghosts = std::move(values);
    else
      block.fields.push_back(std::move(values));
  }
  grids.push_back(std::move(block));
}

// Where fields are those of elements, ghosts serve them at the rank's border. Else they are not even sent.
void takeGhosts(Points& points, const Values& ghosts) {
  std::shared_ptr<const void> made;
  Values bits = ghostBits(ghosts, made);
  if (std::none_of(points.fields.begin(), points.fields.end(),
                   [](const Values& v) { return v.ofElements; })) {
    points.cells = withoutGhosts(*points.cells, bits);
    return;
  }
  points.fields.push_back(std::move(bits));
  points.cells->made.push_back(std::move(made));
}

void addPoints(Points points, std::vector<Values> fields, const std::string& ghosts, const Warn& warn,
               std::vector<Points>& all) {
  if (std::any_of(all.begin(), all.end(), [&](const Points& p) { return p.mesh == points.mesh; }))
    return warn(points.path + ": " + (points.cells ? "cells" : "points") +
                " of a second domain, expected one on each rank, left out");
  const bool isVolume = points.cells && points.cells->isVolume;
  std::optional<Values> ghostsOfCells;
  for (Values& values : fields) {
    const auto leaveOut = [&](const std::string& why) { warn(values.path + ": " + why); };
    checkCount(values, points.cells && values.ofElements ? points.cells->count
                                                         : points.positions.components[0].count);
    if (isGhosts(values.name, ghosts)) {
      if (!isVolume || !values.ofElements)
        leaveOut("ghosts of " + std::string(points.cells ? "cells" : "points") +
                 " are not known as such, and shown");
      else
        ghostsOfCells = std::move(values);
    } else {
      points.fields.push_back(std::move(values));
    }
  }
  if (isVolume && points.fields.empty())
    return warn(points.path + ": elements with a volume without a field, left out");
  if (ghostsOfCells) takeGhosts(points, *ghostsOfCells);
  all.push_back(std::move(points));
}

// The points along each axis of a structured topology; nothing, and a warning, if they are not taken.
std::optional<Index> structuredPoints(const Node& topology, const Warn& warn) {
  const Node dims = topology.at("elements/dims");
  if (!dims.find("k") || dims.find("strides") || dims.find("offsets")) {
    warn(topology.path() +
         ": a structured topology of two dimensions, or with strides, is not taken so far, left out");
    return {};
  }
  Index points{};
  for (size_t a = 0; a < 3; a++) {
    const int64_t n = dims.at(kI[a]).integer();
    if (n < 0 || n >= kMostPoints) fail(dims.path() + "/" + kI[a], "expected 0 to 2^31 elements");
    points[a] = n + 1;
  }
  return points;
}

void checkLattice(const std::string& path, const Index& points) {
  const int64_t count = countOf(points, false);
  if (count < 0 || count >= int64_t(UINT32_MAX)) fail(path, "expected at most 2^32 - 2 points");
}

// Points and cells of a topology; nothing, and a warning, if it is not taken.
std::optional<Points> pointsOf(const Node& topology, const Node& coordset, const Warn& warn,
                               Lattices& lattices) {
  const std::string type = topology.at("type").text(), coordinates = coordset.at("type").text();
  Points points{topology.path(), {}, {}, {}, {}};
  if (type == "points" && coordinates == "explicit") {
    points.positions = positionsAt(coordset.at("values"));
  } else if (type == "unstructured" && coordinates == "explicit") {
    points.cells = unstructuredCells(topology, warn);
    if (!points.cells) return {};
    points.positions = positionsAt(coordset.at("values"));
  } else if (type == "structured" && coordinates == "explicit") {
    points.positions = positionsAt(coordset.at("values"));
    auto size = structuredPoints(topology, warn);
    if (!size) return {};
    const int64_t count = points.positions.components[0].count;
    if (count == 0) size = Index{};  // This rank has none.
    checkLattice(topology.path(), *size);
    if (countOf(*size, false) != count)
      fail(coordset.path() + "/values", "found " + std::to_string(count) + " points, expected " +
                                            std::to_string(countOf(*size, false)) +
                                            ", those of the elements");
    points.cells = latticeCells(*size, lattices);
  } else if (type == "rectilinear" && coordinates == "rectilinear") {
    const Values planes = planesAt(coordset.at("values"));
    Index size{};
    for (size_t a = 0; a < 3; a++) size[a] = planes.components[a].count;
    checkLattice(coordset.path(), size);
    points.positions = latticePositions(planes, lattices, points.made);
    points.cells = latticeCells(size, lattices);
  } else {
    warn(topology.path() + ": type \"" + type + "\" on coordinates of type \"" + coordinates +
         "\" is not taken so far, left out");
    return {};
  }
  return points;
}

}  // namespace

int64_t cells(const Index& points, size_t axis) {
  return axis == 2 && points[2] == 1 ? 1 : std::max(points[axis] - 1, int64_t(0));
}

Box ownedOf(const GridBlock& block) {
  const Index& points = block.points;
  if (!block.ghosts) return {{}, points, false};
  const Values& ghosts = *block.ghosts;
  const Array& array = ghosts.components[0];
  Index all = points, least = points, end{};
  if (ghosts.ofElements)
    for (size_t a = 0; a < 3; a++) all[a] = cells(points, a);
  int64_t zeros = 0;
  const std::byte* at = array.data;
  for (int64_t n = 0; n < array.count; n++, at += array.stride) {
    if (std::any_of(at, at + bytesOf(array.type), [](std::byte b) { return b != std::byte(0); })) continue;
    const Index i{n % all[0], n / all[0] % all[1], n / all[0] / all[1]};
    for (size_t a = 0; a < 3; a++) least[a] = std::min(least[a], i[a]), end[a] = std::max(end[a], i[a] + 1);
    zeros++;
  }
  Box owned{{}, {}, !ghosts.ofElements};
  if (zeros == 0) return owned;
  owned.first = least;
  for (size_t a = 0; a < 3; a++) owned.count[a] = end[a] - least[a];
  if (zeros != owned.count[0] * owned.count[1] * owned.count[2])
    fail(ghosts.path,
         "the " + std::to_string(zeros) + " values that are 0, for what is no ghost, are not a box");
  if (ghosts.ofElements)
    for (size_t a = 0; a < 3; a++)
      if (points[a] > 1) owned.count[a]++;
  return owned;
}

std::vector<Node> domainsOf(const Node& data) {
  auto all = data.children();
  const auto isMesh = [](const Node& node) { return node.find("topologies").has_value(); };
  if (!all.empty() && std::none_of(all.begin(), all.end(), isMesh)) return {data};
  std::erase_if(all, [](const Node& domain) { return domain.children().empty(); });
  return all;
}

void addMeshes(const Node& mesh, const std::string& name, const std::string& pointsName,
               const std::string& ghosts, const Warn& warn, Meshes& meshes) {
  if (mesh.find("matsets")) warn(mesh.path() + "/matsets: materials are not taken, left out");
  const auto topologies = mesh.at("topologies").children();
  for (const Node& topology : topologies) {
    const std::string type = topology.at("type").text();
    const Node coordset = mesh.at("coordsets/" + topology.at("coordset").text());
    const std::string coordinates = coordset.at("type").text();
    const std::string suffix = topologies.size() == 1 ? "" : "." + topology.name();
    if (type == "uniform" && coordinates == "uniform") {
      GridBlock block = gridOf(coordset, topology);
      block.mesh = name + suffix;
      addGrid(std::move(block), fieldsOf(mesh, topology.name(), warn), ghosts, meshes.grids);
    } else if (auto points = pointsOf(topology, coordset, warn, meshes.lattices)) {
      points->mesh = pointsName + suffix;
      addPoints(*std::move(points), fieldsOf(mesh, topology.name(), warn), ghosts, warn, meshes.points);
    }
  }
}

}  // namespace gxy::catalyst
