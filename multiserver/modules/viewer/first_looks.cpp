// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/first_looks.h"

#include <algorithm>
#include <filesystem>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/look/file_facts.h"
#include "core/look/loaded_facts.h"
#include "core/scene/data_files.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/session.h"

namespace gxy::viewer {

using nlohmann::json;

namespace {

/// What one name means: a series, and the datasets that have its files.
struct Series {
  std::string name;
  std::vector<std::string> datasets;
  std::vector<TimeStep> steps;
};

/// How many files steps have, and the bytes that they take until a reply has them as text.
std::pair<int64_t, int64_t> sizeOf(const std::vector<TimeStep>& steps) {
  constexpr int64_t kEach = 400;  // nodes of maps and of JSON
  int64_t count = 0, bytes = 0;
  for (const TimeStep& step : steps)
    for (const std::string& file : step.files) {
      count++;
      bytes += kEach + 4 * int64_t(file.size());
    }
  return {count, bytes};
}

std::vector<Look::Step> together(const std::vector<Series>& all) {
  if (all.empty()) return {};
  std::vector<std::string> names;
  std::vector<size_t> counts;
  for (const Series& series : all) {
    names.push_back(series.name);
    counts.push_back(series.steps.size());
  }
  std::vector<Look::Step> steps(commonSteps(names, counts));
  for (size_t n = 0; n < steps.size(); n++)
    for (const Series& series : all) {
      const TimeStep& step = series.steps[n];
      if (!steps[n].time) steps[n].time = step.time;
      for (size_t i = 0; i < step.files.size(); i++) steps[n].files[series.datasets[i]] = step.files[i];
    }
  return steps;
}

}  // namespace

FirstLooks::FirstLooks(Registration& registration) : serverRank_(registration.serverRank()) {
  registration.work("viewer.sample", [this](const Work::Call& call) { return sample(call.parameters); });
}

// Every rank: what it has of the values of a dataset.
json FirstLooks::sample(const json& p) const {
  const Pin pin =
      serverRank_.objects.pin(Key{p.at("key").get<uint64_t>()}, p.at("generation").get<Generation>());
  const auto dataset = pin.get<Dataset>();
  return sampleOf(*dataset);
}

LookFacts FirstLooks::factsOf(const std::string& tenant, const std::string& name) const {
  const auto [named, pin] = serverRank_.datasets->getPinned(tenant, name);
  const auto dataset = pin.get<Dataset>();
  LookFacts facts;
  facts.dataset = {name,           typeOf(*dataset),     dataset->file,  dataset->array,
                   dataset->color, dataset->radiusArray, dataset->fields};
  facts.data = gxy::factsOf(*dataset);
  if (dataset->geometry && !valuesCount(dataset->file, dataset->array)) return facts;
  if (dataset->volume) facts.thin = thinAxis(dataset->volume->grid);
  for (const json& of :
       serverRank_.callAll("viewer.sample", {{"key", named.key.value}, {"generation", named.generation}}))
    for (const json& value : of) facts.values.push_back(value.get<float>());
  completeSample(facts);
  return facts;
}

bool FirstLooks::isOf(const std::string& tenant, const std::string& name, const std::string& file,
                      const std::string& array) const {
  const auto dataset = serverRank_.datasets->getPinned(tenant, name).second.get<Dataset>();
  return dataset->file == file && dataset->array == array;
}

// The file, or those that match; patterns are looked for in the folders of clients only. The first may be read.
std::vector<std::string> FirstLooks::filesOfName(const std::string& name) const {
  namespace fs = std::filesystem;
  const fs::path path(name);
  for (const fs::path& folder : serverRank_.folders.folders()) {
    std::error_code failed;
    const fs::path place = fs::canonical((folder / path).parent_path(), failed);
    if (failed ||
        std::mismatch(folder.begin(), folder.end(), place.begin(), place.end()).first != folder.end())
      continue;
    try {
      std::vector<std::string> files = filesOf((place / path.filename()).string());
      files.front() = serverRank_.folders.dataToRead(files.front());
      return files;
    } catch (const Error&) {
      if (path.is_absolute()) break;
    }
  }
  return {serverRank_.folders.dataToRead(name)};  // or why not
}

std::vector<TimeStep> FirstLooks::stepsToRead(const std::string& name) const {
  std::vector<std::string> files = filesOfName(name);
  for (std::string& file : files)
    if (isCollection(file)) file = serverRank_.folders.dataToRead(file);
  std::vector<TimeStep> steps = stepsOfFiles(files);
  for (std::string& file : steps.front().files) file = serverRank_.folders.dataToRead(file);
  return steps;
}

Look FirstLooks::look(Request& request, const std::vector<std::string>& names, const std::string& array,
                      const LookOptions& options) const {
  const std::string& tenant = request.session().tenant();
  const ReadScope inside = serverRank_.folders.reading();
  std::vector<LookFacts> all;
  const auto taken = [&](const std::string& name) {
    return std::any_of(all.begin(), all.end(), [&](const LookFacts& f) { return f.dataset.name == name; });
  };
  const auto addFile = [&](const std::string& file) {
    const std::string stem = std::filesystem::path(file).stem().string();
    std::string called = stem;
    const auto meansAnother = [&] {
      return taken(called) ||
             (serverRank_.datasets->find(tenant, called) && !isOf(tenant, called, file, array));
    };
    for (int n = 2; meansAnother(); n++) called = stem + "-" + std::to_string(n);
    if (serverRank_.datasets->find(tenant, called)) return all.push_back(factsOf(tenant, called));
    const ReadWatch watch([&] { request.check(); });
    std::vector<LedgerEntry> reading;
    LookFacts facts = factsOfFile(file, array, options.looksInside(), [&](int64_t bytes) {
      reading.push_back(serverRank_.takeMemory(tenant, "first look", bytes));
    });
    facts.dataset.name = called;
    all.push_back(std::move(facts));
  };
  constexpr size_t kNames = 64;  // as many operators as a rendering may have
  if (names.size() > kNames)
    throw Error("there are " + std::to_string(names.size()) + " names, expected at most " +
                std::to_string(kNames));
  std::vector<Series> found;
  std::vector<LedgerEntry> memory;
  int64_t files = 0;
  for (const std::string& name : names) {
    request.check();
    if (serverRank_.datasets->find(tenant, name)) {
      all.push_back(factsOf(tenant, name));
      continue;
    }
    Series series{name, {}, stepsToRead(name)};
    const auto [count, bytes] = sizeOf(series.steps);
    files += count;
    constexpr int64_t kFiles = 100'000;
    if (files > kFiles)
      throw Error(name + ": with it there are " + std::to_string(files) +
                  " files in all steps, expected at most " + std::to_string(kFiles));
    memory.push_back(serverRank_.takeMemory(tenant, "first look", bytes));
    for (const std::string& file : series.steps.front().files) {
      request.check();
      addFile(file);
      series.datasets.push_back(all.back().dataset.name);
    }
    if (series.steps.size() > 1) found.push_back(std::move(series));
  }
  Look look{firstLook(all, options), together(found), std::move(memory)};
  std::erase_if(look.state.datasets, [](const DatasetSpec& d) { return d.filename.empty(); });
  return look;
}

}  // namespace gxy::viewer
