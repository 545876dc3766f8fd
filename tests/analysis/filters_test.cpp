// SPDX-License-Identifier: Apache-2.0
// What is the same for all filters: their reference, the checks of their inputs, and how results say what they are made of.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/analysis/pointwise.h"
#include "core/analysis/seeds_filter.h"
#include "core/comm/error.h"
#include "tests/analysis/filter_setup.h"

namespace gxy::test {
namespace {

std::string contentOf(const std::filesystem::path& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(Filters, TheReferenceIsWhatTheyDeclare) {
  const std::string reference = filterReference(standardFilters());
  const std::filesystem::path generated =
      std::filesystem::path(FILTER_TEST_OUTPUT_DIR) / "filter-reference.md";
  std::ofstream(generated) << reference;
  EXPECT_NE(contentOf(std::filesystem::path(GALAXY_DOCS_DIR) / "filters.md").find(reference),
            std::string::npos)
      << "copy " << generated << " into docs/filters.md";
}

WholeVolume ramp() {
  WholeVolume whole;
  whole.grid.points = {9, 5, 4};
  whole.grid.spacing = {0.5, 1, 2};
  whole.samples.resize(9 * 5 * 4 * sizeof(float));
  for (size_t i = 0; i < 9 * 5 * 4; i++) {
    const float value = float(i % 9);
    std::memcpy(&whole.samples[i * sizeof value], &value, sizeof value);
  }
  return whole;
}

/// The part of one rank of a dataset that is of a step of a source.
std::shared_ptr<const Dataset> dataset(const WholeVolume& whole, const Cut& cut, int rank, int64_t step = 1,
                                       uint64_t source = 7) {
  const auto made = datasetOf(whole, cut, rank);
  made->origins = {{source, step}};
  made->time = double(step) / 4;
  return made;
}

struct Half {
  static FilterInfo info() {
    return {"Half",
            3,
            "1 from a value on.",
            {{"source", kVolumes, "."}, {"other", kVolumes, ".", FilterPort::Count::Optional}},
            DatasetType::Volume};
  }
  double from = 4;
  static std::vector<KeyRow<Half>> properties() { return {numberKey("from", &Half::from, kAny, ".")}; }
  FilterResult run(FilterRun& run) const {
    return pointwise(run, run.input("source"), "half", [this](double value) { return value >= from; });
  }
};

TEST(Filters, AResultSaysHowItWasMadeAndOfWhichSteps) {
  const WholeVolume whole = ramp();
  const Cut cut = lattice(whole.grid.box(), {2, 2, 1}, 3);
  ThreadRanks world(3);
  for (const std::string& error : world.run([&](Collectives& ranks) {
         FilterRun run(ranks,
                       {{"source", {{"ramp", gxy::Key{5}, 2, dataset(whole, cut, ranks.rank(), 6)}}},
                        {"other", {{"too", gxy::Key{6}, 9, dataset(whole, cut, ranks.rank(), 6)}}}},
                       freeServices());
         const FilterResult result = evaluate(*makeFilter<Half>(), run, R"({"from":3.0})");
         const Dataset& made = *result.dataset;
         if (made.origins != std::vector<Origin>{{7, 6}}) throw Error("origins");
         if (made.time != 1.5) throw Error("time");
         const Provenance& p = made.provenance;
         if (p.filter != "Half" || p.version != 3 || p.properties != R"({"from":3.0})")
           throw Error("provenance");
         if (p.inputs.size() != 2 || p.inputs[1].input != "source" || p.inputs[1].name != "ramp" ||
             p.inputs[1].key != gxy::Key{5} || p.inputs[1].generation != 2)
           throw Error("inputs");
         if (made.volume->stored != ScalarType::UInt8 || made.range().min != 0 || made.range().max != 1)
           throw Error("values");
       }))
    EXPECT_EQ(error, "");
}

TEST(Filters, InputsOfDifferentStepsOfOneSourceAreRefusedOnAllRanks) {
  const WholeVolume whole = ramp();
  const Cut cut = lattice(whole.grid.box(), {2, 1, 1}, 2);
  ThreadRanks world(2);
  const auto errorsOf = [&](uint64_t otherSource) {
    return world.run([&](Collectives& ranks) {
      FilterRun run(ranks,
                    {{"source", {{"pressure", {}, 1, dataset(whole, cut, ranks.rank(), 7)}}},
                     {"other", {{"gradient", {}, 1, dataset(whole, cut, ranks.rank(), 8, otherSource)}}}},
                    freeServices());
      evaluate(*makeFilter<Half>(), run, "{}");
    });
  };
  for (const std::string& error : errorsOf(7))
    EXPECT_NE(error.find("\"gradient\" is of step 8 and \"pressure\" of step 7 of the same source"),
              std::string::npos)
        << error;
  for (const std::string& error : errorsOf(8)) EXPECT_EQ(error, "");
}

TEST(Filters, AnInputOfAnotherTypeIsRefused) {
  const WholeVolume whole = ramp();
  SingleRank alone;
  const auto from = dataset(whole, test::whole(whole.grid.box()), 0);
  FilterRun seeds(alone, {{"domain", {{"v", {}, 1, from}}}}, freeServices());
  const auto particles = evaluate(*makeFilter<Seeds>(), seeds, "{}").dataset;
  FilterRun run(alone, {{"source", {{"seeds", {}, 1, particles}}}}, freeServices());
  try {
    evaluate(*makeFilter<Half>(), run, "{}");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(
        std::string(e.what()).find("input `source`: expected Volume, found \"seeds\", which is Particles"),
        std::string::npos)
        << e.what();
  }
}

/// The seeds of all ranks, by id.
std::map<uint64_t, MadePoint> seedsOf(const std::string& properties, int n) {
  const WholeVolume whole = ramp();
  const Cut cut = lattice(whole.grid.box(), {2, 2, 2}, n);
  const MadePoints seeds = made<Seeds>(
      cut,
      [&](Collectives& ranks) {
        return FilterRun::Inputs{{"domain", {{"v", {}, 1, datasetOf(whole, cut, ranks.rank())}}}};
      },
      properties);
  EXPECT_EQ(seeds.error, "");
  EXPECT_EQ(seeds.told.at("particles"), seeds.points.size());
  return seeds.points;
}

TEST(Seeds, OfALatticeAreInTheMiddleOfItsCells) {
  const auto seeds = seedsOf(R"({"shape": "grid", "dimensions": [4, 2, 1]})", 1);
  ASSERT_EQ(seeds.size(), 8u);
  EXPECT_EQ(seeds.at(0).point, glm::dvec3(0.5, 1, 3)) << "the box is 4 x 4 x 6";
  EXPECT_EQ(seeds.at(7).point, glm::dvec3(3.5, 3, 3));
}

TEST(Seeds, OfALineHaveBothEnds) {
  const auto seeds = seedsOf(R"({"shape": "line", "from": [1, 2, 3], "to": [2, 2, 1], "count": 5})", 2);
  ASSERT_EQ(seeds.size(), 5u);
  EXPECT_EQ(seeds.at(0).point, glm::dvec3(1, 2, 3));
  EXPECT_EQ(seeds.at(2).point, glm::dvec3(1.5, 2, 2));
  EXPECT_EQ(seeds.at(4).point, glm::dvec3(2, 2, 1));
}

TEST(Seeds, AreTheSameOnAnyRanks) {
  for (const char* properties :
       {R"({"shape": "grid", "dimensions": [3, 5, 7]})", R"({"shape": "line", "count": 11})",
        R"({"shape": "box", "count": 50, "seed": 3})", R"({"shape": "sphere", "count": 50, "seed": 3})",
        R"({"shape": "points", "points": [[1, 2, 3], [0, 0, 0], [9, 9, 9]]})"}) {
    const auto one = seedsOf(properties, 1);
    EXPECT_GE(one.size(), 3u);
    for (const int ranks : {2, 5}) EXPECT_EQ(seedsOf(properties, ranks), one) << properties;
  }
}

}  // namespace
}  // namespace gxy::test
