// SPDX-License-Identifier: Apache-2.0
#include "tests/support/frames.h"

#include "core/comm/error.h"
#include "tests/support/backends.h"

namespace gxy::test {

std::vector<RankScene> compiledOn(const Cut& cut, const TestScene& scene, const BackendOf& backendOf) {
  const auto partitioning = std::make_shared<const Partitioning>(cut.partitioning);
  std::vector<std::vector<OperatorData>> data(size_t(cut.ranks));
  for (size_t i = 0; i < scene.data.size(); i++) {
    const Vis& vis = scene.visualization.operators.at(i);
    if (const auto* volume = std::get_if<std::shared_ptr<const WholeVolume>>(&scene.data[i])) {
      const auto parts = test::cut(**volume, *partitioning, cut.ranks);
      for (size_t r = 0; r < parts.size(); r++) data[r].emplace_back().volume = parts[r];
    } else if (const auto* mesh = std::get_if<std::shared_ptr<const WholeMesh>>(&scene.data[i])) {
      const auto parts = test::cut(**mesh, *partitioning, cut.ranks);
      const auto gradients = test::gradientsOf(parts, vis, *partitioning);
      for (size_t r = 0; r < parts.size(); r++) {
        data[r].emplace_back().mesh = parts[r];
        data[r].back().gradients = gradients[r];
      }
    } else {
      const auto& geometry = *std::get<std::shared_ptr<const WholeGeometry>>(scene.data[i]);
      const bool flat = geometry.kind == GeometryKind::Triangles;
      const auto parts = distributed(
          geometry, *partitioning, [&](double value) { return flat ? 0 : radiusOf(vis, value); }, cut.ranks);
      for (size_t r = 0; r < parts.size(); r++) {
        data[r].emplace_back().geometry = parts[r];
        data[r].back().color = {0.7, 0.6, 0.5};
      }
    }
  }
  std::vector<std::shared_ptr<CompiledScene>> scenes;
  for (auto& mine : data)
    scenes.push_back(compileScene(scene.visualization, std::move(mine), partitioning, scene.settings));
  std::vector<uint8_t> visible(size_t(partitioning->partitions()), 0);
  for (const auto& s : scenes)
    for (size_t p = 0; p < visible.size(); p++) visible[p] |= s->visible[p];
  std::vector<RankScene> out;
  for (int rank = 0; rank < cut.ranks; rank++) {
    scenes[size_t(rank)]->visible = visible;
    const Backend& backend = backendOf ? backendOf(rank) : testedBackend();
    out.push_back({scenes[size_t(rank)], backend.makeScene(scenes[size_t(rank)], rank)});
  }
  return out;
}

Frames::Frames(int ranks, const FrameRun& run) {
  InProcessWorld::Options options;
  options.threaded = run.threaded;
  options.workers = run.workers;
  options.onError = [this](int rank, const std::string& message) {
    std::lock_guard lock(mutex_);
    errors_.push_back("rank " + std::to_string(rank) + ": " + message);
  };
  world_ = std::make_unique<InProcessWorld>(ranks, run.seed, std::move(options));
  for (int r = 0; r < ranks; r++) {
    renderers_.push_back(std::make_unique<Renderer>(world_->rank(r), run.options));
    renderers_.back()->onPicture([this](FrameId id, const FrameRequest&, Picture picture) {
      std::lock_guard lock(mutex_);
      outcomes_[id].pictures++;
      outcomes_[id].picture = std::move(picture);
    });
  }
}

void Frames::add(SceneId id, const std::vector<RankScene>& scene) {
  for (size_t r = 0; r < renderers_.size(); r++)
    renderers_[r]->addScene(id, scene[r].compiled, scene[r].device);
}

FrameId Frames::start(const FrameRequest& request) {
  return renderers_[0]->render(request, [this](FrameId id, const Renderer::Ending& ending) {
    std::lock_guard lock(mutex_);
    outcomes_[id].finished++;
    outcomes_[id].superseded += ending.superseded;
    outcomes_[id].error = ending.error;
  });
}

std::vector<std::string> Frames::errors() {
  std::lock_guard lock(mutex_);
  return errors_;
}

FrameRequest requestOf(const TestScene& scene) {
  FrameRequest request;
  request.scene = 1;
  request.camera = scene.camera;
  request.depth = true;
  return request;
}

Picture render(const TestScene& scene, int ranks, const std::vector<RankScene>& compiled,
               const FrameRun& run) {
  Frames frames(ranks, run);
  frames.add(1, compiled);
  const FrameId id = frames.start(requestOf(scene));
  frames.run();
  for (const std::string& e : frames.errors()) throw Error(e);
  const Frames::Outcome& outcome = frames.outcome(id);
  if (!outcome.error.empty()) throw Error(outcome.error);
  if (outcome.finished != 1 || outcome.pictures != 1)
    throw Error("the frame was reported finished " + std::to_string(outcome.finished) + " times, with " +
                std::to_string(outcome.pictures) + " pictures; expected one of each");
  return outcome.picture;
}

Picture render(const TestScene& scene, const Cut& cut, const FrameRun& run) {
  return render(scene, cut.ranks, compiledOn(cut, scene), run);
}

Picture wholeOnEmbree(const TestScene& scene) {
  const Cut cut = whole(scene.domain);
  return render(scene, cut.ranks, compiledOn(cut, scene, [](int) -> const Backend& { return embree(); }));
}

}  // namespace gxy::test
