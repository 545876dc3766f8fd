// SPDX-License-Identifier: Apache-2.0
// Particles, path lines and triangles: backend against reference.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/agreement/backend.h"
#include "tests/agreement/compare.h"
#include "tests/kernels/mesh.h"

namespace gxy::agreement {
namespace {

const glm::dvec3 kEye(2.1, 1.4, 3.3);

GeometryBlock cloud(int n, bool values) {
  GeometryBlock block;
  Uniform random(3);
  for (int i = 0; i < n; i++) {
    block.points.push_back(random.inCube(0.9));
    if (values) block.values.push_back(float(random()));
  }
  return block;
}

Vis particles(double r0, double r1) {
  Vis vis = surfaces(VisType::Particles);
  vis.radius0 = r0, vis.radius1 = r1, vis.value0 = 0, vis.value1 = r0 == r1 ? 0 : 1;
  return vis;
}

Vis tubes(double r0, double r1) {
  Vis vis = particles(r0, r1);
  vis.type = VisType::PathLines;
  return vis;
}

/// Helices with radii from their values, nested, thin and thick.
GeometryBlock lines() {
  GeometryBlock block;
  for (int l = 0; l < 4; l++) {
    std::vector<glm::dvec3> points;
    std::vector<float> values;
    for (int i = 0; i < 14; i++) {
      const double a = 0.7 * i + l;
      points.push_back({0.7 * std::cos(a), -0.9 + 0.14 * i, 0.7 * std::sin(a)});
      values.push_back(float(0.5 + 0.5 * std::sin(1.3 * i + l)));
    }
    addLine(block, points, values);
  }
  return block;
}

TestScene geometryScene(const std::string& name, Vis vis, GeometryBlock block, int size = 96) {
  TestScene scene = sceneFrom(name, kEye, size, size);
  const GeometryKind kind = vis.type == VisType::Particles   ? GeometryKind::Particles
                            : vis.type == VisType::PathLines ? GeometryKind::PathLines
                                                             : GeometryKind::Triangles;
  scene.add(std::move(vis), makeGeometry(kind, std::move(block)));
  return scene;
}

TEST(GeometryAgreement, SpheresWithRadiusFromData) {
  expectAgreement(embree(), geometryScene("spheres", particles(0.05, 0.3), cloud(60, true)));
}

// Hierarchies take less: 1e19 is beyond Embree's largest bound, 1e300 is no float.
TEST(GeometryAgreement, SpheresOfAnyRadius) {
  // depths as large change with the last bits of a ray: all pixels may be flips
  for (double radius : {1e19, 1e300})
    expectAgreement(embree(), geometryScene("spheres_huge", particles(radius, radius), cloud(60, false), 24),
                    {}, 24 * 24, radius < 1e300 ? 24 * 24 : 0);
}

TEST(GeometryAgreement, SpheresWithoutValues) {
  expectAgreement(embree(), geometryScene("spheres_plain", particles(0.1, 0.1), cloud(60, false)));
}

TEST(GeometryAgreement, TranslucentSpheresShowBothSides) {
  Vis vis = particles(0.05, 0.4);
  vis.opacity = 0.4;
  expectAgreement(embree(), geometryScene("spheres_translucent", vis, cloud(30, true)));
  vis.twoSided = false;
  vis.clipPlanes = {{{0.3, 0, -1}, -0.2}};
  expectAgreement(embree(), geometryScene("spheres_one_sided", vis, cloud(30, true)));
}

TEST(GeometryAgreement, Tubes) {
  expectAgreement(embree(), geometryScene("tubes", tubes(0.02, 0.14), lines()));
}

TEST(GeometryAgreement, TranslucentTubesAreOneBody) {
  Vis vis = tubes(0.02, 0.14);
  vis.opacity = 0.4;
  expectAgreement(embree(), geometryScene("tubes_translucent", vis, lines()));
}

TEST(GeometryAgreement, ClippedTubesAreHollowBodies) {
  Vis vis = tubes(0.05, 0.16);
  vis.clipPlanes = {{{0, 0, -1}, -0.1}, {{0.2, 1, 0}, -0.5}};
  expectAgreement(embree(), geometryScene("tubes_clipped", vis, lines()));
}

TEST(GeometryAgreement, TubesWithRadiiBelowZero) {
  expectAgreement(embree(), geometryScene("tubes_negative", tubes(-0.1, 0.14), lines()));
}

TEST(GeometryAgreement, Triangles) {
  Vis vis = surfaces(VisType::Triangles);
  for (bool normals : {false, true})
    for (bool values : {false, true})
      expectAgreement(embree(), geometryScene(std::string("mesh") + (normals ? "_normals" : "") +
                                                  (values ? "_values" : ""),
                                              vis, sphereMesh(24, normals, values), 64));
}

TEST(GeometryAgreement, TranslucentOneSidedClippedTriangles) {
  Vis vis = surfaces(VisType::Triangles);
  vis.opacity = 0.5;
  vis.clipPlanes = {{{0, 0, -1}, -0.7}};
  expectAgreement(embree(), geometryScene("mesh_translucent", vis, sphereMesh(24, true, true)));
  vis.twoSided = false;
  expectAgreement(embree(), geometryScene("mesh_one_sided", vis, sphereMesh(24, false, true)));
}

TEST(GeometryAgreement, WithoutDataValuesAreNoCrash) {
  for (VisType type : {VisType::Particles, VisType::PathLines, VisType::Triangles}) {
    GeometryBlock block = type == VisType::Particles   ? cloud(30, true)
                          : type == VisType::PathLines ? lines()
                                                       : sphereMesh(8, false, true);
    for (size_t i = 0; i < block.values.size(); i += 3)
      block.values[i] = std::numeric_limits<float>::quiet_NaN();
    Vis vis = particles(0.1, 0.2);
    vis.type = type;
    TestScene scene = geometryScene("nan_values", vis, block, 48);
    for (float x : drawnByBoth(scene).rgba) EXPECT_TRUE(std::isfinite(x));
    // A map of one colour: what has no value looks like all else.
    scene.name = "nan_values_" + std::to_string(int(type));
    scene.visualization.operators[0].colormap.points = {{0, glm::dvec3(0.7)}};
    expectAgreement(embree(), scene);
  }
}

TEST(GeometryAgreement, ValuesThatAreNaNHaveTheirColour) {
  GeometryBlock block = sphereMesh(8, false, true);
  for (size_t i = 0; i < block.values.size(); i += 3)
    block.values[i] = std::numeric_limits<float>::quiet_NaN();
  Vis vis = particles(0, 0);
  vis.type = VisType::Triangles;
  vis.colormap = {{{0, {0.2, 0.1, 0.1}}, {1, {0.3, 0.1, 0.1}}}, glm::dvec3(0, 0.9, 0)};
  TestScene scene = geometryScene("nan_colour", vis, block, 48);
  expectAgreement(embree(), scene);
  int green = 0, red = 0;
  const auto picture = drawnByBoth(scene).rgba;
  for (size_t i = 0; i < picture.size(); i += 4) {
    green += picture[i + 1] > 3 * picture[i] && picture[i + 1] > 0;
    red += picture[i] > 1.5f * picture[i + 1];
  }
  EXPECT_GT(green, 100);
  EXPECT_GT(red, 100);
}

TEST(GeometryAgreement, RadiiOfAnotherArray) {
  for (const VisType type : {VisType::Particles, VisType::PathLines})
    for (const bool beside : {false, true}) {
      GeometryBlock block = type == VisType::Particles ? cloud(40, true) : lines();
      for (const glm::dvec3& p : block.points)
        block.radiusValues.push_back(float(0.5 + 0.5 * std::sin(9 * p.x)));
      block.radiusValues[1] = std::numeric_limits<float>::quiet_NaN();
      if (beside) block = coloured(block);
      Vis vis = particles(0.02, 0.2);
      vis.type = type;
      expectAgreement(embree(), geometryScene("radii_" + std::to_string(int(type)), vis, block, 48));
    }
}

TEST(GeometryAgreement, ColoursOfPoints) {
  for (VisType type : {VisType::Particles, VisType::PathLines, VisType::Triangles}) {
    const GeometryBlock block = type == VisType::Particles   ? cloud(40, false)
                                : type == VisType::PathLines ? lines()
                                                             : sphereMesh(16, true, false);
    Vis vis = particles(0.12, 0.12);
    vis.type = type;
    TestScene scene = geometryScene("colours_" + std::to_string(int(type)), vis, coloured(block), 40);
    expectAgreement(embree(), scene);
    vis.opacity = 0.5;
    scene = geometryScene(scene.name + "_translucent", vis, coloured(block), 40);
    scene.visualization.lighting = lit({kSun, kLamp}, true);
    expectAgreement(embree(), scene);
  }
}

// With ambient light alone a pixel is the colour itself.
TEST(GeometryAgreement, ColoursAreWhatThePointsSay) {
  const auto expectColours = [](VisType type, const GeometryBlock& block,
                                const std::function<glm::dvec3(double x, double y)>& expected) {
    Vis vis = particles(0.25, 0.25);
    vis.type = type;
    TestScene scene = geometryScene("colours", vis, block, 20);
    scene.camera.viewpoint = {0, 0, 3};
    scene.camera.viewdirection = {0, 0, -1};
    scene.camera.aov = 0;
    scene.camera.height = 2;
    scene.visualization.lighting = Lighting();
    scene.visualization.lighting.Ka = 1, scene.visualization.lighting.Kd = 0;
    scene.settings.background = glm::dvec4(0);
    const Picture picture = drawnByBoth(scene);
    int seen = 0;
    for (int y = 0; y < 20; y++)
      for (int x = 0; x < 20; x++) {
        const float* pixel = &picture.rgba[4 * size_t(20 * y + x)];
        if (pixel[3] == 0) continue;
        seen++;
        const glm::dvec3 colour = expected((x + 0.5) / 10 - 1, (y + 0.5) / 10 - 1);
        for (int c = 0; c < 3; c++)
          EXPECT_NEAR(pixel[c], colour[c], 1e-5) << int(type) << " " << x << " " << y;
      }
    EXPECT_GT(seen, 15) << int(type);
  };
  GeometryBlock triangle, balls, tube;
  triangle.points = {{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}};
  triangle.triangles = {{0, 1, 2}};
  triangle.colors = {{1, 0, 0}, {0, 1, 0}, {0, 0, 0.5f}};
  expectColours(VisType::Triangles, triangle, [](double x, double y) {
    const double b = (x + 1) / 2, c = (y + 1) / 2;
    return glm::dvec3(1 - b - c, b, 0.5 * c);
  });
  balls.points = {{-0.6, 0, 0}, {0.6, 0, 0}};
  balls.colors = {{1, 0, 0.25f}, {0, 0.5f, 1}};
  expectColours(VisType::Particles, balls,
                [](double x, double) { return x < 0 ? glm::dvec3(1, 0, 0.25) : glm::dvec3(0, 0.5, 1); });
  tube.points = balls.points;
  tube.colors = balls.colors;
  tube.segments = tube.neighbours = {{0, 1}};
  expectColours(VisType::PathLines, tube, [](double x, double) {
    return glm::mix(glm::dvec3(1, 0, 0.25), glm::dvec3(0, 0.5, 1), std::clamp((x + 0.6) / 1.2, 0.0, 1.0));
  });
}

// Found by random scenes: a cap has the value of its own end, also where that of the other is NaN.
TEST(GeometryAgreement, CapsOfTubesBesideValuesWithoutData) {
  GeometryBlock block = lines();
  for (size_t i = 1; i < block.values.size(); i += 3)
    block.values[i] = std::numeric_limits<float>::quiet_NaN();
  Vis vis = tubes(0.1, 0.1);
  expectAgreement(embree(), geometryScene("caps_without_data", vis, block, 64));
}

// Found by random scenes: a ball that two segments share is one surface, also where a third has no length.
TEST(GeometryAgreement, TranslucentTubesWithSegmentsOfNoLength) {
  GeometryBlock block;
  addLine(block, {{-0.8, 0, 0}, {-0.2, 0.5, 0}, {-0.2, 0.5, 0}, {0.1, -0.4, 0.3}, {0.8, 0.1, 0}},
          {0.1f, 0.9f, 0.2f, 0.6f, 0.4f});
  Vis vis = tubes(0.2, 0.2);
  vis.opacity = 0.4;
  expectAgreement(embree(), geometryScene("tubes_no_length", vis, block, 64));
}

TEST(GeometryAgreement, PrimitivesOutsideTheDomainOfThePartitioning) {
  TestScene scene = geometryScene("outside_domain", particles(0.05, 0.3), cloud(60, true));
  scene.domain = {glm::dvec3(-0.3), glm::dvec3(0.4)};
  expectAgreement(embree(), scene);
}

// Along each axis, each ray through a vertex; the outer ones along the border of the mesh.
// A million rays.
TEST(GeometryAgreement, NoRayLeavesAClosedMesh) {
  const test::Mesh mesh = test::icosphere();
  for (double offset : {0.0, 1e5}) {
    TestScene scene = sceneFrom("closed mesh", glm::dvec3(offset), 720, 720);
    scene.camera.viewdirection = {0.3, -0.4, 0.5};
    scene.camera.aov = 120;
    scene.settings.background = glm::dvec4(0);
    GeometryBlock block;
    for (const glm::dvec3& p : mesh.vertices) block.points.push_back(p + offset);
    for (const auto& t : mesh.triangles)
      block.triangles.push_back({uint32_t(t[0]), uint32_t(t[1]), uint32_t(t[2])});
    scene.add(surfaces(VisType::Triangles), makeGeometry(GeometryKind::Triangles, block));
    const Picture picture = drawnByBoth(scene);
    size_t leaks = 0;
    for (size_t i = 3; i < picture.rgba.size(); i += 4) leaks += picture.rgba[i] != 1;
    EXPECT_EQ(leaks, 0u) << offset;
  }
}

TEST(GeometryAgreement, ParallelRaysThroughVertices) {
  constexpr int n = 16;
  for (int axis = 0; axis < 3; axis++) {
    const auto turned = [&](double x, double y, double z) {
      const double p[3] = {x, y, z};
      return glm::dvec3(p[(axis + 1) % 3], p[(axis + 2) % 3], p[axis]);
    };
    GeometryBlock block;
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        block.points.push_back(
            turned((2.0 * i + 1) / n - 1, (2.0 * j + 1) / n - 1, (3 * i + 5 * j) % 7 / 14.0));
    for (unsigned j = 0; j + 1 < n; j++)
      for (unsigned i = 0; i + 1 < n; i++) {
        const unsigned k = j * n + i;
        block.triangles.push_back({k, k + 1, k + n + 1});
        block.triangles.push_back({k, k + n + 1, k + n});
      }
    TestScene scene =
        geometryScene("parallel_" + std::to_string(axis), surfaces(VisType::Triangles), block, n);
    scene.camera.viewpoint = turned(0, 0, 3);
    scene.camera.viewdirection = turned(0, 0, -1);
    scene.camera.viewup = turned(0, 1, 0);
    scene.camera.aov = 0;
    scene.camera.height = 2;
    expectAgreement(embree(), scene, {}, 4 * n);
  }
}

// Twice in one operator, and once more in another, among slices, isosurfaces and volumes.
TEST(GeometryAgreement, CoincidentTranslucentSurfacesCountEach) {
  const auto twice = [](auto& list) {
    const auto once = list;
    list.insert(list.end(), once.begin(), once.end());
  };
  GeometryBlock mesh = sphereMesh(16, true, true), balls = cloud(12, true), line = lines();
  twice(mesh.triangles);
  twice(balls.points);
  twice(balls.values);
  twice(line.segments);
  twice(line.neighbours);
  Vis vis = surfaces(VisType::Triangles), red = vis;
  vis.opacity = red.opacity = 0.3;
  red.colormap.points = {{0, {1, 0, 0}}};
  TestScene scene = geometryScene("coincident_geometry", vis, mesh, 64);
  scene.add(red, scene.data[0].geometry);
  for (Vis kind : {particles(0.1, 0.4), tubes(0.05, 0.2)}) {
    kind.opacity = 0.3;
    const bool round = kind.type == VisType::Particles;
    scene.add(kind,
              makeGeometry(round ? GeometryKind::Particles : GeometryKind::PathLines, round ? balls : line));
    kind.colormap = red.colormap;
    scene.add(kind, scene.data.back().geometry);
  }
  expectAgreement(embree(), scene);
  for (const bool volume : {false, true}) {
    TestScene fields = sceneFrom("coincident_fields", kEye, 64, 64);
    Vis first = volume ? rendered({{-1, 0}, {1, 0.2}}, -1, 1) : surfaces(VisType::Volume, -1, 1);
    first.isovalues = {0.1, 0.4};
    first.slices = {{{0.2, 1, 0.3}, 0.1}, {{0.2, 1, 0.3}, 0.1}};
    first.opacity = 0.4;
    fields.add(first, wavy());
    Vis second = first;
    second.volumeRendering = false;
    second.colormap = red.colormap;
    fields.add(second, wavy());
    expectAgreement(embree(), fields);
  }
}

TEST(GeometryAgreement, TiesBetweenOperatorsGoToTheFirst) {
  TestScene scene = geometryScene("ties", surfaces(VisType::Triangles), sphereMesh(16, true, true), 64);
  Vis red = surfaces(VisType::Triangles);
  red.colormap.points = {{0, {1, 0, 0}}};
  scene.add(red, scene.data[0].geometry);
  scene.add(particles(0.3, 0.6), makeGeometry(GeometryKind::Particles, cloud(5, true)));
  scene.add(red, scene.data[0].geometry);
  expectAgreement(embree(), scene);
}

}  // namespace
}  // namespace gxy::agreement
