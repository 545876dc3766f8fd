// SPDX-License-Identifier: Apache-2.0
// Derive and Number of unstructured volumes.
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "core/analysis/derive_filter.h"
#include "core/analysis/number_filter.h"
#include "tests/analysis/filter_setup.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

namespace gxy::test {
namespace {

using nlohmann::json;

const Box kDerivedBox{{0, 0, 0}, {1, 1, 1}};
glm::dvec3 bendOfDerived(glm::dvec3 p) { return 0.1 * glm::dvec3(p.y, p.z, p.x) * p * (1.0 - p); }

using DerivePlace = std::array<double, 3>;

/// What Derive makes, on all ranks together, by point or by the mean of a cell's corners.
struct MadeMesh {
  json told;
  std::string error;
  std::map<DerivePlace, std::vector<float>> values, averages;
  Mesh one;  ///< without blocks
};

template <class Filter>
MadeMesh madeOf(const std::map<std::string, WholeMesh>& inputs, const Cut& cut,
                const std::string& expression) {
  MadeMesh made;
  std::mutex mutex;
  ThreadRanks world(cut.ranks);
  const auto errors = world.run([&](Collectives& ranks) {
    FilterRun::Inputs sources;
    for (const auto& [name, whole] : inputs) {
      const auto mesh = std::make_shared<Dataset>();
      mesh->partitioning = std::make_shared<const Partitioning>(cut.partitioning);
      mesh->mesh = test::cut(whole, cut.partitioning, cut.ranks)[size_t(ranks.rank())];
      sources[name] = {{name, {}, 1, mesh}};
    }
    FilterRun run(ranks, sources, freeServices());
    const FilterResult result = evaluate(*makeFilter<Filter>(), run, json{{"expression", expression}}.dump());
    const std::lock_guard lock(mutex);
    made.told = result.told;
    if (!result.dataset) return;
    const Mesh& mesh = *result.dataset->mesh;
    made.one = mesh;
    made.one.blocks.clear();
    const auto take = [&](std::map<DerivePlace, std::vector<float>>& to, glm::dvec3 at, const float* from) {
      const std::vector<float> own(from, from + mesh.components);
      const auto [known, isNew] = to.try_emplace({at.x, at.y, at.z}, own);
      for (size_t c = 0; c < own.size() && !isNew; c++)
        EXPECT_TRUE(known->second[c] == own[c] || (std::isnan(own[c]) && std::isnan(known->second[c])));
    };
    for (const auto& [partition, block] : mesh.blocks) {
      const MeshBlock& like = sources.begin()->second[0].data->mesh->blocks.at(partition);
      EXPECT_TRUE(block.points.sharesWith(like.points) && block.shell.sharesWith(like.shell));
      for (uint32_t p = 0; p < block.points.size(); p++)
        take(mesh.ofCells ? made.averages : made.values, block.points[p],
             &block.values[p * size_t(mesh.components)]);
      for (uint32_t c = 0; c < block.cells.size() && mesh.ofCells; c++) {
        glm::dvec3 sum(0);
        for (const uint32_t p : block.cells.pointsOf(c)) sum += block.points[p];
        take(made.values, sum / double(block.cells.pointsOf(c).size()),
             &block.cellValues[c * size_t(mesh.components)]);
      }
    }
  });
  for (const std::string& error : errors)
    if (!error.empty()) made.error = error;
  return made;
}

std::map<std::string, WholeMesh> twoFields(bool ofCells) {
  const auto p = [](glm::dvec3 x) { return 2 + x.x + x.y * x.z; };
  const auto q = [](glm::dvec3 x) { return x.z > 0.6 ? double(NAN) : x.y - 0.3; };
  std::map<std::string, WholeMesh> both;
  both["p"].cells = cubeOfAllCells(4, bendOfDerived, p);
  both["q"].cells = cubeOfAllCells(4, bendOfDerived, q);
  if (ofCells) both["p"].cells = withCellValues(std::move(both["p"].cells), p);
  if (ofCells) both["q"].cells = withCellValues(std::move(both["q"].cells), q);
  return both;
}

TEST(MeshDerive, ComputesAtEachPointOrCellOnAnyPartitionsAndRanks) {
  for (const bool ofCells : {false, true}) {
    const MadeMesh one = madeOf<Derive>(twoFields(ofCells), whole(kDerivedBox), "[p * q, x, min(p, 2.5)]");
    ASSERT_EQ(one.error, "");
    const auto both = twoFields(ofCells);
    EXPECT_EQ(one.told.at("components"), 3);
    EXPECT_EQ(one.one.components, 3);
    EXPECT_EQ(one.one.ofCells, ofCells);
    size_t noData = 0;
    for (const auto& [at, v] : one.values) {
      const float p = float(2 + at[0] + at[1] * at[2]), q = float(at[1] - 0.3);
      if (at[2] > 0.6) {
        EXPECT_TRUE(std::isnan(v[0]));
        noData++;
        continue;
      }
      EXPECT_NEAR(v[0], p * q, 1e-6);
      EXPECT_EQ(v[1], float(at[0]));
      EXPECT_NEAR(v[2], std::min(p, 2.5f), 1e-6);
    }
    EXPECT_GT(noData, 0u);
    EXPECT_EQ(one.told.at("no data"), noData);
    EXPECT_EQ(ofCells ? one.one.report.noDataCells : one.one.report.noDataPoints, noData);
    const auto isSame = [](const auto& some, const auto& others) {
      return some.size() == others.size() &&
             std::equal(some.begin(), some.end(), others.begin(), [](const auto& a, const auto& b) {
               return a.first == b.first &&
                      std::equal(a.second.begin(), a.second.end(), b.second.begin(),
                                 [](float x, float y) { return x == y || (x != x && y != y); });
             });
    };
    for (const Cut& cut : manyCuts(kDerivedBox, 3)) {
      const MadeMesh other = madeOf<Derive>(both, cut, "[p * q, x, min(p, 2.5)]");
      EXPECT_EQ(other.error, "") << cut.name;
      EXPECT_EQ(other.told, one.told) << cut.name;
      EXPECT_EQ(other.one.ranges, one.one.ranges) << cut.name;
      EXPECT_TRUE(isSame(other.values, one.values)) << cut.name;
      EXPECT_TRUE(isSame(other.averages, one.averages)) << cut.name;
    }
  }
}

TEST(MeshDerive, OfCellsHasTheAveragesOfItsOwnValues) {
  std::map<std::string, WholeMesh> one, twice;
  const auto wavy = [](glm::dvec3 p) { return std::sin(5 * p.x) + p.y * p.z; };
  one["f"].cells = withCellValues(cubeOfHexes(4, bendOfDerived, wavy), wavy);
  twice = one;
  for (float& v : twice["f"].cells.cellValues[size_t(CellType::Hexahedron)]) v *= 2;
  const Cut cut = lattice(kDerivedBox, {2, 2, 1}, 3);
  const MadeMesh derived = madeOf<Derive>(one, cut, "2 * f"), same = madeOf<Derive>(twice, cut, "f");
  EXPECT_EQ(derived.values, same.values);
  EXPECT_EQ(derived.averages, same.averages);
  EXPECT_EQ(derived.averages.size(), 125u);
}

TEST(MeshDerive, ConditionsAreBytesAndQueriesCountEachPointOnce) {
  std::map<std::string, WholeMesh> one;
  one["f"].cells = cubeOfTets(
      4, [](glm::dvec3) { return glm::dvec3(0); }, [](glm::dvec3 p) { return 4 * p.x; });
  const std::map<std::string, json> expected{{"sum(f)", 250},         {"mean(f)", 2},
                                             {"max(f) - min(f)", 4},  {"quantile(f, 0.5)", 2},
                                             {"sum(2 * f + 1)", 625}, {"mean(if(f > 2, 1, 0))", 0.4},
                                             {"max(f) > 3", true},    {"max(z) == 1", true}};
  for (const Cut& cut : {whole(kDerivedBox), lattice(kDerivedBox, {2, 1, 3}, 2)})
    for (const auto& [expression, value] : expected) {
      const MadeMesh made = madeOf<NumberFilter>(one, cut, expression);
      ASSERT_EQ(made.error, "") << expression;
      EXPECT_EQ(made.told.at("value"), value) << expression;
    }
  const MadeMesh made = madeOf<Derive>(one, whole(kDerivedBox), "f > mean(f)");
  EXPECT_EQ(made.told, (json{{"range", {0, 1}}, {"no data", 0}, {"components", 1}}));
  for (const auto& [at, v] : made.values) EXPECT_EQ(v[0], at[0] > 0.5);
}

TEST(MeshDerive, OtherMeshesAndDifferentialsAreErrors) {
  std::map<std::string, WholeMesh> inputs = twoFields(false);
  EXPECT_NE(
      madeOf<Derive>(inputs, whole(kDerivedBox), "grad(p)").error.find("differentials need fields on a grid"),
      std::string::npos);
  EXPECT_NE(madeOf<Derive>(inputs, whole(kDerivedBox), "3").error.find("expected a field"),
            std::string::npos);
  const auto expectDifferent = [&](const char* expression) {
    for (const Cut& cut : {whole(kDerivedBox), lattice(kDerivedBox, {3, 1, 1}, 3)}) {
      const std::string error = madeOf<Derive>(inputs, cut, expression).error;
      EXPECT_NE(error.find("`p` and `q` are on different meshes"), std::string::npos) << error;
    }
  };
  inputs["q"] = twoFields(true)["q"];
  expectDifferent("p + q");
  inputs = twoFields(false);
  inputs["q"].cells.points[0].x = 0.01;
  expectDifferent("p + q");
}

}  // namespace
}  // namespace gxy::test
