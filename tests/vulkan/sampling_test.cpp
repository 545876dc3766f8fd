// SPDX-License-Identifier: Apache-2.0
// Samplings on the device: the samples of Embree, bit for bit, whatever the partitions and ranks.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "backends/embree/embree_backend.h"
#include "core/analysis/ray_filter.h"
#include "tests/analysis/sampled.h"
#include "tests/support/scenes.h"
#include "tests/vulkan/test_device.h"

namespace gxy::vulkan_test {
namespace {

using namespace test;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Three components on a grid of unequal spacings.
WholeVolume threeComponents(const Box& box, Index3 points) {
  WholeVolume whole;
  whole.grid = {box.lo, (box.hi - box.lo) / (glm::dvec3(points[0], points[1], points[2]) - 1.0), points};
  whole.components = 3;
  std::vector<float> values;
  for (int64_t z = 0; z < points[2]; z++)
    for (int64_t y = 0; y < points[1]; y++)
      for (int64_t x = 0; x < points[0]; x++) {
        const glm::dvec3 p(double(x) / double(points[0]), double(y) / double(points[1]),
                           double(z) / double(points[2]));
        values.push_back(float(std::sin(7 * p.x + 2 * p.y)));
        values.push_back(float(p.z * p.z - 0.4 * std::cos(9 * p.y)));
        values.push_back(float(p.x * p.y - p.z));
      }
  whole.samples.resize(values.size() * sizeof(float));
  std::memcpy(whole.samples.data(), values.data(), whole.samples.size());
  return whole;
}

template <class T>
WholeVolume storedAs(ScalarType type, const WholeVolume& floats, double factor) {
  WholeVolume whole = floats;
  whole.stored = type;
  const size_t n = floats.samples.size() / sizeof(float);
  std::vector<float> from(n);
  std::memcpy(from.data(), floats.samples.data(), floats.samples.size());
  std::vector<T> to;
  for (const float x : from) to.push_back(T(factor * double(x)));
  whole.samples.resize(n * sizeof(T));
  std::memcpy(whole.samples.data(), to.data(), whole.samples.size());
  return whole;
}

/// Takes the operators of a scene for pictures.
void addOperators(SamplingCase& c, const TestScene& scene) {
  for (size_t i = 0; i < scene.data.size(); i++) {
    if (const auto* volume = std::get_if<std::shared_ptr<const WholeVolume>>(&scene.data[i])) {
      c.shown.push_back(c.volumes.size());
      c.volumes.push_back(**volume);
    } else {
      c.geometry[c.operators.size()] = std::get<std::shared_ptr<const WholeGeometry>>(scene.data[i]);
      c.shown.push_back(0);
    }
    c.operators.push_back(scene.visualization.operators[i]);
    c.rules.push_back({{}, kMostHits});
  }
}

/// The bytes of all samples.
std::string bytesOfSamples(const SampleList& list) {
  std::string bytes;
  const auto add = [&](const auto& values) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
  };
  add(list.ray), add(list.hit), add(list.depth), add(list.surface), add(list.t), add(list.position);
  for (const auto& values : list.values) add(values);
  add(list.gradient);
  // Places in a partition differ, and so do the bytes between members.
  for (const MetSurface& met : list.met) {
    bytes.append(reinterpret_cast<const char*>(&met.origin), sizeof met.origin + sizeof met.direction);
    bytes.push_back(char(met.kind));
  }
  return bytes;
}

enum class Cuts { One, Several };

/// The samples of Embree in one piece are those of the device, on eight partitions or on several cuts; there are at least `least`.
void expectTheSame(const SamplingCase& c, const Box& domain, size_t least, uint64_t lines = 600,
                   Cuts on = Cuts::One, const VulkanOptions* options = nullptr) {
  const SampleList expected = SamplingRanks(whole(domain), {}).lines(c, 5, lines);
  EXPECT_GE(expected.size(), least);
  const auto own = options ? makeVulkanBackend(*options) : nullptr;
  const glm::dvec3 corner = domain.lo + glm::dvec3(0.37, 0.61, 0.44) * (domain.hi - domain.lo);
  std::vector<Cut> cuts{octants(domain, corner, 3)};
  if (on == Cuts::Several) cuts.insert(cuts.end(), {whole(domain), kdCut(domain, 5, 2, 9)});
  for (const Cut& cut : cuts) {
    SamplingRanks::Run run;
    run.backend = own ? own.get() : &testedVulkan();
    SamplingRanks ranks(cut, run);
    const SampleList found = ranks.lines(c, 5, lines);
    EXPECT_EQ(found.size(), expected.size()) << cut.name;
    if (isSoftware()) {
      EXPECT_TRUE(bytesOfSamples(found) == bytesOfSamples(expected)) << cut.name;
    }
    // The device did it: there is no other backend here, and it has counted its work.
    TraceCounters counters;
    for (int r = 0; r < cut.ranks; r++) counters += ranks.sampler(r).traced();
    EXPECT_GT(counters.submissions, 0u);
    EXPECT_GT(counters.raysSpawned, 0u);
    EXPECT_EQ(counters.raysRetired, counters.raysSpawned) << cut.name;
  }
}

TEST(VulkanSampling, EndsWhenSamplesHaveNoRoomWhileABatchIsTraced) {
  expectSamplesEnteredWhileTheyAreRecorded(testedVulkan());
}

TEST(VulkanSampling, OfComponentsWithGradientsAndConditions) {
  const Box box = sceneDomain();
  SamplingCase c;
  c.volumes = {threeComponents(box, {15, 18, 11}), threeComponents(box, {9, 5, 7})};
  Vis vis;
  vis.component = 1;
  vis.isovalues = {0.1, -0.2};
  c.operators.push_back(vis);
  vis.component.reset();  // the magnitude
  vis.isovalues = {0.7};
  c.operators.push_back(vis);
  c.shown = {0, 0};
  c.fields = {{0, 1}, {0, -1}, {1, 0}, {1, 2}, {1, -1}};
  c.recorded = 4;
  c.gradient = true;
  c.rules = {{{{2, -0.5, 0.8}, {4, 0, 1}}, 3}, {{{3, -kInfinity, 0.1}}, 2}};
  expectTheSame(c, box, 250, 600, Cuts::Several);
}

TEST(VulkanSampling, OfIsosurfacesSlicesAndGeometryBehindClipPlanes) {
  TestScene scene = emptyScene("sampled");
  addIsosurfaces(scene, 1);
  addSlices(scene, 1);
  addMesh(scene, 1);
  addParticles(scene, 1);
  addTubes(scene, 1);
  addClipPlane(scene);
  SamplingCase c;
  addOperators(c, scene);
  c.fields = {{0, 0}, {1, 0}};
  c.recorded = 2;
  c.gradient = true;
  expectTheSame(c, scene.domain, 1500);
  // Of a field that the scene does not show, and of particles that count only where it is small.
  c.volumes.push_back(threeComponents(scene.domain, {6, 7, 8}));
  c.fields = {{c.volumes.size() - 1, 2}};
  c.recorded = 1;
  c.gradient = false;
  for (HitRule& rule : c.rules) rule.hits = 2;
  c.rules[3].conditions = {{0, -kInfinity, -0.2}};
  expectTheSame(c, scene.domain, 600);
}

TEST(VulkanSampling, OfSamplesOfEachTypeWithHolesOfNoData) {
  const Box box = sceneDomain();
  const WholeVolume floats = threeComponents(box, {13, 12, 14});
  SamplingCase c;
  c.volumes = {storedAs<int8_t>(ScalarType::Int8, floats, 90),
               storedAs<uint16_t>(ScalarType::UInt16, floats, 1000),
               storedAs<int16_t>(ScalarType::Int16, floats, 9000), floats};
  std::vector<float> values(floats.samples.size() / sizeof(float));
  std::memcpy(values.data(), floats.samples.data(), floats.samples.size());
  for (size_t i = 0; i < values.size(); i++)
    if (i % 41 == 3) values[i] = i % 2 ? kNone : float(kInfinity);
  std::memcpy(c.volumes[3].samples.data(), values.data(), floats.samples.size());
  for (size_t v = 0; v < c.volumes.size(); v++) {
    Vis vis;
    vis.component = 0;
    const double factor[] = {90, 1000, 9000, 1};
    vis.isovalues = {0.35 * factor[v]};
    c.operators.push_back(vis);
    c.shown.push_back(v);
    c.fields.push_back({v, 2});
    c.fields.push_back({v, -1});
    c.rules.push_back({{}, 4});
  }
  c.recorded = 8;
  c.gradient = true;
  expectTheSame(c, box, 600);
}

TEST(VulkanSampling, OfTinyAndFarValuesAndLengths) {
  for (const auto& [scale, shift] : {std::pair(1e-25, 0.0), {1e25, 0.0}, {1.0, 1e6}}) {
    const Box box{glm::dvec3(shift) - scale, glm::dvec3(shift) + glm::dvec3(1, 2, 1.5) * scale};
    SamplingCase c;
    c.volumes = {threeComponents(box, {8, 9, 7})};
    c.volumes[0].shift = 101325.0;
    c.volumes[0].scale = 0.01;
    Vis vis;
    vis.component = 1;
    vis.isovalues = {101325.001, 101324.999};
    vis.clipPlanes = {{{1, 0.3, 0}, box.lo.x + 0.4 * scale}};
    c.operators = {vis};
    c.shown = {0};
    c.fields = {{0, 1}, {0, 0}};
    c.recorded = 2;
    c.gradient = true;
    c.rules = {{{{1, 101325.0, kInfinity}}, kMostHits}};
    expectTheSame(c, box, 100, 400);
  }
}

TEST(VulkanSampling, AtEqualDistancesInVolumesWithHoles) {
  const Box box = sceneDomain();
  SamplingCase c;
  c.volumes = {threeComponents(box, {13, 12, 14})};
  std::vector<float> values(c.volumes[0].samples.size() / sizeof(float));
  std::memcpy(values.data(), c.volumes[0].samples.data(), c.volumes[0].samples.size());
  for (size_t i = 0; i < values.size(); i += 83) values[i] = kNone;
  std::memcpy(c.volumes[0].samples.data(), values.data(), c.volumes[0].samples.size());
  Vis vis;
  vis.component = 1;
  vis.every = 0.07;
  vis.clipPlanes = {{{0.2, 1, 0}, -0.4}};
  c.operators = {vis};
  vis.every = 0;
  vis.isovalues = {0.2};
  c.operators.push_back(vis);
  c.shown = {0, 0};
  c.fields = {{0, 0}};
  c.recorded = 1;
  c.met = true;
  c.rules = {{{{0, -0.8, kInfinity}}, kMostHits}, {{}, 20}};
  expectTheSame(c, box, 3000, 400);
}

TEST(VulkanSampling, OfRaysThatFollowOthers) {
  const Box box{glm::dvec3(0), glm::dvec3(1)};
  const WholeVolume a = threeComponents(box, {15, 18, 11}), b = sampled(unitGrid(9), squaredDistance);
  Evaluation evaluation;
  evaluation.inputs = {{"a", {&a}}, {"b", {&b}}};
  const std::string properties = R"({"lines":120,"depth":3,"values":"b","operators":[
    {"dataset":"a","component":1,"isovalues":[0.1,-0.3],"next":{"spawn":2}},
    {"dataset":"b","isovalues":[0.09],"next":{"redirect":"refract","n1":1.4,"n2":1}},
    {"dataset":"a","planes":[[1,1,0,0.9]],"next":{"redirect":"mirror"},"hits":2}]})";
  const SampledPoints expected = evaluateOn<RaySampler>(whole(box), evaluation, properties);
  EXPECT_GT(expected.points.size(), 200u);
  evaluation.run.backend = &testedVulkan();
  for (const Cut& cut : {whole(box), octants(box, {0.37, 0.61, 0.44}, 3)}) {
    const SampledPoints found = evaluateOn<RaySampler>(cut, evaluation, properties);
    EXPECT_EQ(found.points.size(), expected.points.size()) << cut.name;
    if (isSoftware()) {
      EXPECT_TRUE(found == expected) << cut.name;
    }
  }
}

// Batches of few rays, whose rays come back to the host, and fields that are read by address.
TEST(VulkanSampling, OfADeviceWithNarrowLimits) {
  const Box box = sceneDomain();
  SamplingCase c;
  c.volumes = {threeComponents(box, {15, 18, 11})};
  Vis vis;
  vis.component = 2;
  vis.isovalues = {-0.3, 0, 0.2};
  c.operators = {vis};
  c.shown = {0};
  c.fields = {{0, 0}};
  c.recorded = 1;
  c.rules = {{{}, kMostHits}};
  VulkanOptions options = testDevice();
  options.bindingBytes = 64;
  options.quadBytes = 64;
  options.keptBytes = 1;
  expectTheSame(c, box, 500, 3000, Cuts::Several, &options);
}

TEST(VulkanSampling, WithoutRoomIsLeftToTheOtherBackend) {
  const Box box = sceneDomain();
  SamplingCase c;
  c.volumes = {threeComponents(box, {6, 7, 5}), threeComponents(box, {60, 60, 60})};
  Vis vis;
  vis.component = 1;
  vis.isovalues = {0.1};
  c.operators = {vis};
  c.shown = {0};
  c.fields = {{1, 0}};
  c.recorded = 1;
  c.rules = {{{}, 2}};
  VulkanOptions options = testDevice();
  options.allocationBytes = 1 << 21;
  const auto small = makeVulkanBackend(options);
  SamplingRanks::Run run;
  run.backend = small.get();
  EXPECT_THROW(SamplingRanks(whole(box), run).lines(c, 5, 200), Error);
  run.options.other = [](Ledger*) { return makeEmbreeBackend(); };
  const SampleList found = SamplingRanks(whole(box), run).lines(c, 5, 200);
  EXPECT_GT(found.size(), 50u);
  EXPECT_TRUE(bytesOfSamples(found) == bytesOfSamples(SamplingRanks(whole(box), {}).lines(c, 5, 200)));
}

}  // namespace
}  // namespace gxy::vulkan_test
