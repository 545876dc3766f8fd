// SPDX-License-Identifier: Apache-2.0
// Messages that are read as they were written, and those that are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "core/comm/error.h"
#include "core/comm/random.h"
#include "core/comm/wire.h"
#include "insitu/plan/description.h"
#include "insitu/plan/records.h"

namespace gxy::insitu {
namespace {

Description described() {
  Description d;
  d.mesh.name = "grid";
  d.mesh.grid = {{1, 2, 3}, {0.5, 0.5, 2}, {8, 9, 10}};
  d.mesh.fields = {{"temperature", ScalarType::Float64, 1}, {"velocity", ScalarType::Float32, 3}};
  d.blocks = {{{0, 0, 0}, {8, 9, 5}}, {{0, 0, 5}, {8, 4, 5}}};
  return d;
}

std::string errorOf(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

void expectRefused(const std::function<void(Description&)>& change, const std::string& why) {
  Description d = described();
  change(d);
  const std::string error = errorOf([&] { readDescription(written(d)); });
  EXPECT_NE(error.find(why), std::string::npos) << "found: " << error;
}

TEST(Records, DescriptionsAreReadAsWritten) {
  const Description d = described(), read = readDescription(written(d));
  EXPECT_EQ(read.mesh, d.mesh);
  EXPECT_EQ(read.blocks, d.blocks);
}

TEST(Records, WrongDescriptionsSayWhatWasExpected) {
  expectRefused([](Description& d) { d.mesh.grid.points[1] = 1; }, "expected 2 to 2^31 by axis");
  expectRefused([](Description& d) { d.mesh.grid.points = {1 << 30, 1 << 30, 1 << 30}; }, "2^46 in all");
  expectRefused([](Description& d) { d.mesh.grid.spacing[2] = 0; }, "a spacing above 0");
  expectRefused([](Description& d) { d.mesh.grid.origin[2] = std::nan(""); }, "finite numbers");
  expectRefused([](Description& d) { d.mesh.fields.clear(); }, "0 fields, expected 1 to 64");
  expectRefused([](Description& d) { d.mesh.fields[1].name = "temperature"; }, "is there twice");
  expectRefused([](Description& d) { d.mesh.fields[1].type = ScalarType(10); }, "type 10, expected 0 to 9");
  expectRefused([](Description& d) { d.mesh.fields[1].components = 17; }, "expected 1 to 16");
  expectRefused([](Description& d) { d.mesh.fields[1].components = 0; }, "expected 1 to 16");
  expectRefused([](Description& d) { d.mesh.name = "a\nb"; }, "control characters");
  expectRefused([](Description& d) { d.mesh.name = "\xff"; }, "no text");
  expectRefused([](Description& d) { d.blocks[1].first[2] = 6; }, "inside the grid");
  expectRefused([](Description& d) { d.blocks[1].first[2] = -1; }, "inside the grid");
  expectRefused([](Description& d) { d.blocks[1].points[2] = INT64_MAX; }, "inside the grid");
  expectRefused([](Description& d) { d.blocks[1].points[0] = 0; }, "inside the grid");
}

TEST(Records, PlansOutsideTheBlocksOfARankAreRefused) {
  const std::vector<Extent> blocks = described().blocks;
  std::vector<Destination> plan{{1, {{3, 0, 1, 7, {{0, 0, 1}, {8, 9, 4}}}}}, {2, {{3, 1, 2, 8, blocks[1]}}}};
  EXPECT_EQ(readDestinations(written(plan), 3, blocks), plan);
  plan[1].pieces[0].block = 2;
  EXPECT_NE(errorOf([&] { readDestinations(written(plan), 3, blocks); }), "");
  plan[1].pieces[0].block = 1;
  plan[1].pieces[0].points.points[1]++;
  EXPECT_NE(errorOf([&] { readDestinations(written(plan), 3, blocks); }), "");
}

TEST(Records, BytesThatNobodyWroteAreRefusedOrReadWithoutHarm) {
  Random random(1);
  const std::vector<Extent> blocks = described().blocks;
  for (int i = 0; i < 20000; i++) {
    Bytes bytes = written(described());
    bytes.resize(random.below(bytes.size() + 1));
    for (uint64_t n = random.below(4); n > 0 && !bytes.empty(); n--)
      bytes[random.below(bytes.size())] = std::byte(random.below(256));
    errorOf([&] { readDescription(bytes); });
    errorOf([&] { readDestinations(bytes, 0, blocks); });
    errorOf([&] { readControl(bytes); });
    errorOf([&] { readStep(bytes); });
    errorOf([&] { readHello(bytes); });
  }
}

}  // namespace
}  // namespace gxy::insitu
