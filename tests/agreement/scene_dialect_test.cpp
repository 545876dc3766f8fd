// SPDX-License-Identifier: Apache-2.0
// One text, the same bits: the kernels that read scenes, in C++ against the three ISPC targets and GLSL.
#include "tests/agreement/scene_dialect.h"

#include <gtest/gtest.h>

#include <bit>
#include <glm/trigonometric.hpp>
#include <set>

#include "core/rays/fill_views.h"
#include "core/rays/view_pointers.h"
#include "tests/agreement/scene_single.h"
#include "tests/agreement/scenes.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

extern "C" {
using SceneProbes = void(const void* scene, const void* frame, int op, const int* list, int volumes,
                         int count, float* out);
SceneProbes scene_probe_sse4, scene_probe_avx2, scene_probe_avx512skx;
}

namespace gxy::agreement {
namespace {

constexpr int kInputs = 1000;
constexpr size_t kProbes = SCENE_PROBES;

/// A scene of all kinds whose data are in the first of eight partitions, two of which show nothing.
CompiledScene sceneOfAllKinds() {
  TestScene test = everything(40);
  Vis slices = surfaces(VisType::Volume, -1, 1);
  slices.slices = {{{0.1, 1, 0.2}, 0.1}};
  test.add(slices, wavy());
  for (size_t i = 0, count = test.data.size(); i < count; i++) {  // all geometry again, in colours of its own
    if (!test.data[i].geometry) continue;
    const Geometry& geometry = *test.data[i].geometry;
    const Vis vis = test.visualization.operators[i];
    test.add(vis, makeGeometry(geometry.kind, coloured(geometry.blocks.at(0))));
  }
  CompiledScene scene = *test.compile();
  // A mesh is the only volume that its scene renders, so it comes from another one.
  const auto bent = [](glm::dvec3 p) { return 0.05 * glm::sin(glm::dvec3(9.0 * p.y, 8.0 * p.z, 7.0 * p.x)); };
  const auto holed = [](glm::dvec3 p) {
    return p.x > 0.6 ? std::numeric_limits<double>::quiet_NaN() : waves(p);
  };
  const MeshPiece tets = test::cubeOfTets(3, bent, waves), all = test::cubeOfAllCells(3, bent, waves);
  const auto ofCells = [&](const MeshPiece& piece) { return test::withCellValues(piece, holed); };
  std::vector<MeshPiece> pieces{tets, all, ofCells(tets), ofCells(all), ofCells(tets), ofCells(all)};
  for (size_t i = 0; i < pieces.size(); i++) {
    TestScene other = sceneFrom("mesh", {3, 2, 1}, 40, 40);
    other.add(rendered({{-1, 0}, {0.2, 0.4}, {1, 0.8}}, -1, 1), test::meshInOnePiece(pieces[i]));
    Vis& cut = other.visualization.operators.back();
    cut.isovalues = {-0.2, 0.3};
    cut.slices = {{{1, 0.3, -0.2}, 0.1}};
    if (i >= 4) cut.cells = CellsShown::Smooth;
    scene.operators.push_back(other.compile()->operators.at(0));
  }
  std::array<std::vector<double>, 3> faces;
  for (int a = 0; a < 3; a++) {
    const auto outer = scene.partitioning->faces(a);
    faces[size_t(a)] = {outer.front(), 0.3 * outer.front() + 0.7 * outer.back(), outer.back()};
    std::vector<float>& mine = scene.faces[size_t(a)];  // the outer ones are infinite
    mine = {mine.front(), 0.15f, mine.back()};
  }
  scene.partitioning = std::make_shared<const Partitioning>(Partitioning::lattice(faces, 1));
  scene.cellPartition = {0, 1, 2, 3, 4, 5, 6, 7};
  scene.visible = {1, 1, 0, 1, 1, 0, 1, 1};
  return scene;
}

TEST(SceneDialect, HasTheBitsOfCpp) {
  const CompiledScene scene = sceneOfAllKinds();
  const CompiledFrame frame = compileFrame(scene, everything(40).camera, 3, true);
  const size_t operators = scene.operators.size();
  single::SceneView s{};
  single::FrameView f{};
  std::vector<single::OperatorView> views(operators);
  std::vector<single::VolumeView> fields(operators);
  const std::vector<int32_t>& rendered = scene.rendered;
  const ViewPointers pointers;
  fillSceneView(s, scene, 0, pointers);
  fillFrameView(f, scene, frame);
  f.light = frame.lights.data()->data();
  for (size_t k = 0; k < operators; k++) {
    const CompiledOperator& op = scene.operators[k];
    const OperatorInPartition& part = op.parts.at(0);
    fillVolumeView(fields[k], op, &part, pointers);
    fillOperatorView(views[k], op, pointers);
    if (part.geometry) fillPrimitives(views[k], *part.geometry, pointers);
    if (part.surfaces) fillSurfaces(views[k], *part.surfaces, pointers);
  }
  s.operators = int(operators);
  s.operator_ = views.data();
  s.field = fields.data();
  ASSERT_EQ(rendered.size(), 2u);

  std::vector<float> expected(operators * kProbes * kInputs);
  const auto at = [&](size_t op, size_t p, size_t i) { return (op * kProbes + p) * kInputs + i; };
  for (size_t p = 0; p < kProbes; p++) {
    std::set<uint32_t> values;
    for (size_t op = 0; op < operators; op++)
      for (size_t i = 0; i < kInputs; i++) {
        const float x = single::sceneProbe(s, f, views[op], fields[op], rendered.data(), int(rendered.size()),
                                           int(p), unsigned(i));
        expected[at(op, p, i)] = x;
        values.insert(std::bit_cast<uint32_t>(x));
      }
    EXPECT_GE(values.size(), p == 10 || p == 11 || p == 36 || p == 42 ? 2u : 20u) << "probe " << p;
  }
  const auto compare = [&](const char* target, const std::vector<float>& got) {
    int different = 0;
    for (size_t i = 0; i < got.size(); i++) {
      const bool same = std::bit_cast<uint32_t>(got[i]) == std::bit_cast<uint32_t>(expected[i]) ||
                        (std::isnan(got[i]) && std::isnan(expected[i]));
      if (!same && different++ < 5)
        ADD_FAILURE() << target << ", operator " << i / kInputs / kProbes << " probe "
                      << i / kInputs % kProbes << " input " << i % kInputs << ": " << got[i] << ", in C++ "
                      << expected[i];
    }
    EXPECT_EQ(different, 0) << target;
  };
  std::vector<float> got(expected.size());
  const auto inIspc = [&](const char* target, SceneProbes* probes) {
    for (size_t op = 0; op < operators; op++)
      probes(&s, &f, int(op), rendered.data(), int(rendered.size()), kInputs, &got[at(op, 0, 0)]);
    compare(target, got);
  };
  inIspc("sse4", scene_probe_sse4);
  if (__builtin_cpu_supports("avx2")) inIspc("avx2", scene_probe_avx2);
  if (__builtin_cpu_supports("avx512vl")) inIspc("avx512skx", scene_probe_avx512skx);
#ifdef GALAXY_VULKAN
  compare("GLSL", sceneProbesInGlsl(scene, frame, SCENE_PROBES, kInputs));
#endif
}

}  // namespace
}  // namespace gxy::agreement
