// SPDX-License-Identifier: Apache-2.0
// The box test of the hierarchy's traversal, on the device, against 128-bit arithmetic.
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "backends/vulkan/vulkan_device.h"
#include "box_entry_spirv.h"
#include "shaders/layout.h"
#include "tests/kernels/box_cases.h"
#include "tests/vulkan/test_device.h"
#include "tests/vulkan/test_shader.h"

namespace gxy::test {
namespace {

using namespace vulkan;

/// The test as the device does it.
class BoxEntryOnDevice {
 public:
  std::vector<float> entriesOf(const std::vector<Case>& cases) const {
    static_assert(sizeof(Case) == 14 * sizeof(float));
    std::vector<float> numbers;
    for (const Case& c : cases) {
      for (const glm::vec3& v : {c.lo, c.hi, c.origin, c.direction})
        for (int axis = 0; axis < 3; axis++) numbers.push_back(v[axis]);
      numbers.push_back(c.tMax);
    }
    std::vector<Buffer> buffers;
    buffers.emplace_back(device_, numbers.size() * sizeof(float), Place::Device, "cases");
    buffers.emplace_back(device_, cases.size() * sizeof(float), Place::Readback, "entries");
    upload(device_, buffers[0], 0, std::as_bytes(std::span(numbers)));
    shader_.run(VK_NULL_HANDLE, buffers, int32_t(cases.size()),
                {uint32_t(cases.size() + BLOCK_RAYS - 1) / BLOCK_RAYS, 1});
    std::vector<float> found(cases.size());
    std::memcpy(found.data(), buffers[1].mapped(), found.size() * sizeof(float));
    return found;
  }

 private:
  const Device device_{vulkan_test::testDevice()};
  const Pipelines pipelines_{device_};
  const vulkan_test::TestShader shader_{device_, pipelines_, box_entry_spirv};
};

/// As primitive_bounds.h does.
Case movedOut(Case c) {
  float largest = 0;
  for (int axis = 0; axis < 3; axis++)
    largest = std::max({largest, std::fabs(c.lo[axis]), std::fabs(c.hi[axis])});
  c.lo -= 2e-6f * largest;
  c.hi += 2e-6f * largest;
  return c;
}

// Of 10^7.
TEST(BoxEntry, NoHitOfExactArithmeticIsMissed) {
  const BoxEntryOnDevice device;
  Random random(15);
  Case c{};
  int hits = 0, missed = 0;
  for (int lot = 0; lot < 25; lot++) {
    std::vector<Case> cases, given;
    while (cases.size() < 400'000) {
      if (cases.size() % 8 == 0) do
          drawBox(random, c);
        while (c.lo == glm::vec3(0) && c.hi == glm::vec3(0));  // no primitive is a point at the origin
      drawRay(random, c);
      c.tMax = std::min(c.tMax, 1e30f);
      cases.push_back(c);
      given.push_back(movedOut(c));
    }
    const std::vector<float> entries = device.entriesOf(given);
    for (size_t i = 0; i < cases.size(); i++) {
      const bool truth = meetsExactly(cases[i]);
      hits += truth;
      missed += truth && !(entries[i] <= cases[i].tMax * 1.000001f);
    }
  }
  EXPECT_EQ(missed, 0);
  EXPECT_GT(hits, 250'000);
}

TEST(BoxEntry, WideningAddsFewHits) {
  Random random(16);
  std::vector<Case> cases;
  for (int i = 0; i < 200'000; i++)
    cases.push_back({glm::vec3(-1), glm::vec3(1), glm::vec3(random.point(-4, 4)),
                     glm::vec3(random.direction()), 0, 1e30f});
  const std::vector<float> entries = BoxEntryOnDevice().entriesOf(cases);
  int hits = 0, extra = 0, early = 0;
  for (size_t i = 0; i < cases.size(); i++) {
    const bool met = entries[i] < INFINITY;
    hits += met;
    extra += met && !meetsExactly(cases[i]);
    double enter, exit;
    if (met &&
        twin::boxSpan(cases[i].lo, cases[i].hi, cases[i].origin, cases[i].direction, 0.0, 1e30, enter, exit))
      early += std::fabs(double(entries[i]) - enter) > 3e-7 * enter;
  }
  EXPECT_GT(hits, 10'000);
  EXPECT_LE(extra, hits / 1'000);
  EXPECT_EQ(early, 0);
}

}  // namespace
}  // namespace gxy::test
