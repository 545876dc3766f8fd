// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/seeds_filter.h"

#include <algorithm>

#include "core/analysis/made_geometry.h"
#include "core/comm/error.h"

namespace gxy {
namespace {

constexpr const char* kShapes[] = {"grid", "line", "points"};
constexpr int kMostSeeds = 1 << 30;
constexpr size_t kMostPoints = 100000;  // that a document lists

void readShape(const Found& found, Seeds& seeds) {
  const auto it = std::find(std::begin(kShapes), std::end(kShapes), found.text());
  if (it == std::end(kShapes)) found.fail("grid, line or points");
  seeds.shape = Seeds::Shape(it - std::begin(kShapes));
}

void readBox(const Found& found, Seeds& seeds) {
  const std::vector<double> b = found.numbers(6, 6, "[x0, x1, y0, y1, z0, z1]");
  for (int a = 0; a < 3; a++)
    if (!(b[size_t(2 * a)] <= b[size_t(2 * a + 1)]))
      found.fail("[x0, x1, y0, y1, z0, z1] with x0 <= x1, y0 <= y1 and z0 <= z1");
  seeds.box = Box{{b[0], b[2], b[4]}, {b[1], b[3], b[5]}};
}

OrderedJson writeBox(const Seeds& seeds) {
  if (!seeds.box) return nullptr;
  const auto& [lo, hi] = *seeds.box;
  return {lo.x, hi.x, lo.y, hi.y, lo.z, hi.z};
}

void readDimensions(const Found& found, Seeds& seeds) {
  const auto list = found.list("three whole numbers");
  if (list.size() != 3) found.fail("three whole numbers");
  int64_t all = 1;
  for (size_t a = 0; a < 3; a++) {
    seeds.dimensions[a] = list[a].integer({1, 1 << 20});
    all *= seeds.dimensions[a];
    if (all > kMostSeeds) found.fail("at most 2^30 points");
  }
}

void readPoints(const Found& found, Seeds& seeds) {
  for (const Found& item : found.list("a list of [x, y, z]")) {
    if (seeds.points.size() == kMostPoints) item.fail("at most 100000 points");
    seeds.points.push_back(item.vec3());
  }
}

OrderedJson writePoints(const Seeds& seeds) {
  OrderedJson out = nullptr;
  for (const glm::dvec3& p : seeds.points) out.push_back(toJson(p));
  return out;
}

KeyRow<Seeds> placeKey(std::string name, std::optional<glm::dvec3> Seeds::*member, std::string meaning) {
  return customKey<Seeds>(
      std::move(name), "[x, y, z]", std::move(meaning),
      [=](const Found& found, Seeds& seeds) { seeds.*member = found.vec3(); },
      [=](const Seeds& seeds) { return seeds.*member ? toJson(*(seeds.*member)) : OrderedJson(); });
}

}  // namespace

FilterInfo Seeds::info() {
  return {"Seeds",
          1,
          "Points in a plain shape, where lines begin or values are taken.",
          {{"domain", kVolumes | kParticles | kPathLines | kTriangles,
            "Where points of the shape are if the entry does not say it. The points get its partitioning."}},
          DatasetType::Particles};
}

std::vector<KeyRow<Seeds>> Seeds::properties() {
  return {
      customKey<Seeds>("shape", "grid, line or points",
                       "`grid`: the middles of the cells of a lattice. `line`: points at equal distances, "
                       "with both ends. `points`: a list.",
                       readShape, [](const Seeds& s) { return OrderedJson(kShapes[size_t(s.shape)]); }),
      customKey<Seeds>("box", "[x0, x1, y0, y1, z0, z1]", "The box of `grid`.", readBox, writeBox)
          .byDefault("the box of `domain`"),
      customKey<Seeds>("dimensions", "[i, j, k], whole numbers > 0",
                       "The number of points of `grid` along each axis.", readDimensions,
                       [](const Seeds& s) { return OrderedJson(s.dimensions); }),
      placeKey("from", &Seeds::from, "The first point of `line`.").byDefault("the lower corner of the box"),
      placeKey("to", &Seeds::to, "The last point of `line`.").byDefault("the upper corner of the box"),
      integerKey("count", &Seeds::count, {1, kMostSeeds}, "The number of points of `line`."),
      customKey<Seeds>("points", "list of [x, y, z]", "The points of `points`.", readPoints, writePoints)
          .byDefault("none"),
  };
}

uint64_t Seeds::number() const {
  switch (shape) {
    case Shape::Grid:
      return uint64_t(dimensions[0]) * uint64_t(dimensions[1]) * uint64_t(dimensions[2]);
    case Shape::Points:
      return points.size();
    default:
      return uint64_t(count);
  }
}

glm::dvec3 Seeds::point(uint64_t i, const Box& domain) const {
  const Box& in = box ? *box : domain;
  switch (shape) {
    case Shape::Grid: {
      const uint64_t nx = uint64_t(dimensions[0]), ny = uint64_t(dimensions[1]);
      const glm::dvec3 cell(double(i % nx), double(i / nx % ny), double(i / nx / ny));
      const glm::dvec3 n(dimensions[0], dimensions[1], dimensions[2]);
      return in.lo + (cell + 0.5) / n * (in.hi - in.lo);
    }
    case Shape::Line: {
      const glm::dvec3 first = from.value_or(domain.lo), last = to.value_or(domain.hi);
      return count == 1 ? first : first + double(i) / double(count - 1) * (last - first);
    }
    case Shape::Points:
      break;
  }
  return points[size_t(i)];
}

FilterResult Seeds::run(FilterRun& run) const {
  const Dataset& domain = *run.input("domain").data;
  GeometryBlock block;
  LedgerEntry memory;
  run.begin(0, 1, "seeds");
  agree(run.ranks, [&] {
    if (shape == Shape::Points && points.empty())
      throw Error("Seeds: there are no `points`, expected one or more of them, or another `shape`");
    if (shape != Shape::Points && !box && domain.box().empty())
      throw Error("Seeds: " + inQuotes(run.input("domain").name) +
                  " is empty, expected a box to put points in");
    const uint64_t all = number(), ranks = uint64_t(run.ranks.size()), rank = uint64_t(run.ranks.rank());
    const uint64_t first = all * rank / ranks, end = all * (rank + 1) / ranks;
    memory =
        run.takeMemory("geometry", int64_t(end - first) * int64_t(sizeof(glm::dvec3) + sizeof(uint64_t)));
    block.points.reserve(end - first);
    block.ids.reserve(end - first);
    const Advance advance = advanceOf(run.ranks);
    for (uint64_t i = first; i < end; i++) {
      tell(advance, i - first, end - first);
      block.points.push_back(point(i, domain.box()));
      block.ids.push_back(i);
    }
  });
  FilterResult result;
  result.dataset = madeGeometry(run, "seeds", GeometryKind::Particles, std::move(block), domain.partitioning,
                                std::move(memory));
  result.told = {{"particles", result.dataset->geometry->primitives}};
  return result;
}

}  // namespace gxy
