// SPDX-License-Identifier: Apache-2.0
// Module viewer: what a window shows at a pixel.
#include <gtest/gtest.h>

#include <cmath>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/write_geometry.h"
#include "tests/multiserver/viewer_client.h"
#include "tests/support/mesh_files.h"

namespace gxy::test {
namespace {

using nlohmann::json;

// Looks from (0, 0, 4) at 0; the ray of pixel (32, 32) is the z axis.
constexpr const char* kCamera =
    R"("Camera": {"viewpoint": [0, 0, 4], "viewcenter": [0, 0, 0], "viewup": [0, 1, 0], "aov": 30})";

struct Picked {
  explicit Picked(int ranks = 1) : server(serve(ranks)), viewer(*server) {
    viewer.client->expect("window 1 {\"size\": [65, 65]}");
  }
  void show(const std::string& operators) {
    viewer.client->expect("set 1 {\"Visualization\": {\"operators\": [" + operators + "]}, " + kCamera + "}");
  }
  json at(int x, int y) {
    return viewer.client->expect("pick 1 " + std::to_string(x) + " " + std::to_string(y));
  }
  std::unique_ptr<TestServer> server;
  Viewer viewer;
};

void expectNear(const json& vector, std::array<double, 3> expected, double tolerance) {
  for (size_t a = 0; a < 3; a++) EXPECT_NEAR(vector.at(a).get<double>(), expected[a], tolerance) << vector;
}

// The ball's distances from 0 are sampled at -1 + 2 i / 15, so that the z axis is in the middle of cells: there the field is
// linear in z between the distances of its four neighbours. The file says the spacing with six digits: hence kSpacing.
constexpr double kSpacing = 1e-5;
double onAxis(double z) {
  const double i = std::floor((z + 1) * 7.5), w = (z + 1) * 7.5 - i;
  const auto sample = [](double k) { return std::sqrt(2.0 / 225 + std::pow(-1 + 2 * k / 15, 2)); };
  return (1 - w) * sample(i) + w * sample(i + 1);
}

TEST(Pick, AnIsosurfaceIsWhereTheFieldHasItsValue) {
  Picked picked;
  picked.show(R"({"type": "Volume", "dataset": "ball", "isovalues": [0.9, 0.5], "opacity": 0.5})");
  const json hit = picked.at(32, 32);
  EXPECT_EQ(hit.at("hit"), true);
  EXPECT_EQ(hit.at("operator"), 0);
  EXPECT_EQ(hit.at("type"), "Volume");
  EXPECT_EQ(hit.at("dataset"), "ball");
  EXPECT_EQ(hit.at("value"), 0.9);
  EXPECT_NEAR(onAxis(hit.at("point").at(2)), 0.9, kSpacing);
  expectNear(hit.at("point"), {0, 0, 0.9}, 0.02);
  expectNear(hit.at("normal"), {0, 0, 1}, kSpacing);
  EXPECT_EQ(hit.at("text").get<std::string>().find("operator 1, Volume ball, at "), 0u) << hit;
}

TEST(Pick, BesideTheMiddleThePointLiesOnThePixelsRay) {
  Picked picked;
  picked.show(R"({"type": "Volume", "dataset": "ball", "isovalues": [0.5]})");
  const json hit = picked.at(37, 28);
  const auto [x, y, z] = hit.at("point").get<std::array<double, 3>>();
  const double pixel = 2 * std::tan(15 * M_PI / 180) / 65;
  EXPECT_NEAR(x / (4 - z), 5 * pixel, 1e-6);
  EXPECT_NEAR(y / (4 - z), -4 * pixel, 1e-6);
  EXPECT_NEAR(std::sqrt(x * x + y * y + z * z), 0.5, 0.02);
  expectNear(hit.at("normal"), {x / 0.5, y / 0.5, z / 0.5}, 0.05);
}

TEST(Pick, ASliceHasTheFieldsValueAndFacesTheViewer) {
  Picked picked;
  picked.show(R"({"type": "Volume", "dataset": "ball", "slices": [[0, 0, -2, -0.5]]})");
  const json hit = picked.at(32, 32);
  expectNear(hit.at("point"), {0, 0, 0.25}, 1e-6);
  EXPECT_NEAR(hit.at("value").get<double>(), onAxis(0.25), kSpacing);
  expectNear(hit.at("normal"), {0, 0, 1}, 1e-12);
}

TEST(Pick, WhereNoSurfaceIsItSaysSo) {
  Picked picked;
  picked.show(R"({"type": "Volume", "dataset": "ball", "isovalues": [0.5]})");
  const json none = picked.at(0, 0);
  EXPECT_EQ(none.at("hit"), false);
  EXPECT_EQ(none.size(), 2u) << none;
  EXPECT_EQ(none.at("text"), "there is no surface");
}

TEST(Pick, OfTwoHalvesOfTheSameSurfaceTheOneThatIsNotClippedIsFound) {
  Picked picked;
  picked.show(
      R"({"type": "Volume", "dataset": "ball", "isovalues": [0.5], "clip planes": [[1, 0, 0, 0]]},
         {"type": "Volume", "dataset": "ball", "isovalues": [0.5], "clip planes": [[-1, 0, 0, 0]]})");
  EXPECT_EQ(picked.at(37, 32).at("operator"), 0);
  EXPECT_EQ(picked.at(27, 32).at("operator"), 1);
}

// A particle of radius 1/4 in front of (0, 0); a tube of radius 1/8 along x above it, whose values go from 2 to 4; a triangle
// to the right, in the plane z = 1/2, whose values are 10 + x.
void importShapes(Picked& picked) {
  GeometryBlock particle, tube, triangle;
  particle.points = {{0, 0, 0.5}};
  particle.values = {7};
  tube.points = {{-0.5, 0.6, 0.5}, {0.5, 0.6, 0.5}};
  tube.values = {2, 4};
  tube.segments = tube.neighbours = {{0, 1}};
  triangle.points = {{0.4, -0.3, 0.5}, {0.9, -0.3, 0.5}, {0.4, 0.3, 0.5}};
  triangle.values = {10.4f, 10.9f, 10.4f};
  triangle.triangles = {{0, 1, 2}};
  particle.ids = tube.ids = triangle.ids = {0};
  const auto& folder = picked.server->folder();
  writeGeometry(folder / "particle.vtp", particle, GeometryKind::Particles);
  writeGeometry(folder / "tube.vtp", tube, GeometryKind::PathLines);
  writeGeometry(folder / "triangle.vtp", triangle, GeometryKind::Triangles);
  picked.viewer.client->expect(R"(import like ball {"Datasets": [
      {"name": "particle", "type": "Particles", "filename": "particle.vtp"},
      {"name": "tube", "type": "PathLines", "filename": "tube.vtp"},
      {"name": "triangle", "type": "Triangles", "filename": "triangle.vtp"}]})");
  picked.show(R"({"type": "Volume", "dataset": "ball", "slices": [[0, 0, 1, -0.75]]},
      {"type": "Particles", "dataset": "particle", "radius": 0.25},
      {"type": "PathLines", "dataset": "tube", "radius": 0.125},
      {"type": "Triangles", "dataset": "triangle"})");
}

TEST(Pick, GeometryIsFoundWithItsValueThere) {
  Picked picked;
  importShapes(picked);
  const json ball = picked.at(32, 32);
  EXPECT_EQ(ball.at("dataset"), "particle");
  EXPECT_EQ(ball.at("type"), "Particles");
  EXPECT_EQ(ball.at("operator"), 1);
  EXPECT_EQ(ball.at("value"), 7);
  expectNear(ball.at("point"), {0, 0, 0.75}, 1e-6);
  expectNear(ball.at("normal"), {0, 0, 1}, 1e-5);

  const json tube = picked.at(37, 51);
  EXPECT_EQ(tube.at("dataset"), "tube");
  const auto [x, y, z] = tube.at("point").get<std::array<double, 3>>();
  EXPECT_NEAR(std::hypot(y - 0.6, z - 0.5), 0.125, 1e-6);
  EXPECT_NEAR(tube.at("value").get<double>(), 3 + 2 * x, 1e-6);
  expectNear(tube.at("normal"), {0, (y - 0.6) / 0.125, (z - 0.5) / 0.125}, 1e-5);

  const json triangle = picked.at(50, 30);
  EXPECT_EQ(triangle.at("dataset"), "triangle");
  EXPECT_NEAR(triangle.at("point").at(2).get<double>(), 0.5, 1e-6);
  EXPECT_NEAR(triangle.at("value").get<double>(), 10 + triangle.at("point").at(0).get<double>(), 1e-5);
  expectNear(triangle.at("normal"), {0, 0, 1}, 1e-12);

  EXPECT_EQ(picked.at(10, 20).at("dataset"), "ball");
}

TEST(Pick, GeometryHasTheValueOfTheFieldThatIsShown) {
  for (const int ranks : {1, 2}) {
    Picked picked(ranks);
    writeText(picked.server->folder() / "two.csv",
              "x,y,z,mass,age,height\n0,0,0.5,7,3,4\n0.7,0.7,0,8,5,12\n");
    picked.viewer.client->expect(R"(import like ball {"Datasets": {"name": "two", "type": "Particles",
        "filename": "two.csv", "array": "mass", "fields": ["age", "height"]}})");
    for (const auto& [array, value] : {std::pair{"", 7}, std::pair{"age", 3}, std::pair{"height", 4}}) {
      const std::string shown = *array ? R"("array": ")" + std::string(array) + R"(", )" : "";
      picked.show(R"({"type": "Particles", "dataset": "two", )" + shown + R"("radius": 0.25})");
      EXPECT_EQ(picked.at(32, 32).at("value"), value) << array;
      // A radius that follows the value is that of the shown one, too.
      picked.show(R"({"type": "Particles", "dataset": "two", )" + shown +
                  R"("radius0": 0, "radius1": 0.5, "value0": 0, "value1": )" + std::to_string(2 * value) +
                  "}");
      expectNear(picked.at(32, 32).at("point"), {0, 0, 0.75}, 1e-6);
      EXPECT_EQ(picked.at(32, 32).at("value"), value) << array;
    }
  }
}

TEST(Pick, GeometryInColoursOfItsOwnIsFoundWithoutAValue) {
  Picked picked;
  const std::string text =
      "v -0.5 -0.5 0 1 0 0\nv 0.5 -0.5 0 0 1 0\nv -0.5 0.5 0 0 0 1\nv 0.5 0.5 0 1 1 1\nf 1 2 3\nf 2 4 3\n";
  writeText(picked.server->folder() / "square.obj", text);
  picked.viewer.client->expect(
      R"(import like ball {"Datasets": {"name": "square", "type": "Triangles", "filename": "square.obj"}})");
  picked.show(R"({"type": "Triangles", "dataset": "square", "data range": "data"})");
  const json hit = picked.at(33, 31);
  EXPECT_EQ(hit.at("dataset"), "square");
  EXPECT_TRUE(hit.at("value").is_null()) << hit;
  expectNear(hit.at("normal"), {0, 0, 1}, 1e-12);
}

// A cube whose values are those of z, as one hexahedron and as six tetrahedra.
TEST(Pick, SurfacesOfUnstructuredVolumesAreFoundInTheirCells) {
  GridFile cube;
  for (int k = 0; k < 8; k++)
    cube.points.emplace_back((k ^ k >> 1) & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5);
  std::vector<double> values;
  for (const glm::dvec3& p : cube.points) values.push_back(10 + p.z);
  cube.pointArrays = {{"height", "Float32", 1, values}};
  GridFile split = cube;
  cube.cells = {{12, {0, 1, 2, 3, 4, 5, 6, 7}}};
  const std::array<uint32_t, 7> around{1, 2, 3, 7, 4, 5, 1};
  for (size_t k = 0; k < 6; k++) split.cells.push_back({10, {0, around[k], around[k + 1], 6}});
  for (const GridFile& file : {cube, split}) {
    Picked picked;
    writeText(picked.server->folder() / "cube.vtu", file.vtu());
    picked.viewer.client->expect(
        R"(import like ball {"Datasets": {"name": "cube", "type": "Volume", "filename": "cube.vtu"}})");
    picked.show(
        R"({"type": "Volume", "dataset": "cube", "isovalues": [10.25], "slices": [[1, 0, 0, 0.125]]})");
    json hit = picked.at(32, 32);
    EXPECT_EQ(hit.at("dataset"), "cube");
    EXPECT_EQ(hit.at("value"), 10.25);
    expectNear(hit.at("point"), {0, 0, 0.25}, 1e-5);
    expectNear(hit.at("normal"), {0, 0, 1}, 1e-5);  // it faces the viewer
    picked.show(R"({"type": "Volume", "dataset": "cube", "slices": [[1, 0, 4, 0.5]]})");
    hit = picked.at(32, 32);
    expectNear(hit.at("point"), {0, 0, 0.125}, 1e-5);
    EXPECT_NEAR(hit.at("value").get<double>(), 10.125, 1e-5);
    EXPECT_EQ(picked.at(2, 2).at("hit"), false);
  }
}

// Two cubes beside each other with the values 2 and 3.
TEST(Pick, CellsHaveTheirOwnValues) {
  GridFile cubes;
  for (int k = 0; k < 12; k++) cubes.points.emplace_back(0.75 * (k % 3 - 1), k / 3 % 2 - 0.5, k / 6 - 0.5);
  for (const uint32_t x : {0u, 1u})
    cubes.cells.push_back({12, {x, x + 1, x + 4, x + 3, x + 6, x + 7, x + 10, x + 9}});
  cubes.cellArrays = {{"count", "Int32", 1, {2, 3}}};
  Picked picked;
  writeText(picked.server->folder() / "cubes.vtu", cubes.vtu());
  picked.viewer.client->expect(
      R"(import like ball {"Datasets": {"name": "cubes", "type": "Volume", "filename": "cubes.vtu"}})");
  EXPECT_EQ(picked.viewer.client->expect("info cubes").at("datasets").at(0).at("mesh").at("values"), "cells");
  picked.show(R"({"type": "Volume", "dataset": "cubes", "slices": [[0, 0, 1, 0.25]]})");
  EXPECT_EQ(picked.at(27, 32).at("value"), 2);
  EXPECT_EQ(picked.at(37, 32).at("value"), 3);
  picked.show(R"({"type": "Volume", "dataset": "cubes", "slices": [[0, 0, 1, 0.25]], "cells": "smooth"})");
  const json hit = picked.at(37, 32);
  EXPECT_NEAR(hit.at("value").get<double>(), 2.5 + 0.5 / 0.75 * hit.at("point").at(0).get<double>(), 1e-5);
  const std::string warned =
      picked.viewer.client
          ->expect(R"(set 1 {"Visualization": {"operators": [{"type": "Volume", "dataset": "cubes",
      "isovalues": [2.5]}]}})")
          .at("text");
  EXPECT_NE(warned.find("isosurfaces are those of averages at points"), std::string::npos) << warned;
}

TEST(Pick, TwoRanksAnswerAsOneDoes) {
  Picked one(1), two(2);
  importShapes(one);
  importShapes(two);
  for (int y = 0; y < 65; y += 8)
    for (int x = 0; x < 65; x += 8) EXPECT_EQ(one.at(x, y), two.at(x, y)) << x << " " << y;
}

TEST(Pick, WhatIsNoPixelOfTheWindowIsAnError) {
  Picked picked;
  const auto error = [&](const std::string& request) {
    const Reply reply = picked.viewer.client->request(request);
    EXPECT_FALSE(reply.ok) << request;
    return reply.error;
  };
  EXPECT_EQ(error("pick 1 65 0"), "pick: pixel 65 0: expected one of 0 0 to 64 64");
  EXPECT_EQ(error("pick 1 0 -1"), "pick: pixel 0 -1: expected one of 0 0 to 64 64");
  EXPECT_NE(error("pick 1 1.5 2").find("X and Y are integers"), std::string::npos);
  EXPECT_NE(error("pick 1 1").find("X and Y are integers"), std::string::npos);
  EXPECT_NE(error("pick 9 1 1").find("window 9: there is none"), std::string::npos);
  picked.viewer.client->expect("window 2");
  EXPECT_NE(error("pick 2 1 1").find("it shows nothing yet"), std::string::npos);
}

}  // namespace
}  // namespace gxy::test
