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
#include "insitu/plan/encodings.h"
#include "insitu/plan/records.h"
#include "tests/support/seeds.h"

namespace gxy::insitu {
namespace {

Description described() {
  Mesh grid, atoms, surface;
  grid.name = "grid";
  grid.grid = {{1, 2, 3}, {0.5, 0.5, 2}, {8, 9, 10}};
  grid.fields = {{"temperature", ScalarType::Float64, 1}, {"velocity", ScalarType::Float32, 3}};
  atoms.name = "atoms";
  atoms.kind = Mesh::Kind::Points;
  atoms.ids = true;
  atoms.box = {glm::dvec3(0), glm::dvec3(5)};
  atoms.fields = {{"mass", ScalarType::Float64, 1}};
  surface.name = "surface";
  surface.kind = Mesh::Kind::Cells;
  surface.positions = ScalarType::Float32;
  surface.shape = Mesh::Shape::Triangles;
  surface.fields = {{"height", ScalarType::Float64, 1},
                    {"Normals", ScalarType::Float32, 3},
                    {"region", ScalarType::Int16, 1, true}};
  const Box box{glm::dvec3(1), glm::dvec3(2)};
  return {7,
          {grid, atoms, surface},
          {{{{{0, 0, 0}, {8, 9, 5}}, {{0, 0, 5}, {8, 4, 5}}}, {}}, {{}, box}, {{}, box}}};
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
  EXPECT_EQ(read.from, 7u);
  EXPECT_EQ(read.meshes, d.meshes);
  ASSERT_EQ(read.parts.size(), 3u);
  EXPECT_EQ(read.parts[0].blocks, d.parts[0].blocks);
  EXPECT_EQ(read.parts[1].bounds, d.parts[1].bounds);
  EXPECT_EQ(read.parts[2].bounds, d.parts[2].bounds);
}

TEST(Records, OnlySizesOriginsAndSpacingsOfGridsMayChange) {
  const std::vector<Mesh> before = described().meshes;
  const auto refused = [&](const std::function<void(std::vector<Mesh>&)>& change) {
    std::vector<Mesh> now = before;
    change(now);
    return errorOf([&] { checkContinues(before, now); }).find("other meshes or fields than before") !=
           std::string::npos;
  };
  EXPECT_FALSE(refused([](auto&) {}));
  EXPECT_FALSE(refused([](auto& m) {
    m[0].grid.points = {4, 5, 6};
    m[0].grid.origin.y = 9;
    m[0].grid.spacing.z = 3;
  }));
  EXPECT_TRUE(refused([](auto& m) { m[0].grid.rim = !m[0].grid.rim; }));
  EXPECT_TRUE(refused([](auto& m) { m[0].name = "other"; }));
  EXPECT_TRUE(refused([](auto& m) { m[0].fields[0].type = ScalarType::UInt8; }));
  EXPECT_TRUE(refused([](auto& m) { m[0].fields.pop_back(); }));
  EXPECT_TRUE(refused([](auto& m) { m[1].ids = !m[1].ids; }));
  EXPECT_TRUE(refused([](auto& m) { m[1].box.hi.x++; }));
  EXPECT_TRUE(refused([](auto& m) { m.pop_back(); }));
  EXPECT_FALSE(refused([](auto& m) { m[2].shape = Mesh::Shape::Unknown; }));
}

TEST(Records, NormalsAreNoDatasetByThemselves) {
  std::vector<Mesh> meshes{described().meshes[2]};
  const auto names = [&] {
    std::string all;
    for (const Publishes& d : datasetsOf(meshes)) all += d.name + " ";
    return all;
  };
  EXPECT_EQ(names(), "height region ");
  meshes[0].fields = {meshes[0].fields[1]};
  EXPECT_EQ(names(), "surface ");
  meshes[0].fields[0].components = 2;
  EXPECT_EQ(names(), "Normals ");
}

TEST(Records, RanksAgreeAboutMeshesAndWhatCellsBecome) {
  const std::vector<Mesh> all = described().meshes;
  std::vector<Mesh> known = all, others = all;
  known[2].shape = Mesh::Shape::Unknown;
  mergeMeshes(known, others, 1);
  EXPECT_EQ(known, all) << "a rank with cells says what they are";
  others[2].shape = Mesh::Shape::Unknown;
  mergeMeshes(known, others, 2);
  EXPECT_EQ(known, all) << "a rank without them says nothing";
  others[2].shape = Mesh::Shape::Lines;
  EXPECT_EQ(
      errorOf([&] { mergeMeshes(known, others, 3); }),
      "cells \"surface\": rank 3 has lines, and a rank before has triangles, expected the same on all ranks");
  others = all;
  others[2].fields[2].ofCells = false;
  EXPECT_NE(errorOf([&] { mergeMeshes(known, others, 3); }).find("rank 3 has other meshes or fields"),
            std::string::npos);
  EXPECT_EQ(known, all);
}

TEST(Records, WrongDescriptionsSayWhatWasExpected) {
  expectRefused([](Description& d) { d.from = 0; }, "from publish 0, expected 1 or more");
  expectRefused([](Description& d) { d.meshes[0].grid.points[1] = 1; }, "expected 2 to 2^31 by axis");
  expectRefused([](Description& d) { d.meshes[0].grid.points = {1 << 30, 1 << 30, 1 << 30}; }, "2^46 in all");
  expectRefused([](Description& d) { d.meshes[0].grid.spacing[2] = 0; }, "a spacing above 0");
  expectRefused([](Description& d) { d.meshes[0].grid.origin[2] = std::nan(""); }, "finite numbers");
  expectRefused([](Description& d) { d.meshes[0].fields.clear(); }, "0 fields, expected 1 to 64");
  expectRefused([](Description& d) { d.meshes[0].fields[1].name = "temperature"; }, "is there twice");
  expectRefused([](Description& d) { d.meshes[0].fields[1].type = ScalarType(10); },
                "type 10, expected 0 to 9");
  expectRefused([](Description& d) { d.meshes[0].fields[1].components = 17; }, "expected 1 to 16");
  expectRefused([](Description& d) { d.meshes[0].fields[1].components = 0; }, "expected 1 to 16");
  expectRefused([](Description& d) { d.meshes[0].name = "a\nb"; }, "control characters");
  expectRefused([](Description& d) { d.meshes[0].name = "\xff"; }, "no text");
  expectRefused([](Description& d) { d.parts[0].blocks[1].first[2] = 6; }, "inside the grid");
  expectRefused([](Description& d) { d.parts[0].blocks[1].first[2] = -1; }, "inside the grid");
  expectRefused([](Description& d) { d.parts[0].blocks[1].points[2] = INT64_MAX; }, "inside the grid");
  expectRefused([](Description& d) { d.parts[0].blocks[1].points[0] = 0; }, "inside the grid");
  expectRefused([](Description& d) { d.meshes[1].name = "grid"; }, "mesh \"grid\" is there twice");
  expectRefused([](Description& d) { d.meshes[1].fields[0].name = "velocity"; },
                "two meshes have \"velocity\"");
  expectRefused(
      [](Description& d) {
        d.meshes[1].fields.clear();
        d.meshes[1].name = "velocity";
      },
      "two meshes have \"velocity\"");
  expectRefused([](Description& d) { d.meshes[1].positions = ScalarType::Int32; },
                "points \"atoms\": positions of type 4, expected float32 or float64");
  expectRefused([](Description& d) { d.meshes[2].positions = ScalarType::Int32; },
                "cells \"surface\": positions of type 4, expected float32 or float64");
  expectRefused([](Description& d) { d.meshes[2].shape = Mesh::Shape(4); },
                "shape 4 of cells, expected 0 to 3");
  expectRefused([](Description& d) { d.meshes[2].kind = Mesh::Kind(3); },
                "kind 3 of a mesh, expected 0 to 2");
  expectRefused([](Description& d) { d.meshes[2].fields[2].name = "height"; }, "is there twice");
  expectRefused([](Description& d) { d.meshes[1].box.lo.x = 6; }, "the box is not finite");
  expectRefused([](Description& d) { d.meshes[1].box.hi.x = INFINITY; }, "the box is not finite");
  expectRefused([](Description& d) { d.parts[1].bounds.hi.y = std::nan(""); }, "the box is not finite");
  expectRefused(
      [](Description& d) {
        d.meshes.clear();
        d.parts.clear();
      },
      "0 meshes, expected 1 to 16");
}

TEST(Records, PlansOutsideTheBlocksOfARankAreRefused) {
  const Description mine = described();
  const std::vector<Destination> plan{
      {1, {{3, 0, 1, 7, {{0, 0, 1}, {8, 9, 4}}, 0}, {3, 0, 1, -1, {}, 1}, {3, 0, 1, -1, {}, 2}}},
      {2, {{3, 1, 2, 8, mine.parts[0].blocks[1], 0}}}};
  const auto read = [&](const Bytes& message) {
    std::span<const std::byte> rest = message;
    EXPECT_EQ(takeFrom(rest), 12);
    return readDestinations(rest, 3, mine);
  };
  EXPECT_EQ(read(written(12, plan)), plan);
  const auto expectRefused = [&](const std::function<void(std::vector<Destination>&)>& change) {
    auto other = plan;
    change(other);
    EXPECT_NE(errorOf([&] { read(written(12, other)); }), "");
  };
  expectRefused([](auto& p) { p[1].pieces[0].block = 2; });
  expectRefused([](auto& p) { p[1].pieces[0].points.points[1]++; });
  expectRefused([](auto& p) { p[1].pieces[0].mesh = 3; });
  expectRefused([](auto& p) { p[1].pieces[0].mesh = 2; });
  expectRefused([](auto& p) { p[1].pieces[0].mesh = 1; });
  expectRefused([](auto& p) { p[0].pieces[1].block = 1; });
  expectRefused(
      [](auto& p) { p[1].pieces.push_back(p[0].pieces[1]); });  // the particles, to another rank as well
  expectRefused([](auto& p) { p[1].pieces.push_back(p[0].pieces[2]); });  // the cells
}

TEST(Records, ItemsAreTheArraysOfPieces) {
  const Description d = described();
  const std::vector<Piece> pieces{
      {0, 0, 0, 0, {{0, 0, 0}, {2, 3, 4}}, 0}, {0, 0, 0, -1, {}, 1}, {0, 0, 0, -1, {}, 2}};
  const std::vector<Item> items = itemsOf(pieces, d.meshes);
  ASSERT_EQ(items.size(), 12u);
  EXPECT_EQ(items[0].points, 24u);
  EXPECT_EQ(items[0].number, -1);
  EXPECT_EQ(items[1].bytesPerPoint, 12u);
  EXPECT_EQ(items[2].bytesPerPoint, 24u) << "positions";
  EXPECT_TRUE(items[2].first);
  EXPECT_EQ(items[3].bytesPerPoint, 8u) << "ids";
  EXPECT_FALSE(items[3].first);
  EXPECT_EQ(items[4].number, int(placeOf(1, Per::Point)));
  const uint64_t bytes[] = {12, 8, 12, 1,
                            4,  2, 4};  // positions, height, Normals; types, ends, region; connectivity
  for (size_t i = 0; i < 7; i++) {
    EXPECT_EQ(items[5 + i].bytesPerPoint, bytes[i]);
    EXPECT_EQ(items[5 + i].number, int(placeOf(2, i < 3 ? Per::Point : i < 6 ? Per::Cell : Per::Corner)));
    EXPECT_EQ(items[5 + i].first, i == 0 || i == 3 || i == 6) << "its header says how many there are";
  }
}

TEST(Records, SteeredParametersAreReadAsWritten) {
  const Steering steering{{"dt", 0.5}, {"gas", -1e300}};
  EXPECT_EQ(readSteering(written(steering)), steering);
  EXPECT_THROW(readSteering(written(Steering{{"dt", std::nan("")}})), Error);
  Steering many;
  for (int i = 0; i < 65; i++) many[std::to_string(i)] = 1;
  EXPECT_THROW(readSteering(written(many)), Error);
}

TEST(Records, AHelloSaysWhichChecksumsThereAre) {
  Hello hello{5, {}, 3, Checksum::Crc32c};
  EXPECT_EQ(readHello(written(hello)).checksum, Checksum::Crc32c);
  hello.checksum = Checksum::None;
  EXPECT_EQ(readHello(written(hello)).checksum, Checksum::None);
  hello.checksum = Checksum(2);
  EXPECT_NE(errorOf([&] { readHello(written(hello)); }).find("checksum 2, expected 0 or 1"),
            std::string::npos);
}

TEST(Records, EncodingsAreReadAsWrittenAndOnlyOfDoublesOfGrids) {
  std::vector<Mesh> meshes = described().meshes;
  meshes[0].fields.push_back({"flow", ScalarType::Float64, 3});
  const Encodings encodings{{0, 0, 101325, 1}, {0, 2, 0, 0x1p-70}};
  EXPECT_EQ(readEncodings(written(encodings), meshes), encodings);
  EXPECT_EQ(readEncodings(written(Encodings()), meshes), Encodings());
  const std::vector<Mesh> sent = encoded(meshes, encodings);
  EXPECT_EQ(sent[0].fields[0].type, ScalarType::Float32);
  EXPECT_EQ(sent[0].fields[2].type, ScalarType::Float32);
  EXPECT_EQ(sent[1], meshes[1]);
  const auto refused = [&](const Encodings& wrong) {
    return !errorOf([&] { readEncodings(written(wrong), meshes); }).empty();
  };
  EXPECT_TRUE(refused({{0, 1, 0, 1}})) << "floats";
  EXPECT_TRUE(refused({{0, 3, 0, 1}})) << "no such field";
  EXPECT_TRUE(refused({{3, 0, 0, 1}})) << "no such mesh";
  EXPECT_TRUE(refused({{1, 0, 0, 1}})) << "doubles of particles";
  EXPECT_TRUE(refused({{0, 0, 0, 1}, {0, 0, 0, 1}})) << "twice";
  EXPECT_TRUE(refused({{0, 2, 5, 1}})) << "a vector with a shift";
  for (const double scale : {0.0, -1.0, 3.0, 0x1p-1060, double(INFINITY), double(NAN)})
    EXPECT_TRUE(refused({{0, 0, 0, scale}})) << scale;
  for (const double shift : {double(INFINITY), double(NAN)}) EXPECT_TRUE(refused({{0, 0, shift, 1}}));
}

TEST(Records, BytesThatNobodyWroteAreRefusedOrReadWithoutHarm) {
  Random random(1);
  const Description mine = described();
  for (int i = 0; i < test::sweep(20000); i++) {
    Bytes bytes = written(described());
    bytes.resize(random.below(bytes.size() + 1));
    for (uint64_t n = random.below(4); n > 0 && !bytes.empty(); n--)
      bytes[random.below(bytes.size())] = std::byte(random.below(256));
    errorOf([&] { readDescription(bytes); });
    errorOf([&] {
      std::span<const std::byte> rest = bytes;
      takeFrom(rest);
      readDestinations(rest, 0, mine);
    });
    errorOf([&] { readControl(bytes); });
    errorOf([&] { readStep(bytes); });
    errorOf([&] { readHello(bytes); });
    errorOf([&] { readSteering(bytes); });
  }
}

}  // namespace
}  // namespace gxy::insitu
