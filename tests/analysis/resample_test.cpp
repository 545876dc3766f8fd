// SPDX-License-Identifier: Apache-2.0
// Resample: a field on another grid, whole, seamless and the same on any ranks.
#include "core/analysis/resample_filter.h"

#include <cmath>
#include <cstring>

#include "core/analysis/field_reader.h"
#include "tests/analysis/filter_setup.h"

namespace gxy::test {
namespace {

struct Made {
  std::map<std::array<int64_t, 3>, float> values;  ///< by point, from all blocks with their ghosts
  Grid grid;
  nlohmann::json told;
  std::string error;
};

Made resampled(const WholeVolume& whole, const Cut& cut, const std::string& properties,
               const WholeVolume* like = nullptr) {
  Made made;
  std::mutex mutex;
  ThreadRanks world(cut.ranks);
  const auto errors = world.run([&](Collectives& ranks) {
    FilterRun::Inputs inputs{{"field", {{"f", {}, 1, datasetOf(whole, cut, ranks.rank())}}}};
    if (like) inputs["like"].push_back({"l", {}, 1, datasetOf(*like, cut, ranks.rank())});
    FilterRun run(ranks, std::move(inputs), freeServices());
    const FilterResult result = evaluate(*makeFilter<Resample>(), run, properties);
    const Volume& v = *result.dataset->volume;
    const std::lock_guard lock(mutex);
    made.grid = v.grid;
    if (ranks.rank() == 0) made.told = result.told;
    for (const auto& [partition, block] : v.blocks) {
      const Bricks bricks(block.extent.points);
      for (int64_t z = 0; z < block.extent.points[2]; z++)
        for (int64_t y = 0; y < block.extent.points[1]; y++)
          for (int64_t x = 0; x < block.extent.points[0]; x++) {
            float value;
            std::memcpy(&value, &block.samples[bricks(x, y, z) * sizeof value], sizeof value);
            value = float(v.shift + v.scale * double(value));
            const auto& first = block.extent.first;
            const auto [known, isNew] =
                made.values.emplace(std::array{first[0] + x, first[1] + y, first[2] + z}, value);
            const float before = known->second;
            EXPECT_TRUE(before == value || (std::isnan(before) && std::isnan(value)))
                << "ghosts are their owners' values";
          }
    }
  });
  made.error = errors[0];
  for (const std::string& error : errors) EXPECT_EQ(error.empty(), made.error.empty()) << error;
  return made;
}

void expectAlike(const Made& a, const Made& b, const std::string& what) {
  ASSERT_EQ(a.values.size(), b.values.size()) << what;
  for (const auto& [at, value] : a.values) {
    const float other = b.values.at(at);
    ASSERT_TRUE(value == other || (std::isnan(value) && std::isnan(other))) << what;
  }
}

TEST(Resample, OfATrilinearFieldIsTheFieldOnAFinerAndACoarserGrid) {
  const WholeVolume whole = sampled(oddGrid({11, 9, 7}), trilinear);
  for (const char* properties : {R"({"dimensions": [31, 17, 20]})", R"({"dimensions": [3, 2, 4]})",
                                 R"({"dimensions": [7, 8, 9], "box": [0, 1, 2.5, 3, 1, 6]})"}) {
    const Made made = resampled(whole, lattice(whole.grid.box(), {2, 2, 2}, 3), properties);
    ASSERT_EQ(made.error, "");
    ASSERT_EQ(int64_t(made.values.size()), made.grid.points[0] * made.grid.points[1] * made.grid.points[2]);
    EXPECT_EQ(made.told.at("outside"), 0);
    for (const auto& [at, value] : made.values) {
      const glm::dvec3 p = made.grid.origin + made.grid.spacing * glm::dvec3(at[0], at[1], at[2]);
      ASSERT_NEAR(value, trilinear(p), 2e-5) << properties;
    }
  }
}

TEST(Resample, IsTheSameOnAnyRanksAndCuts) {
  const WholeVolume whole =
      sampled(oddGrid({11, 9, 7}), [](glm::dvec3 p) { return std::sin(5 * p.x) + p.y * p.z; });
  const std::string properties = R"({"dimensions": [19, 23, 12]})";
  const Made one = resampled(whole, test::whole(whole.grid.box()), properties);
  ASSERT_EQ(one.values.size(), 19u * 23 * 12);
  for (const Cut& cut : manyCuts(whole.grid.box(), 5))
    expectAlike(resampled(whole, cut, properties), one, cut.name);
}

TEST(Resample, LikeAnotherVolumeHasItsGridAndNoDataOutside) {
  const WholeVolume whole = sampled(oddGrid({11, 9, 7}), trilinear);
  Grid larger = oddGrid({11, 9, 7});
  larger.origin = {-2, 2, 0.5};
  larger.spacing = {0.6, 0.25, 1};
  larger.points = {13, 9, 7};
  const WholeVolume like = sampled(larger, [](glm::dvec3) { return 0.0; });
  Box domain = whole.grid.box();
  domain.extend(larger.box());
  const Made made = resampled(whole, lattice(domain, {3, 1, 2}, 2), "{}", &like);
  ASSERT_EQ(made.error, "");
  EXPECT_EQ(made.grid, larger);
  int outside = 0;
  for (const auto& [at, value] : made.values) {
    const double x = larger.origin.x + larger.spacing.x * double(at[0]);
    const bool isOutside = x < -1 || x > 4;
    outside += isOutside;
    ASSERT_EQ(std::isnan(value), isOutside) << x;
  }
  EXPECT_EQ(made.told.at("outside"), outside);
}

TEST(Resample, ABoxBeyondTheDomainIsRefused) {
  const WholeVolume whole = sampled(oddGrid({11, 9, 7}), trilinear);
  const Made made = resampled(whole, test::whole(whole.grid.box()), R"({"box": [0, 9, 2, 3, 1, 2]})");
  EXPECT_NE(made.error.find("the box reaches beyond the domain of the partitioning of \"f\""),
            std::string::npos)
      << made.error;
}

}  // namespace
}  // namespace gxy::test
