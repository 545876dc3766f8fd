// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/seeds_filter.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "core/analysis/made_geometry.h"
#include "core/analysis/random_numbers.h"
#include "core/analysis/resample_filter.h"
#include "core/comm/error.h"

namespace gxy {
namespace {

constexpr const char* kShapes[] = {"grid", "line", "box", "sphere", "points"};
constexpr int kMostSeeds = 1 << 30;
constexpr size_t kMostListed = 100000;  // that a document lists

void readShape(const Found& found, Seeds& seeds) {
  const auto it = std::find(std::begin(kShapes), std::end(kShapes), found.text());
  if (it == std::end(kShapes)) found.fail("grid, line, box, sphere or points");
  seeds.shape = Seeds::Shape(it - std::begin(kShapes));
}

void readLattice(const Found& found, Seeds& seeds) {
  seeds.dimensions = readDimensions(found, 1);
  int64_t all = 1;
  for (const int n : seeds.dimensions)
    if ((all *= n) > kMostSeeds) found.fail("at most 2^30 points");
}

void readPoints(const Found& found, Seeds& seeds) {
  for (const Found& item : found.list("a list of [x, y, z]")) {
    if (seeds.points.size() == kMostListed) item.fail("at most 100000 points");
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
          {{"domain", kVolumes | kUnstructured | kParticles | kPathLines | kTriangles,
            "Where points of the shape are if the entry does not say it. The points get its partitioning."}},
          DatasetType::Particles};
}

std::vector<KeyRow<Seeds>> Seeds::properties() {
  return {
      customKey<Seeds>("shape", "grid, line, box, sphere or points",
                       "`grid`: the middles of the cells of a lattice. `line`: points at equal distances, "
                       "with both ends. `box` and `sphere`: "
                       "points that are spread evenly at random. `points`: a list.",
                       readShape, [](const Seeds& s) { return OrderedJson(kShapes[size_t(s.shape)]); }),
      customKey<Seeds>(
          "box", "[x0, x1, y0, y1, z0, z1]", "The box of `grid` and `box`.",
          [](const Found& f, Seeds& s) { s.box = readBox(f); },
          [](const Seeds& s) { return s.box ? toJson(*s.box) : OrderedJson(); })
          .byDefault("the box of `domain`"),
      customKey<Seeds>("dimensions", "[i, j, k], whole numbers > 0",
                       "The number of points of `grid` along each axis.", readLattice,
                       [](const Seeds& s) { return OrderedJson(s.dimensions); }),
      placeKey("from", &Seeds::from, "The first point of `line`.").byDefault("the lower corner of the box"),
      placeKey("to", &Seeds::to, "The last point of `line`.").byDefault("the upper corner of the box"),
      placeKey("center", &Seeds::center, "The middle of `sphere`.").byDefault("the middle of the box"),
      customKey<Seeds>(
          "radius", "number >= 0", "The radius of `sphere`.",
          [](const Found& f, Seeds& s) { s.radius = f.number(kNonNegative); },
          [](const Seeds& s) { return s.radius ? OrderedJson(*s.radius) : OrderedJson(); })
          .byDefault("a quarter of the shortest side of the box"),
      integerKey("count", &Seeds::count, {1, kMostSeeds},
                 "The number of points of `line`, `box` and `sphere`."),
      integerKey("seed", &Seeds::seed, {0, 2147483647},
                 "Other numbers make other points of `box` and `sphere`."),
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
      const uint64_t x = i % nx, y = i / nx % ny, z = i / nx / ny;
      const glm::dvec3 cell{double(x), double(y), double(z)};
      const glm::dvec3 n(dimensions[0], dimensions[1], dimensions[2]);
      return in.lo + (cell + 0.5) / n * (in.hi - in.lo);
    }
    case Shape::Line: {
      const glm::dvec3 first = from.value_or(domain.lo), last = to.value_or(domain.hi);
      return count == 1 ? first : first + double(i) / double(count - 1) * (last - first);
    }
    case Shape::Box: {
      const auto words = randomWords(uint32_t(seed), uint32_t(Draw::Seeds), i);
      const glm::dvec3 at(unitOf(words[0]), unitOf(words[1]), unitOf(words[2]));
      return in.lo + at * (in.hi - in.lo);
    }
    case Shape::Sphere: {
      const glm::dvec3 side = domain.hi - domain.lo;
      const double r = radius.value_or(std::min({side.x, side.y, side.z}) / 4);
      return center.value_or((domain.lo + domain.hi) / 2.0) + r * inUnitBall(i);
    }
    case Shape::Points:
      break;
  }
  return points[size_t(i)];
}

glm::dvec3 Seeds::inUnitBall(uint64_t i) const {
  for (uint32_t part = 0;; part++) {
    const auto words = randomWords(uint32_t(seed), uint32_t(Draw::Seeds), i, part);
    const glm::dvec3 p(2 * unitOf(words[0]) - 1, 2 * unitOf(words[1]) - 1, 2 * unitOf(words[2]) - 1);
    if (glm::dot(p, p) <= 1) return p;
  }
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
