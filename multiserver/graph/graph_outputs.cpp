// SPDX-License-Identifier: Apache-2.0
// What a graph makes of data beside showing them: files, pictures and names.
#include <algorithm>
#include <filesystem>

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
  stopOutput(name);
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
    written_[name] = {"", problem, -1};
    return flow_.written(name, action.wave);
  }
  OutputJob job{found->second, action.wave, std::move(items), {}, {}, {}};
  if (isPicture) {
    job.look = look->second;
    job.settings = document_.settings;
    for (const DatasetSpec& d : document_.flow.datasets) job.colors[d.name] = d.color;
  }
  const auto running = std::make_shared<Running>(name);
  writing_[name] = running;
  post([this, job = std::move(job), running] { makeOutput(job, running); });
}

void Graph::stopOutput(const std::string& name) {
  const auto found = writing_.find(name);
  if (found == writing_.end()) return;
  stop(*found->second);
  writing_.erase(found);
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
  const auto found = writing_.find(name);
  if (isEnded_ || found == writing_.end() || found->second != running) return;
  writing_.erase(found);
  const Failure failure = failureOf(error);
  written_[name] = {file, failure.text, failure.rank};
  flow_.written(name, job.wave);
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
  const auto named = datasets.find(tenant_, job.what.to);
  if (named &&
      (before == published_.end() || !named->ofGraph || named->key != before->second.output->object->key()))
    throw Error("the name " + inQuotes(job.what.to) + " is in use, expected a free one");
  datasets.nameOfGraph(tenant_, job.what.to, object, made->second->type);
  published_[job.what.name] = {job.what.to, made->second};
}

// Takes names back that the document does not give any more, or that all lose.
void Graph::unpublish(bool all) {
  for (auto it = published_.begin(); it != published_.end();) {
    const auto now = document_.outputs.find(it->first);
    if (!all && now != document_.outputs.end() && now->second.type == OutputSpec::Type::Publish &&
        now->second.to == it->second.name) {
      ++it;
      continue;
    }
    services_.serverRank.datasets->unnameOfGraph(tenant_, it->second.name, it->second.output->object->key());
    it = published_.erase(it);
  }
}

Asker Graph::askerOf(const Running& running) {
  Asker asker;
  asker.check = [&running] {
    if (running.isCancelled) throw Error("cancelled");
  };
  return asker;
}

}  // namespace gxy
