// SPDX-License-Identifier: Apache-2.0
// simsim: weights, blending, blocks, files, and what its ranks say to the in situ interface.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>

#include "core/comm/error.h"
#include "core/io/write_volume.h"
#include "tests/insitu/simsim_stand_in.h"
#include "tests/support/temporary_folder.h"
#include "tools/simsim/blend.h"
#include "tools/simsim/block.h"
#include "tools/simsim/inputs.h"
#include "tools/simsim/options.h"
#include "tools/simsim/place.h"
#include "tools/simsim/rank.h"
#include "tools/simsim/report.h"
#include "tools/simsim/saved_steps.h"

namespace gxy::simsim {
namespace {

template <class T>
std::vector<T> blended(ScalarType type, double weight, const std::vector<T>& a, const std::vector<T>& b) {
  std::vector<T> out(a.size());
  blend(type, weight, std::as_bytes(std::span(a)), std::as_bytes(std::span(b)),
        std::as_writable_bytes(std::span(out)));
  return out;
}

template <class T>
std::vector<T> valuesIn(const std::vector<std::byte>& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

/// The message of the Error that the call throws; empty if it throws none.
template <class Call>
std::string errorOf(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

// --- weights ---

TEST(SimsimWave, ACycleIsTenStepsByDefault) {
  const Wave wave;
  const std::vector<double> expected{0, 0.2, 0.4, 0.6, 0.8, 1, 0.8, 0.6, 0.4, 0.2, 0, 0.2};
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(wave.weight(int64_t(i) + 1), expected[i], 1e-15);
  EXPECT_EQ(wave.weight(1), 0);
  EXPECT_EQ(wave.weight(6), 1);
  EXPECT_EQ(wave.weight(10'000'000'001), 0);
}

TEST(SimsimWave, CyclesAreOverAllSteps) {
  const Wave twice{2, 8};  // 4 steps a cycle
  const std::map<int64_t, double> expected{{1, 0}, {2, 0.5}, {3, 1}, {4, 0.5}, {5, 0}, {7, 1}};
  for (const auto& [step, weight] : expected) EXPECT_EQ(twice.weight(step), weight) << "step " << step;
}

TEST(SimsimWave, HalfACycleOnlyRises) {
  const Wave half{0.5, 30};
  for (int64_t step = 2; step <= 30; ++step) EXPECT_GT(half.weight(step), half.weight(step - 1));
}

// --- values ---

TEST(SimsimBlend, FloatIsComputedInFloatAndDoubleInDouble) {
  const float f = blended<float>(ScalarType::Float32, 0.3, {1.1f}, {7.7f})[0];
  EXPECT_EQ(f, (1.f - 0.3f) * 1.1f + 0.3f * 7.7f);
  const double d = blended<double>(ScalarType::Float64, 0.3, {1.1}, {7.7})[0];
  EXPECT_EQ(d, (1.0 - 0.3) * 1.1 + 0.3 * 7.7);
}

TEST(SimsimBlend, TheEndsAreTheFilesToTheBit) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), huge = std::numeric_limits<float>::infinity();
  const std::vector<float> a{-0.f, 1, nan}, b{nan, huge, -0.f};
  const auto first = blended(ScalarType::Float32, 0, a, b), second = blended(ScalarType::Float32, 1, a, b);
  EXPECT_EQ(std::memcmp(first.data(), a.data(), 12), 0);
  EXPECT_EQ(std::memcmp(second.data(), b.data(), 12), 0);
}

TEST(SimsimBlend, IntegersAreRounded) {
  using Bytes = std::vector<uint8_t>;
  EXPECT_EQ(blended<uint8_t>(ScalarType::UInt8, 0.5, {0, 0, 255}, {1, 4, 254}), (Bytes{1, 2, 255}));
  EXPECT_EQ(blended<int16_t>(ScalarType::Int16, 0.25, {-100}, {100})[0], -50);
  EXPECT_EQ(blended<int16_t>(ScalarType::Int16, 0.5, {-3}, {0})[0], -2);
}

TEST(SimsimBlend, WideIntegersStayWithinTheirRange) {
  const uint64_t most = std::numeric_limits<uint64_t>::max();
  const int64_t least = std::numeric_limits<int64_t>::min();
  EXPECT_EQ(blended<uint64_t>(ScalarType::UInt64, 0.3, {most}, {most})[0], most);
  EXPECT_EQ(blended<int64_t>(ScalarType::Int64, 0.7, {least}, {least})[0], least);
  EXPECT_EQ(blended<uint64_t>(ScalarType::UInt64, 0.5, {0}, {most - 1})[0], most / 2);
}

// --- blocks ---

/// How many of `ranks` own each point of a grid.
std::vector<int> ownersOf(const Index3& points, int ranks) {
  std::vector<int> owners(size_t(points[0] * points[1] * points[2]));
  for (int rank = 0; rank < ranks; ++rank) {
    const Extent block = blockOf(points, rank, ranks);
    EXPECT_GT(block.count(), 0);
    for (int64_t k = block.first[2]; k < block.first[2] + block.points[2]; ++k)
      for (int64_t j = block.first[1]; j < block.first[1] + block.points[1]; ++j)
        for (int64_t i = block.first[0]; i < block.first[0] + block.points[0]; ++i)
          ++owners.at(size_t((k * points[1] + j) * points[0] + i));
  }
  return owners;
}

TEST(SimsimBlock, EachPointBelongsToOneRank) {
  for (const Index3& points : {Index3{5, 7, 3}, Index3{2, 2, 2}, Index3{11, 2, 4}})
    for (const int ranks : {1, 2, 4, 8})
      EXPECT_EQ(ownersOf(points, ranks), std::vector<int>(size_t(points[0] * points[1] * points[2]), 1))
          << ranks << " ranks";
  EXPECT_EQ(ownersOf({5, 7, 3}, 105), std::vector<int>(105, 1));
  EXPECT_EQ(ownersOf({11, 2, 4}, 3), std::vector<int>(88, 1));
}

TEST(SimsimBlock, TooManyRanksAreAnErrorWithTheGrid) {
  EXPECT_EQ(errorOf([] {
              blockOf({2, 2, 2}, 0, 9);
            }),
            "the grid of 2 x 2 x 2 points cannot be cut into 9 blocks of one point or more; expected another "
            "number of ranks");
}

TEST(SimsimBlock, StridesSkipTheGhostPointsAndTheseHoldNoData) {
  BlockArray array({"u", ScalarType::Float32, 2, {}, false}, Extent{{4, 0, 2}, {3, 2, 2}});
  std::vector<float> values(24);
  std::iota(values.begin(), values.end(), 1.f);
  std::memcpy(array.first().data(), values.data(), 96);
  array.compute(0);
  const gxy_array view = array.view();
  EXPECT_EQ(view.components, 2);
  EXPECT_EQ(view.stride[0], 8);
  EXPECT_EQ(view.stride[1], 5 * 8);
  EXPECT_EQ(view.stride[2], 5 * 4 * 8);
  const auto at = [&view](int64_t i, int64_t j, int64_t k, int64_t c) {
    float value;
    std::memcpy(&value,
                static_cast<const std::byte*>(view.data) + i * view.stride[0] + j * view.stride[1] +
                    k * view.stride[2] + c * 4,
                4);
    return value;
  };
  for (int64_t k = -1; k <= 2; ++k)
    for (int64_t j = -1; j <= 2; ++j)
      for (int64_t i = -1; i <= 3; ++i)
        for (int64_t c = 0; c < 2; ++c) {
          if (i >= 0 && i < 3 && j >= 0 && j < 2 && k >= 0 && k < 2)
            EXPECT_EQ(at(i, j, k, c), float(1 + ((k * 2 + j) * 3 + i) * 2 + c));
          else
            EXPECT_TRUE(std::isnan(at(i, j, k, c))) << i << ' ' << j << ' ' << k;
        }
  EXPECT_EQ(valuesIn<float>(array.copyOfOwned()), values);
}

// --- files ---

/// Two files of a small grid, with float `u` and uint8 `v` of three components.
class SimsimFiles : public testing::Test {
 protected:
  SimsimFiles() {
    test::standIn() = {};
    write("a.vti", {{0.5, -1, 2}, glm::dvec3(0.25), {6, 5, 4}}, ScalarType::Float32, 1);
    write("b.vti", {{0.5, -1, 2}, glm::dvec3(0.25), {6, 5, 4}}, ScalarType::Float32, 2);
  }

  /// Value n of array `u` is factor * n, of array `v` it is factor * n modulo 100.
  void write(const std::string& name, const Grid& grid, ScalarType type, int factor) {
    const std::vector<ArrayInfo> arrays{{"u", type, 1, {}, false}, {"v", ScalarType::UInt8, 3, {}, false}};
    const VolumeWriter writer(folder_ / name, grid, arrays);
    const size_t points = size_t(wholeOf(grid).count());
    withType(type, [&]<class T>(T) {
      std::vector<T> u(points);
      for (size_t i = 0; i < points; ++i) u[i] = T(factor * int(i));
      writer.write(0, 0, std::as_bytes(std::span(u)));
    });
    std::vector<uint8_t> v(3 * points);
    for (size_t i = 0; i < v.size(); ++i) v[i] = uint8_t(size_t(factor) * i % 100);
    writer.write(1, 0, std::as_bytes(std::span(v)));
  }

  Inputs open(const std::vector<std::string>& arrays = {}) {
    return openInputs(folder_ / "a.vti", folder_ / "b.vti", arrays);
  }

  /// Ranks that have read their blocks.
  static std::vector<Rank> start(const Inputs& inputs, int count) {
    std::vector<Rank> ranks;
    for (int i = 0; i < count; ++i) ranks.emplace_back(inputs, "sim", i, count, R"({"to": "here:1"})");
    readBlocks(inputs, ranks, [] {});
    return ranks;
  }

  test::TemporaryFolder folder_;
};

TEST_F(SimsimFiles, TheActiveArrayIsTheDefault) {
  const Inputs inputs = open();
  ASSERT_EQ(inputs.arrays.size(), 1u);
  EXPECT_EQ(inputs.arrays[0].array.name, "u");
  EXPECT_EQ(open({"v", "u"}).arrays.size(), 2u);
}

TEST_F(SimsimFiles, AnotherGridIsAnErrorWithBoth) {
  write("b.vti", {{0.5, -1, 2}, glm::dvec3(0.25), {6, 5, 3}}, ScalarType::Float32, 2);
  EXPECT_EQ(errorOf([this] { open(); }),
            "expected the same grid in both files, found 6 x 5 x 4 points, origin (0.5, -1, 2), spacing "
            "(0.25, 0.25, 0.25) in " +
                (folder_ / "a.vti") +
                " and 6 x 5 x 3 points, origin (0.5, -1, 2), spacing (0.25, 0.25, 0.25) in " +
                (folder_ / "b.vti"));
}

TEST_F(SimsimFiles, AnotherTypeIsAnErrorWithBoth) {
  write("b.vti", {{0.5, -1, 2}, glm::dvec3(0.25), {6, 5, 4}}, ScalarType::Float64, 2);
  const std::string error = errorOf([this] { open({"u"}); });
  EXPECT_EQ(error, "expected the same type of array \"u\" in both files, found float32 with 1 component in " +
                       (folder_ / "a.vti") + " and float64 with 1 component in " + (folder_ / "b.vti"));
}

TEST_F(SimsimFiles, RanksDescribeTheirBlocks) {
  const Inputs inputs = open({"u", "v"});
  const std::vector<Rank> ranks = start(inputs, 3);
  for (int i = 0; i < 3; ++i) {
    const gxy_sim& side = test::standIn().sides.at(i);
    const Extent block = blockOf({6, 5, 4}, i, 3);
    EXPECT_EQ(side.name, "sim");
    EXPECT_EQ(side.ranks, 3);
    EXPECT_EQ(side.size, (Index3{6, 5, 4}));
    EXPECT_EQ(side.first, block.first);
    EXPECT_EQ(side.count, block.points);
    EXPECT_EQ(side.origin, (std::array<double, 3>{0.5, -1, 2}));
    EXPECT_EQ(side.spacing, (std::array<double, 3>{0.25, 0.25, 0.25}));
    EXPECT_EQ(side.fields.at("v").components, 3);
    EXPECT_EQ(side.fields.at("v").type, GXY_UINT8);
  }
}

TEST_F(SimsimFiles, WhatIsPublishedEqualsWhatIsSaved) {
  const Inputs inputs = open({"u", "v"});
  const SavedSteps saved((folder_.path() / "new" / "steps").string(), "sim", inputs, folder_ / "a.vti",
                         folder_ / "b.vti");
  for (const int count : {1, 4}) {
    std::vector<Rank> ranks = start(inputs, count);
    {
      const VolumeWriter writer = saved.create(7);
      for (Rank& rank : ranks) {
        rank.compute(0.5);
        rank.write(writer);
        EXPECT_EQ(rank.publish(7), GXY_TAKEN);
      }
    }
    for (const std::string name : {"u", "v"}) {
      const VolumeFile file = openVolume(folder_ / "new/steps/sim-7.vti", name);
      EXPECT_EQ(file.grid, inputs.grid);
      for (int i = 0; i < count; ++i) {
        const gxy_sim::Step& step = test::standIn().sides.at(i).steps.back();
        EXPECT_EQ(step.step, 7);
        EXPECT_EQ(step.time, 7);
        const Extent block = blockOf({6, 5, 4}, i, count);
        std::vector<std::byte> stored(size_t(block.count()) * file.bytesPerPoint());
        readVolume(file, block, stored);
        EXPECT_EQ(stored, step.read.at(name)) << name << " of rank " << i << " of " << count;
      }
    }
  }
}

TEST_F(SimsimFiles, HalfWayIsTheMeanOfBoth) {
  std::vector<Rank> ranks = start(open(), 1);
  ranks[0].compute(0.5);
  ranks[0].publish(1);
  const auto values = valuesIn<float>(test::standIn().sides.at(0).steps.back().read.at("u"));
  ASSERT_EQ(values.size(), 120u);
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], 1.5f * float(i));
}

TEST_F(SimsimFiles, InputsAreNotOverwritten) {
  write("sim-3.vti", {{0.5, -1, 2}, glm::dvec3(0.25), {6, 5, 4}}, ScalarType::Float32, 1);
  const Inputs inputs = openInputs(folder_ / "sim-3.vti", folder_ / "b.vti", {});
  const SavedSteps saved(folder_.path().string(), "sim", inputs, folder_ / "sim-3.vti", folder_ / "b.vti");
  EXPECT_NE(errorOf([&saved] { saved.create(3); }).find("it would be overwritten"), std::string::npos);
  EXPECT_EQ(errorOf([&saved] { saved.create(4); }), "");
}

TEST_F(SimsimFiles, WrongUseIsAnErrorWithTheInterfacesText) {
  test::standIn().gridResult = GXY_WRONG;
  EXPECT_EQ(errorOf([this] { start(open(), 1); }), "rank 0: nothing was wrong");
  EXPECT_EQ(test::standIn().sides.at(0).closed, 0);
}

TEST_F(SimsimFiles, ClosingWaitsAsLongAsIsSaid) {
  std::vector<Rank> ranks = start(open(), 2);
  ranks[1].close(5);
  ranks.clear();
  EXPECT_EQ(test::standIn().sides.at(0).closed, 0);
  EXPECT_EQ(test::standIn().sides.at(1).closed, 5);
}

// --- what users say and are told ---

TEST(SimsimReport, AStepIsTakenWhereAllRanksHaveTakenIt) {
  using Results = std::vector<int>;
  EXPECT_EQ(outcomeOf(Results{GXY_TAKEN, GXY_TAKEN}), Outcome::Taken);
  EXPECT_EQ(outcomeOf(Results{GXY_NOT_TAKEN, GXY_NOT_TAKEN}), Outcome::NotNeeded);
  EXPECT_EQ(outcomeOf(Results{GXY_TAKEN, GXY_NOT_TAKEN}), Outcome::LeftOut);
  EXPECT_EQ(outcomeOf(Results{GXY_TAKEN, GXY_LOST, GXY_NOT_TAKEN}), Outcome::NoConnection);
  EXPECT_EQ(outcomeOf(Results{GXY_OFF, GXY_OFF}), Outcome::Off);
  EXPECT_EQ(lineAbout(3, Outcome::Taken, "text"), "step 3: taken");
  EXPECT_EQ(lineAbout(4, Outcome::NotNeeded, "text"), "step 4: nobody needs it");
  EXPECT_EQ(lineAbout(5, Outcome::NoConnection, "text"), "step 5: no connection: text");
  EXPECT_EQ(lineAbout(1, Outcome::NoConnection, ""), "step 1: no connection so far");
}

TEST(SimsimPlace, LaunchersSayItInTheEnvironment) {
  const auto placeIn = [](const std::map<std::string, std::string>& variables) {
    return placeFrom([&variables](const char* name) {
      const auto found = variables.find(name);
      return found == variables.end() ? nullptr : found->second.c_str();
    });
  };
  EXPECT_EQ(placeIn({}).ranks, 1);
  EXPECT_EQ(placeIn({{"OMPI_COMM_WORLD_RANK", "2"}, {"OMPI_COMM_WORLD_SIZE", "3"}}).rank, 2);
  EXPECT_EQ(placeIn({{"PMI_RANK", "0"}, {"PMI_SIZE", "5"}}).ranks, 5);
  EXPECT_EQ(placeIn({{"SLURM_PROCID", "1"}, {"SLURM_STEP_NUM_TASKS", "4"}}).ranks, 4);
  EXPECT_EQ(placeIn({{"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "4"}}).ranks, 1) << "a batch script";
  EXPECT_EQ(errorOf([&] {
              placeIn({{"PMI_RANK", "5"}, {"PMI_SIZE", "5"}});
            }),
            "environment variables PMI_RANK and PMI_SIZE: expected a rank below the number of ranks, found 5 "
            "and 5");
  EXPECT_EQ(errorOf([&] {
              placeIn({{"PMI_RANK", "x"}, {"PMI_SIZE", "5"}});
            }),
            "environment variable PMI_RANK: expected a whole number from 0 up, found \"x\"");
}

/// The exit code of the options, or -1 if the program goes on; what they print is dropped.
int parsed(std::vector<const char*> words, SimulationOptions& options, const Place& place = {}) {
  words.insert(words.begin(), "simsim");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int code = parseOptions(int(words.size()), words.data(), place, options).value_or(-1);
  testing::internal::GetCapturedStdout();
  testing::internal::GetCapturedStderr();
  return code;
}

TEST(SimsimOptions, WhatDoesNotGoTogetherIsWrongUsage) {
  for (const std::vector<const char*>& words :
       std::vector<std::vector<const char*>>{{"a"},
                                             {"a", "b", "-n", "0", "-c", "2"},
                                             {"a", "b", "-n", "-1"},
                                             {"a", "b", "-d", "nan"},
                                             {"a", "b", "--name", "x/y"},
                                             {"a", "b", "-M", "0"},
                                             {"a", "b", "--array", "u", "--array", "u"}}) {
    SimulationOptions options;
    EXPECT_EQ(parsed(words, options), 2) << words.back();
  }
  SimulationOptions options;
  EXPECT_EQ(parsed({"a", "b", "-M", "2"}, options, {1, 4}), 2);
  EXPECT_EQ(parsed({"a", "b", "--save", "s"}, options, {1, 4}), 2);
  EXPECT_EQ(parsed({"--version"}, options), 0);
}

TEST(SimsimOptions, TheEarlierProgramsOptionsAreTaken) {
  SimulationOptions options;
  EXPECT_EQ(
      parsed({"-p", "1234", "-l", "layout.json", "-n", "20", "-d", "0.5", "-c", "3", "a", "b"}, options), -1);
  EXPECT_EQ(options.port, 1234);
  EXPECT_EQ(options.wave.cycles, 3);
  EXPECT_EQ(options.wave.steps, 20);
  EXPECT_EQ(options.ofStream(), R"({"to":"127.0.0.1:1234"})");
}

TEST(SimsimOptions, AddressesWithColonsAreInBrackets) {
  SimulationOptions options;
  options.host = "::1";
  options.tokenFile = "-";
  EXPECT_EQ(options.ofStream(), R"({"to":"[::1]:5001","token-file":"-"})");
  options.waits = true;
  EXPECT_EQ(options.ofStream(), R"({"policy":"wait","time-out":60,"to":"[::1]:5001","token-file":"-"})");
}

}  // namespace
}  // namespace gxy::simsim
