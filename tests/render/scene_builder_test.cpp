// SPDX-License-Identifier: Apache-2.0
// Scenes built by ranks together: what they share, what they enter in a ledger, and what is left when one fails.
#include "core/render/scene_builder.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/comm/error.h"
#include "tests/support/backends.h"
#include "tests/support/frames.h"
#include "tests/support/meshes.h"

namespace gxy::test {
namespace {

/// One rank by itself, or beside another one that says zeros or ones of as many bytes as this rank says. It has no primitives: where this
/// rank says a count, it says 0.
struct RankBesideAnother final : Collectives {
  int rank() const override { return 0; }
  int size() const override { return 1; }
  std::vector<Bytes> allGather(Bytes mine) override {
    std::vector<Bytes> all{mine};
    const bool isCount = mine.size() == sizeof(uint64_t);
    if (other) all.push_back(Bytes(mine.size(), std::byte(isCount ? 0 : *other)));
    return all;
  }
  std::vector<Bytes> allToAll(std::vector<Bytes> perRank) override { return perRank; }

  std::optional<int> other;
};

/// Particles of which scenes are built.
class SceneBuilderTest : public testing::Test {
 protected:
  SceneBuilderTest() : scene_(emptyScene("particles")) {
    addParticles(scene_, 1);
    compiled_ = compiledOn(whole(scene_.domain), scene_)[0].compiled;
    const auto& whole = *std::get<std::shared_ptr<const WholeGeometry>>(scene_.data[0]);
    const Geometry& complete = *compiled_->operators[0].data.geometry;
    auto owned = std::make_shared<OwnedGeometry>();
    owned->kind = whole.kind;
    owned->block = whole.block;
    owned->box = complete.box;
    owned->range = complete.range;
    owned->primitives = complete.primitives;
    owned_ = owned;
  }

  /// The particles with a largest radius, under a name.
  SceneSource source(double radius, const std::string& name = "particles") {
    SceneSource source{scene_.visualization, scene_.settings, compiled_->partitioning, {}};
    source.visualization.operators[0].radius1 = radius;
    source.data.push_back({{}, GeometrySource{name, owned_}});
    return source;
  }
  /// How often geometry has been distributed.
  int distributions() const { return int(std::count(entered_.begin(), entered_.end(), "geometry")); }
  BuiltScene build(SceneSource source) {
    const auto enter = [this](const char* purpose, int64_t bytes) {
      entered_.push_back(purpose);
      if (entered_.back() == full_) throw Error("there is no room");
      return ledger_.enter("tenant", purpose, bytes);
    };
    const auto onItem = [this](int64_t item, int64_t of, const std::string& text) {
      items_.push_back(std::to_string(item) + " of " + std::to_string(of) + ": " + text);
    };
    return builder_.build(std::move(source), ranks_, enter, onItem);
  }

  TestScene scene_;
  std::shared_ptr<const CompiledScene> compiled_;
  std::shared_ptr<const OwnedGeometry> owned_;
  RankBesideAnother ranks_;
  Ledger ledger_;
  SceneBuilder builder_{embree(), 0};
  std::vector<std::string> entered_, items_;
  std::string full_;  ///< a purpose for which there is no room
};

TEST_F(SceneBuilderTest, FindsGradientsOnceForIsosurfacesOfAMesh) {
  const auto value = [](glm::dvec3 p) { return p.x + p.y * p.z; };
  const auto meshOf = [&](double far) {
    return meshInOnePiece(cubeOfTets(
        4, [far](glm::dvec3 p) { return far * p; }, value));
  };
  const auto sourceOf = [&](std::shared_ptr<const Mesh> mesh, std::vector<double> isovalues) {
    Visualization visualization;
    Vis& vis = visualization.operators.emplace_back();
    vis.volumeRendering = true;
    vis.isovalues = std::move(isovalues);
    SceneSource source{visualization, scene_.settings, nullptr, {}};
    source.partitioning = std::make_shared<const Partitioning>(Partitioning::single(mesh->box));
    source.data.emplace_back().data.mesh = std::move(mesh);
    return source;
  };
  const auto first = meshOf(0), second = meshOf(0.1);
  SceneSource sampled = sourceOf(first, {0.5});
  sampled.sampled = true;
  const BuiltScene without = build(sourceOf(first, {})), ofSampling = build(std::move(sampled));
  EXPECT_EQ(distributions(), 0);
  EXPECT_EQ(ofSampling.compiled->operators.at(0).parts.at(0).surfaces->normals.size(), 0u);
  {
    const BuiltScene low = build(sourceOf(first, {0.4})), high = build(sourceOf(first, {0.6, 0.7}));
    EXPECT_EQ(distributions(), 1) << "an isovalue changes no gradient";
    EXPECT_EQ(low.gradients.at(0), high.gradients.at(0));
    EXPECT_EQ(low.gradients.at(0)->gradients.at(0).size(), 3 * first->blocks.at(0).points.size());
    const GeometryInPartition& surfaces = *low.compiled->operators.at(0).parts.at(0).surfaces;
    EXPECT_EQ(surfaces.corners.size(), 4 * surfaces.indices.size());
    EXPECT_LT(surfaces.normals.size(), 3 * first->blocks.at(0).points.size()) << "those of active points";
    const BuiltScene other = build(sourceOf(second, {0.4}));
    EXPECT_EQ(distributions(), 2) << "another mesh has others";
  }
  const BuiltScene again = build(sourceOf(first, {0.4}));
  EXPECT_EQ(distributions(), 3) << "nobody has held them";
}

TEST_F(SceneBuilderTest, DistributesGeometryOnceForEachNameAndRadii) {
  {
    const BuiltScene first = build(source(0.05)), second = build(source(0.05));
    EXPECT_EQ(distributions(), 1);
    EXPECT_EQ(first.geometry.at(0), second.geometry.at(0));
    EXPECT_EQ(second.compiled->operators[0].data.geometry, first.geometry[0]->geometry);
    const BuiltScene thicker = build(source(0.06)), renamed = build(source(0.05, "others"));
    EXPECT_EQ(distributions(), 3);
  }
  build(source(0.05));
  EXPECT_EQ(distributions(), 4) << "the scenes that held it have gone";
}

TEST_F(SceneBuilderTest, ShowsTheFieldThatArrayNames) {
  const BuiltScene plain = build(source(0.05));
  auto owned = std::make_shared<OwnedGeometry>(*owned_);
  owned->array = "own";
  PointField pair{"pair", 2, {}};
  for (const float v : owned->block.values) pair.values.insert(pair.values.end(), {3 - v, v});
  owned->block.fields = {pair};
  owned->fields = {{"pair", 2, {Range{0, 3}, owned->range, Range{0, 5}}}};
  const auto show = [&](const std::string& array, std::optional<int> component) {
    SceneSource scene = source(0.05, "with fields");
    scene.data[0].geometry->owned = owned;
    scene.visualization.operators[0].array = array;
    scene.visualization.operators[0].component = component;
    return build(scene);
  };
  const int before = distributions();
  const BuiltScene own = show("", {}), second = show("pair", 1), first = show("pair", 0),
                   all = show("pair", {}), again = show("pair", 1);
  EXPECT_EQ(distributions() - before, 8) << "each four has a copy while it is distributed";
  EXPECT_EQ(again.geometry.at(0), second.geometry.at(0));
  EXPECT_EQ(second.compiled->operators[0].data.geometry->range, owned->range);
  EXPECT_EQ(all.compiled->operators[0].data.geometry->range, (Range{0, 5}));
  ASSERT_FALSE(plain.compiled->operators[0].parts.empty());
  for (const auto& [partition, part] : plain.compiled->operators[0].parts) {
    const auto of = [p = partition](const BuiltScene& built) -> const GeometryInPartition& {
      return *built.compiled->operators[0].parts.at(p).geometry;
    };
    for (const BuiltScene* same : {&own, &second}) {
      EXPECT_EQ(of(*same).values, part.geometry->values);
      EXPECT_EQ(of(*same).points, part.geometry->points) << "radii, too";
    }
    ASSERT_EQ(of(first).values.size(), part.geometry->values.size());
    for (size_t i = 0; i < part.geometry->values.size(); i++)
      EXPECT_EQ(of(first).values[i], 3 - of(second).values[i]);
  }
  try {
    show("speed", {});
    FAIL() << "expected an error";
  } catch (const Error& e) {
    EXPECT_NE(
        std::string(e.what()).find("no array \"speed\" of points; expected one of those there are: \"own\", "
                                   "\"pair\" (2 components)"),
        std::string::npos)
        << e.what();
  }
}

TEST_F(SceneBuilderTest, KeepsPrimitivesAsTheyAreCompiledAndNoCopyOfThem) {
  const BuiltScene built = build(source(0.05));
  const OperatorData& data = built.compiled->operators[0].data;
  EXPECT_TRUE(data.geometry->blocks.empty());
  EXPECT_EQ(data.owned, owned_);
  auto bytes = int64_t(built.compiled->bytes() + built.device->bytes());
  for (const auto& all : {built.compiled->sharedBytes(), built.device->sharedBytes()})
    for (const SharedBytes& shared : all) bytes += int64_t(shared.bytes);
  EXPECT_EQ(ledger_.total(), bytes);
  Visualization same = scene_.visualization;
  same.operators[0].radius1 = 0.05;
  const auto complete =
      compileScene(same, {compiled_->operators[0].data}, compiled_->partitioning, scene_.settings);
  const auto& parts = complete->operators[0].parts;
  ASSERT_FALSE(parts.empty());
  ASSERT_EQ(built.compiled->operators[0].parts.size(), parts.size());
  for (const auto& [partition, part] : parts) {
    const GeometryInPartition& kept = *built.compiled->operators[0].parts.at(partition).geometry;
    EXPECT_EQ(kept.points, part.geometry->points);
    EXPECT_EQ(kept.values, part.geometry->values);
  }
}

TEST_F(SceneBuilderTest, DistributesAgainWhereAnotherRankHasForgotten) {
  const BuiltScene first = build(source(0.05));
  ranks_.other = 0;
  const BuiltScene second = build(source(0.05));
  EXPECT_EQ(distributions(), 2);
  EXPECT_EQ(first.geometry.at(0), second.geometry.at(0)) << "what this rank has is kept";
}

TEST_F(SceneBuilderTest, TakesPrimitivesFromScenesThatThereAre) {
  const BuiltScene first = build(source(0.05)), second = build(source(0.05));
  ASSERT_FALSE(first.compiled->operators[0].parts.empty());
  for (const auto& [partition, part] : first.compiled->operators[0].parts)
    EXPECT_EQ(second.compiled->operators[0].parts.at(partition).geometry, part.geometry);
}

TEST_F(SceneBuilderTest, EntersWhatScenesHoldOnceAndInOrder) {
  {
    const BuiltScene first = build(source(0.05));
    ASSERT_GE(entered_.size(), 2u);
    EXPECT_EQ(entered_[0], "geometry");
    for (size_t i = 1; i < entered_.size(); i++) EXPECT_EQ(entered_[i], "scene");
    const int64_t shared = ledger_.total();
    const auto alone = int64_t(first.compiled->bytes() + first.device->bytes());
    const BuiltScene second = build(source(0.05));
    EXPECT_EQ(ledger_.total(), shared + alone);
  }
  EXPECT_EQ(ledger_.total(), 0);
}

TEST_F(SceneBuilderTest, TellsWhatBegins) {
  build(source(0.05));
  EXPECT_EQ(items_,
            (std::vector<std::string>{"0 of 3: distributing " + scene_.visualization.operators[0].dataset,
                                      "1 of 3: compiling the scene", "2 of 3: building the scene"}));
}

TEST_F(SceneBuilderTest, SeesWhatAnyRankSees) {
  EXPECT_EQ(build(source(0.05)).compiled->visible, compiled_->visible);
  owned_ = std::make_shared<const OwnedGeometry>();
  EXPECT_EQ(build(source(0.05)).compiled->visible, std::vector<uint8_t>{0});
  ranks_.other = 1;
  EXPECT_EQ(build(source(0.05)).compiled->visible, std::vector<uint8_t>{1});
}

TEST_F(SceneBuilderTest, LeavesNothingWhereThereIsNoRoom) {
  for (const char* purpose : {"geometry", "scene"}) {
    full_ = purpose;
    EXPECT_THROW(build(source(0.05)), Error) << purpose;
    EXPECT_EQ(ledger_.total(), 0) << purpose;
  }
  full_.clear();
  const BuiltScene scene = build(source(0.05));
  EXPECT_NE(scene.device, nullptr);
  EXPECT_EQ(distributions(), 3);
}

}  // namespace
}  // namespace gxy::test
