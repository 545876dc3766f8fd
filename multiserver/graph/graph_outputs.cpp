// SPDX-License-Identifier: Apache-2.0
// What a graph makes of data beside showing them: files, pictures and names.
#include <algorithm>
#include <filesystem>
#include <future>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/io/write_dataset.h"
#include "core/scene/dataset_type.h"
#include "multiserver/graph/graph.h"
#include "multiserver/rendering/cost.h"
#include "multiserver/rendering/rendering.h"
#include "multiserver/server/data_export.h"

namespace gxy {

namespace {

/// Throws Error unless the picture of this file has a format that there is; returns the format.
std::string pictureFormat(const std::string& file) {
  const std::string extension = std::filesystem::path(file).extension().string();
  if (extension != ".png" && extension != ".exr")
    throw Error("file " + inQuotes(file) + ": expected a name that ends with .png or .exr");
  return extension.substr(1);
}

}  // namespace

// With the lock held, like all but makeOutput() and those that it calls.
void Graph::carryOut(const flow::ShowData& action, std::vector<ShownItem> items) {
  const std::string& name = action.target.name;
  const auto found = document_.outputs.find(name);
  if (found == document_.outputs.end()) return flow_.written(name, action.wave);
  std::string problem;
  for (const flow::Problem& p : action.problems)
    if (problem.empty()) problem = inQuotes(p.node) + ": " + p.text;
  for (const flow::ShownData& data : action.data)
    if (data.older && problem.empty()) problem = inQuotes(data.node) + ": there is an older output only";
  if (items.empty() && problem.empty()) problem = "there are no data";
  const auto look = document_.looks.find(found->second.of);
  const bool isPicture = found->second.type == OutputSpec::Type::Pictures;
  if (isPicture && look == document_.looks.end() && problem.empty())
    problem = "there is no view " + inQuotes(found->second.of);
  if (!problem.empty()) {
    written_[name] = {found->second, "", problem, -1};
    return flow_.written(name, action.wave);
  }
  OutputJob job{found->second, action.wave, std::move(items), {}, {}, {}};
  if (isPicture) {
    job.look = look->second;
    job.settings = document_.settings;
    for (const DatasetSpec& d : document_.flow.datasets) job.colors[d.name] = d.color;
  }
  due_.insert_or_assign(name, std::move(job));
  startOutputs();
}

// One of a name at a time, so that the newest data wait until what is being made is there.
void Graph::startOutputs() {
  constexpr size_t kAtOnce = 2;
  for (auto it = due_.begin(); it != due_.end() && writing_.size() < kAtOnce;) {
    if (writing_.contains(it->first)) {
      ++it;
      continue;
    }
    const auto running = std::make_shared<Running>(it->first);
    writing_[it->first] = {it->second.what, running};
    post([this, job = std::move(it->second), running] { makeOutput(job, running); });
    it = due_.erase(it);
  }
}

void Graph::stopOutput(const std::string& name) {
  due_.erase(name);
  if (const auto found = writing_.find(name); found != writing_.end()) stop(*found->second.running);
}

void Graph::makeOutput(const OutputJob& job, const std::shared_ptr<Running>& running) {
  const std::string& name = job.what.name;
  std::string file, error;
  try {
    switch (job.what.type) {
      case OutputSpec::Type::DataFile:
        file = writeDataFile(job, running);
        break;
      case OutputSpec::Type::Pictures:
        file = writePicture(job, running);
        break;
      case OutputSpec::Type::Publish:
        publish(job);
        break;
    }
  } catch (const std::exception& e) {
    error = textOf(e);
  }
  const std::lock_guard lock(mutex_);
  writing_.erase(name);
  if (isEnded_) return;
  const auto now = document_.outputs.find(name);
  if (now != document_.outputs.end() && now->second == job.what) {
    const Failure failure = failureOf(error);
    written_[name] = {job.what, file, failure.text, failure.rank};
    flow_.written(name, job.wave);
  }
  startOutputs();
  tellNode({flow::NodeId::Kind::Output, name});
  act();
}

// The file of the newest step of what is written.
std::string Graph::pathOf(const OutputJob& job) const {
  int64_t step = 0;
  for (const ShownItem& item : job.items) {
    const ObjectGeneration where = item.kept->where();
    const Pin pin = services_.serverRank.objects.pin(where.key, where.generation);
    step = std::max(step, newestStep(*pin.get<Dataset>()));
  }
  return services_.serverRank.folders.toWrite(fileOfStep(job.what.to, step));
}

std::string Graph::writeDataFile(const OutputJob& job, const std::shared_ptr<Running>& running) {
  ServerRank& serverRank = services_.serverRank;
  const NamedDataset& shown = job.items.at(0).kept->shown();
  checkFileFor(geometryKindOf(*datasetTypeNamed(shown.type)), job.what.to,
               "dataset " + inQuotes(job.what.of));
  const std::string path = pathOf(job);
  const auto exchange = serverRank.exchanges.beginLong(tenant_, askerOf(*running));
  begunOf(running)(*exchange);
  const ObjectGeneration where = job.items[0].kept->where();
  const Pin pin = serverRank.objects.pin(where.key, where.generation);
  checkFileFor(*pin.get<Dataset>(), job.what.to, "dataset " + inQuotes(job.what.of));
  exportData(serverRank, *exchange, tenant_, where, path);
  return path;
}

std::string Graph::writePicture(const OutputJob& job, const std::shared_ptr<Running>& running) {
  ServerRank& serverRank = services_.serverRank;
  PictureFormat format;
  format.as = PictureFormat::As::File;
  format.format = pictureFormat(job.what.to);
  format.path = pathOf(job);
  Visualization visualization = job.look->visualization;
  SceneCache::GivenData given = givenTo(visualization, job.items, job.colors);
  Camera camera = job.look->camera.value_or(defaultCamera());
  if (job.look->size) camera.dimensions = *job.look->size;
  checkCost(job.settings, camera.dimensions);
  const Asker asker = askerOf(*running);
  auto slot =
      serverRank.tenants.beginWhenFree(tenant_, serverRank.costOf(tenant_, camera.dimensions), asker.check);
  ShownSoFar shown;
  Rendering& rendering = *services_.rendering;
  SceneCache::Pinned pinned =
      rendering.scenes.get(tenant_, visualization, job.settings, asker, shown, nullptr, nullptr, &given);
  FrameRequest frame;
  frame.scene = pinned.scene->id;
  frame.camera = fitted(camera, shown.box);
  validate(frame.camera);
  frame.priority = {serverRank.tenants.number(tenant_), false, rendering.nextStream()};
  frame.account = tenant_;
  const auto ended = std::make_shared<std::promise<std::string>>();
  std::future<std::string> end = ended->get_future();
  PictureReceiver receiver;
  receiver.done = [ended](bool superseded, const std::string& error) {
    ended->set_value(superseded ? "cancelled" : error);
  };
  const FrameId id = rendering.pictures.start(frame, format, std::move(receiver));
  while (end.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready)
    if (running->isCancelled) serverRank.renderer.supersede(id);
  if (const std::string error = end.get(); !error.empty()) throw Error(error);
  return format.path;
}

void Graph::publish(const OutputJob& job) {
  Datasets& datasets = *services_.serverRank.datasets;
  const std::lock_guard lock(mutex_);
  if (isEnded_) return;
  const auto* key = std::get_if<flow::NodeKey>(&job.items.at(0).data);
  const auto made = key ? outputs_.find(*key) : outputs_.end();
  if (made == outputs_.end() || !made->second->object)
    throw Error("dataset " + inQuotes(job.what.of) + ": expected one that a filter of this graph makes");
  const Key object = made->second->object->key();
  const auto before = published_.find(job.what.name);
  const Key present = before == published_.end() ? Key() : before->second.output->object->key();
  if (!datasets.publishOfGraph(tenant_, job.what.to, object, made->second->type, present))
    throw Error("the name " + inQuotes(job.what.to) + " is in use, expected a free one");
  published_[job.what.name] = {job.what, made->second};
}

// Takes names back that the document does not give any more, or that all lose.
void Graph::unpublish(bool all) {
  for (auto it = published_.begin(); it != published_.end();) {
    const auto now = document_.outputs.find(it->first);
    if (!all && now != document_.outputs.end() && now->second == it->second.what) {
      ++it;
      continue;
    }
    services_.serverRank.datasets->unnameOfGraph(tenant_, it->second.what.to,
                                                 it->second.output->object->key());
    it = published_.erase(it);
  }
}

void Graph::dropOutputsThatTheDocumentHasNot() {
  const auto has = [this](const OutputSpec& what) {
    const auto now = document_.outputs.find(what.name);
    return now != document_.outputs.end() && now->second == what;
  };
  std::erase_if(written_, [&](const auto& item) { return !has(item.second.what); });
  std::erase_if(due_, [&](const auto& item) { return !has(item.second.what); });
  for (const auto& [name, writing] : writing_)
    if (!has(writing.what)) stop(*writing.running);
  unpublish(false);
}

Asker Graph::askerOf(const Running& running) {
  Asker asker;
  asker.check = [&running] {
    if (running.isCancelled) throw Error("cancelled");
  };
  return asker;
}

}  // namespace gxy
