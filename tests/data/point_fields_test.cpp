// SPDX-License-Identifier: Apache-2.0
// Further fields at the points of geometry: what keeps them, and which of them is shown.
#include "core/data/point_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "core/comm/error.h"
#include "core/data/cells.h"
#include "core/data/geometry_bytes.h"
#include "core/data/shown_array.h"

namespace gxy {
namespace {

/// A fan of triangles that share points; the field `velocity` of point i is (i, 2 i, -i).
GeometryBlock fan(uint32_t triangles) {
  GeometryBlock block;
  PointField velocity{"velocity", 3, {}}, age{"age", 1, {}};
  for (uint32_t i = 0; i < triangles + 2; i++) {
    block.points.push_back({std::cos(i * 0.1), std::sin(i * 0.1), i == 0 ? 1.0 : 0.0});
    block.values.push_back(float(i) / 2);
    velocity.values.insert(velocity.values.end(), {float(i), 2 * float(i), -float(i)});
    age.values.push_back(float(10 * i));
  }
  block.fields = {velocity, age};
  for (uint32_t i = 0; i < triangles; i++) {
    block.triangles.push_back({0, i + 1, i + 2});
    block.ids.push_back(i);
  }
  return block;
}

std::string fieldError(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

std::shared_ptr<const OwnedGeometry> ownedFan(GeometryBlock block) {
  auto geometry = std::make_shared<OwnedGeometry>();
  geometry->kind = GeometryKind::Triangles;
  geometry->array = "half";
  geometry->range = rangeOf(block);
  for (const PointField& f : block.fields) {
    PointFieldInfo info{f.name, f.components, std::vector<Range>(partsOf(f.components))};
    for (size_t i = 0; i < block.points.size(); i++) {
      for (int c = 0; c < f.components; c++) info.ranges[size_t(c)].extend(double(fieldValue(f, c, i)));
      info.ranges.back().extend(double(fieldValue(f, -1, i)));
    }
    geometry->fields.push_back(std::move(info));
  }
  geometry->block = std::move(block);
  return geometry;
}

TEST(PointFields, ASubsetHasThoseOfItsPoints) {
  const GeometryBlock all = fan(9);
  const std::vector<uint32_t> some{7, 2};
  const GeometryBlock part = subset(all, GeometryKind::Triangles, some);
  ASSERT_EQ(part.points.size(), 5u);
  EXPECT_EQ(part.fields[0].values, (std::vector<float>{0, 0, 0, 8, 16, -8, 9, 18, -9, 3, 6, -3, 4, 8, -4}));
  EXPECT_EQ(part.fields[1].values, (std::vector<float>{0, 80, 90, 30, 40}));
  EXPECT_EQ(part.fields[0].name, "velocity");
}

TEST(PointFields, MergedDoesNotDependOnOrderAndSpread) {
  const GeometryBlock all = fan(200);
  const GeometryBlock expected = merged(GeometryKind::Triangles, std::vector{all});
  ASSERT_EQ(expected.fields[0].values.size(), 3 * expected.points.size());
  std::mt19937 random(3);
  for (int round = 0; round < 20; round++) {
    std::vector<std::vector<uint32_t>> which(1 + random() % 5);
    for (uint32_t p = 0; p < all.ids.size(); p++) which[random() % which.size()].push_back(p);
    std::vector<GeometryBlock> parts;
    for (auto& list : which) {
      std::shuffle(list.begin(), list.end(), random);
      parts.push_back(subset(all, GeometryKind::Triangles, list));
    }
    ASSERT_EQ(merged(GeometryKind::Triangles, parts), expected) << round;
  }
}

TEST(PointFields, PointsThatDifferInAFieldAloneStayTwo) {
  std::vector<GeometryBlock> parts{fan(1), fan(1)};
  parts[1].ids = {1};
  EXPECT_EQ(merged(GeometryKind::Triangles, parts).points.size(), 3u);
  parts[1].fields[0].values[4] = 7;
  const GeometryBlock made = merged(GeometryKind::Triangles, parts);
  ASSERT_EQ(made.points.size(), 4u);
  EXPECT_EQ(made.fields[0].values[10], 7);
}

TEST(PointFields, APointThatRepeatsAnotherInAllOfThemIsDropped) {
  GeometryBlock line;
  line.points.assign(4, {1, 2, 3});
  line.points[0].x = line.points[3].x = 0;
  line.fields = {{"time", 1, {0, 1, 1, 2}}};
  const std::vector<uint32_t> along{0, 1, 2, 3};
  appendLine(along, line);
  line.ids = {0, 1, 2};
  GeometryBlock other = line;
  EXPECT_EQ(dropUnusable(line, GeometryKind::PathLines), 1);
  EXPECT_EQ(line.fields[0].values, (std::vector<float>{0, 1, 2, 1})) << "in order of first use";
  other.fields[0].values[2] = 1.5;
  EXPECT_EQ(dropUnusable(other, GeometryKind::PathLines), 0) << "time goes on there";
}

TEST(PointFields, BlocksWithOtherFieldsAreNotMerged) {
  for (const auto& change : std::vector<std::function<void(GeometryBlock&)>>{
           [](GeometryBlock& b) { b.fields.clear(); }, [](GeometryBlock& b) { b.fields[1].name = "other"; },
           [](GeometryBlock& b) { std::swap(b.fields[0], b.fields[1]); }}) {
    std::vector<GeometryBlock> parts{fan(2), fan(2)};
    parts[1].ids = {2, 3};
    change(parts[1]);
    EXPECT_EQ(fieldError([&] { merged(GeometryKind::Triangles, parts); }),
              "triangles: parts have different fields, expected the same names and components");
  }
}

TEST(PointFields, WhatCannotBeIsRefused) {
  const auto error = [](const std::function<void(GeometryBlock&)>& change) {
    GeometryBlock block = fan(2);
    change(block);
    return fieldError([&] { validate(block, GeometryKind::Triangles); });
  };
  EXPECT_EQ(error([](GeometryBlock&) {}), "");
  EXPECT_EQ(error([](GeometryBlock& b) { b.fields[0].values.pop_back(); }),
            "triangles: field \"velocity\" of points has 11 values, expected 12");
  EXPECT_EQ(error([](GeometryBlock& b) { b.fields[1].name = "velocity"; }),
            "triangles: field \"velocity\" of points is there twice, expected different names");
  EXPECT_EQ(error([](GeometryBlock& b) { b.fields[1].name = ""; }),
            "triangles: field 1 of points has no name");
  for (const int components : {0, -3, kMostPointComponents + 1, std::numeric_limits<int>::min()})
    EXPECT_NE(
        error([&](GeometryBlock& b) { b.fields[1].components = components; }).find("expected 1 to 1024"),
        std::string::npos);
  EXPECT_NE(error([](GeometryBlock& b) {
              for (size_t f = 0; f < kMostPointFields; f++)
                b.fields.push_back({"f" + std::to_string(f), 1, std::vector<float>(4)});
            }).find("258 fields of points, expected at most 256"),
            std::string::npos);
}

TEST(PointFields, AMessageHasThemAndNoShorterOneIsRead) {
  const GeometryBlock block = fan(3);
  Writer writer;
  write(writer, block);
  const Bytes message = writer.take();
  Reader whole(message, "a block");
  EXPECT_EQ(readBlock(whole), block);
  EXPECT_NO_THROW(whole.expectEnd());
  for (size_t size = 0; size < message.size(); size++) {
    const Bytes shorter(message.begin(), message.begin() + std::ptrdiff_t(size));
    Reader reader(shorter, "a block");
    EXPECT_THROW(readBlock(reader), Error) << size;
  }
}

TEST(PointFields, AHostileMessageIsAnErrorOrABlockThatValidateSees) {
  const GeometryBlock block = fan(3);
  Writer writer;
  write(writer, block);
  const Bytes message = writer.take();
  std::mt19937 random(11);
  int refused = 0;
  for (int round = 0; round < 20000; round++) {
    Bytes changed = message;
    for (int n = 1 + int(random() % 3); n > 0; n--)
      changed[random() % changed.size()] = std::byte(random() % 4 ? random() : 0xff);
    try {
      Reader reader(changed, "a block");
      const GeometryBlock read = readBlock(reader);
      validate(read, GeometryKind::Triangles);
      ASSERT_EQ(subset(read, GeometryKind::Triangles, std::vector<uint32_t>{0}).fields.size(),
                read.fields.size());
    } catch (const Error&) {
      refused++;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_LT(refused, 20000);
}

TEST(PointFields, TheirMemoryCounts) {
  GeometryBlock block = fan(3);
  const int64_t all = bytesOf(block);
  block.fields.clear();
  EXPECT_EQ(all - bytesOf(block), int64_t(5 * 4 * sizeof(float)));
}

TEST(ShownArray, IsAFieldItsMagnitudeOrAComponent) {
  const auto geometry = ownedFan(fan(2));
  const auto values = [&](const ShownArray& shown) {
    const auto made = geometryToShow(geometry, shown, "d");
    EXPECT_TRUE(made->block.fields.empty());
    EXPECT_EQ(made->block.triangles, geometry->block.triangles);
    EXPECT_EQ(made->range, rangeOf(made->block));
    EXPECT_EQ(made->range, rangeOfShown(*geometry, shown, "d"));
    return made->block.values;
  };
  const float six = std::sqrt(6.0F);
  EXPECT_EQ(values({"age", {}}), (std::vector<float>{0, 10, 20, 30}));
  EXPECT_EQ(values({"velocity", 1}), (std::vector<float>{0, 2, 4, 6}));
  const std::vector<float> magnitude = values({"velocity", {}});
  for (size_t i = 0; i < 4; i++) EXPECT_NEAR(magnitude[i], float(i) * six, 1e-6);
  for (const ShownArray& own : {ShownArray{}, ShownArray{"half", {}}, ShownArray{"half", 0}})
    EXPECT_EQ(values(own), geometry->block.values);
  EXPECT_GT(bytesToShow(*geometry, {"age", {}}), 0);
}

TEST(ShownArray, GeometryWithoutFurtherFieldsIsTheSameObject) {
  GeometryBlock block = fan(2);
  block.fields.clear();
  const auto geometry = ownedFan(block);
  EXPECT_EQ(geometryToShow(geometry, {}, "d"), geometry);
  EXPECT_EQ(geometryToShow(geometry, {"half", {}}, "d"), geometry);
  EXPECT_EQ(bytesToShow(*geometry, {}), 0);
}

TEST(ShownArray, AFieldIsShownInPlaceOfColours) {
  GeometryBlock block = fan(2);
  block.values.clear();
  block.colors.assign(block.points.size(), {1, 0, 0.5});
  auto geometry = std::make_shared<OwnedGeometry>(*ownedFan(block));
  geometry->colored = true;
  geometry->array = "RGB";
  EXPECT_EQ(geometryToShow(geometry, {}, "d")->block.colors.size(), 4u);
  const auto shown = geometryToShow(geometry, {"age", {}}, "d");
  EXPECT_TRUE(shown->block.colors.empty());
  EXPECT_FALSE(shown->colored);
  EXPECT_NO_THROW(validate(shown->block, GeometryKind::Triangles));
}

TEST(ShownArray, AnUnknownOneIsAnErrorThatListsWhatThereIs) {
  const auto geometry = ownedFan(fan(2));
  EXPECT_EQ(fieldError([&] {
              geometryToShow(geometry, {"pressure", {}}, "flow");
            }),
            "dataset \"flow\": there is no array \"pressure\" of points; expected one of those there are: "
            "\"half\", "
            "\"velocity\" (3 components), \"age\"");
  EXPECT_EQ(fieldError([&] {
              geometryToShow(geometry, {"velocity", 3}, "flow");
            }),
            "dataset \"flow\": component 3 of array \"velocity\" was asked for, it has 3 (counted from 0)");
  EXPECT_NE(fieldError([&] {
              geometryToShow(std::make_shared<OwnedGeometry>(), {"x", {}}, "flow");
            }).find("none"),
            std::string::npos);
}

}  // namespace
}  // namespace gxy
