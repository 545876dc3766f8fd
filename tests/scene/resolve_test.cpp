// SPDX-License-Identifier: Apache-2.0
// What a state asks of the data: ranges, radii, viewpoints.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "core/scene/camera.h"
#include "core/scene/resolve.h"

namespace gxy {
namespace {

/// The box of a box's corners in the picture: from -1 to 1 along both sides.
Box inPicture(const Camera& camera, const Box& box) {
  const CameraBasis basis = cameraBasis(camera);
  const glm::dvec3 right = glm::normalize(basis.du), up = glm::normalize(basis.dv);
  const double width = glm::length(basis.du) * camera.dimensions.x / 2;
  const double height = glm::length(basis.dv) * camera.dimensions.y / 2;
  Box seen;
  for (int i = 0; i < 8; i++) {
    const glm::dvec3 p(i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z);
    const double depth = glm::dot(p - basis.eye, basis.view);
    EXPECT_GT(depth, 0);
    const double scale = basis.orthographic ? 1 : depth;
    seen.extend(
        {glm::dot(p - basis.eye, right) / scale / width, glm::dot(p - basis.eye, up) / scale / height, 0});
  }
  return seen;
}

TEST(Fitted, BoxIsCentredAndSpansItsPartOfThePicture) {
  for (const double aov : {0.0, 1.0, 30.0, 60.0})
    for (const glm::ivec2 size : {glm::ivec2(512, 512), glm::ivec2(640, 200), glm::ivec2(200, 640)})
      for (const glm::dvec3 direction : {glm::dvec3(0, 0, -1), glm::dvec3(-1, -2, -3), glm::dvec3(5, 1, 0)})
        for (const Box& box :
             {Box{{-1, -1, -1}, {1, 1, 1}}, Box{{1e6, 0, 0}, {1e6 + 10, 1, 3}}, Box{{0, 0, 5}, {1, 2, 5}}}) {
          Camera camera;
          camera.fit = true;
          camera.aov = aov;
          camera.dimensions = size;
          camera.viewdirection = direction;
          const Camera at = fitted(camera, box);
          EXPECT_FALSE(at.fit);
          EXPECT_EQ(at.viewdirection, direction);
          const Box seen = inPicture(at, box);
          const double across = std::max(seen.hi.x - seen.lo.x, seen.hi.y - seen.lo.y) / 2;
          EXPECT_NEAR(across, kFittedPart, 1e-5);
          EXPECT_LE(std::max({-seen.lo.x, -seen.lo.y, seen.hi.x, seen.hi.y}), 1);
        }
}

TEST(Fitted, CameraWithoutFitStaysAndNoDataAreTheUnitBox) {
  Camera camera;
  camera.viewpoint = {7, 8, 9};
  EXPECT_EQ(fitted(camera, Box{{0, 0, 0}, {1, 1, 1}}), camera);
  camera.fit = true;
  EXPECT_EQ(fitted(camera, Box()), fitted(camera, Box{glm::dvec3(-0.5), glm::dvec3(0.5)}));
}

Visualization asking(VisType type) {
  Visualization v;
  Vis& vis = v.operators.emplace_back();
  vis.type = type;
  vis.rangeOfData = vis.radiusOfData = true;
  return v;
}

TEST(Resolved, RangesAreThoseOfTheDataWidenedAndNeverNarrowed) {
  const Box box{{0, 0, 0}, {1, 1, 1}};
  const auto facts = [&](double min, double max) {
    return std::vector<DataFacts>{{box, box, {{min, max}}, 0}};
  };
  ShownSoFar shown;
  using Ends = std::array<double, 2>;
  const Visualization asked = asking(VisType::Volume);
  EXPECT_EQ(resolved(asked, facts(2, 5), shown).operators[0].dataRange, (Ends{2, 5}));
  EXPECT_EQ(resolved(asked, facts(3, 4), shown).operators[0].dataRange, (Ends{2, 5}));
  EXPECT_EQ(resolved(asked, facts(1, 9), shown).operators[0].dataRange, (Ends{1, 9}));
  ShownSoFar nothing;
  EXPECT_EQ(resolved(asked, std::vector<DataFacts>{{box, box, {Range()}, 0}}, nothing).operators[0].dataRange,
            std::nullopt);
}

TEST(Resolved, ComponentsHaveTheirOwnRanges) {
  const Box box{{0, 0, 0}, {1, 1, 1}};
  const std::vector<DataFacts> facts{{box, box, {{-1, 1}, {-2, 2}, {0, 3}}, 0}};
  Visualization asked = asking(VisType::Volume);
  ShownSoFar magnitude, second;
  EXPECT_EQ((*resolved(asked, facts, magnitude).operators[0].dataRange)[1], 3);
  asked.operators[0].component = 1;
  EXPECT_EQ((*resolved(asked, facts, second).operators[0].dataRange)[0], -2);
}

TEST(Resolved, FieldsOfGeometryHaveTheirOwnRanges) {
  const Box box{{0, 0, 0}, {1, 1, 1}};
  const std::vector<DataFacts> facts{
      {box, box, {{-1, 1}}, 0, {{"velocity", {{-2, 2}, {-3, 3}, {0, 4}}}, {"age", {{5, 6}}}}}};
  const auto rangeFor = [&](const std::string& array, std::optional<int> component) {
    Visualization v;
    v.operators.resize(1);
    v.operators[0].type = VisType::Particles;
    v.operators[0].array = array;
    v.operators[0].component = component;
    v.operators[0].rangeOfData = true;
    ShownSoFar shown;
    return resolved(v, facts, shown).operators[0].dataRange.value();
  };
  EXPECT_EQ(rangeFor("", {}), (std::array<double, 2>{-1, 1}));
  EXPECT_EQ(rangeFor("age", {}), (std::array<double, 2>{5, 6}));
  EXPECT_EQ(rangeFor("velocity", {}), (std::array<double, 2>{0, 4}));
  EXPECT_EQ(rangeFor("velocity", 1), (std::array<double, 2>{-3, 3}));
}

TEST(Resolved, RadiiAreAPartOfTheSpacingAndWidenTheBox) {
  const Box box{{0, 0, 0}, {4, 4, 4}};
  const std::vector<DataFacts> facts{{box, box, {}, 0.5}};
  ShownSoFar shown;
  const Vis vis = resolved(asking(VisType::Particles), facts, shown).operators[0];
  EXPECT_EQ(vis.radius0, 0.15);
  EXPECT_EQ(vis.value0, vis.value1);
  EXPECT_EQ(shown.box, (Box{glm::dvec3(-0.15), glm::dvec3(4.15)}));
  ShownSoFar one;
  const Box point{{3, 3, 3}, {3, 3, 3}};
  EXPECT_EQ(resolved(asking(VisType::Particles), std::vector<DataFacts>{{point, point, {}, 0}}, one)
                .operators[0]
                .radius0,
            1);
}

TEST(Resolved, WhatAsksForNothingStaysAsItIs) {
  Visualization v = asking(VisType::PathLines);
  v.operators[0].rangeOfData = v.operators[0].radiusOfData = false;
  const Box box{{0, 0, 0}, {1, 1, 1}};
  ShownSoFar shown;
  EXPECT_EQ(resolved(v, std::vector<DataFacts>{{box, box, {{0, 1}}, 0.1}}, shown), v);
}

}  // namespace
}  // namespace gxy
