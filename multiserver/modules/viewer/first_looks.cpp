// SPDX-License-Identifier: Apache-2.0
#include "first_looks.h"

#include <algorithm>
#include <filesystem>

#include "gxy/comm/error.h"
#include "gxy/io/file.h"
#include "gxy/look/file_facts.h"
#include "gxy/look/loaded_facts.h"
#include "gxy/scene/collection_file.h"
#include "gxy/scene/data_files.h"
#include "gxy/server/datasets.h"
#include "gxy/server/session.h"

namespace gxy::viewer {

using nlohmann::json;

FirstLooks::FirstLooks(Registration& registration) : node_(registration.node()) {
  registration.work("viewer.sample", [this](const Work::Call& call) { return sample(call.parameters); });
}

// Every rank: what it has of the values of a dataset.
json FirstLooks::sample(const json& p) const {
  const Pin pin = node_.objects.pin(Key{p.at("key").get<uint64_t>()}, p.at("generation").get<Generation>());
  const auto dataset = pin.get<Dataset>();
  return dataset->volume ? sampleOf(*dataset->volume, *dataset->partitioning)
                         : sampleOf(*dataset->geometry, node_.rank());
}

LookFacts FirstLooks::factsOf(const std::string& tenant, const std::string& name) const {
  const auto [named, pin] = node_.datasets->getPinned(tenant, name);
  const auto dataset = pin.get<Dataset>();
  LookFacts facts;
  facts.dataset = {name, dataset->type, dataset->file, dataset->array, dataset->color, dataset->radiusArray};
  facts.data = dataset->volume ? gxy::factsOf(*dataset->volume) : gxy::factsOf(*dataset->geometry);
  if (!dataset->volume && !valuesCount(dataset->file, dataset->array)) return facts;
  if (dataset->volume) facts.thin = thinAxis(dataset->volume->grid);
  for (const json& of :
       node_.callAll("viewer.sample", {{"key", named.key.value}, {"generation", named.generation}}))
    for (const json& value : of) facts.values.push_back(value.get<float>());
  completeSample(facts);
  return facts;
}

bool FirstLooks::isOf(const std::string& tenant, const std::string& name, const std::string& file,
                      const std::string& array) const {
  const auto dataset = node_.datasets->getPinned(tenant, name).second.get<Dataset>();
  return dataset->file == file && dataset->array == array;
}

// The file, or the first of those that match; patterns are looked for in the folders of clients only.
std::string FirstLooks::fileOf(const std::string& name) const {
  namespace fs = std::filesystem;
  const fs::path path(name);
  for (const fs::path& folder : node_.folders.folders()) {
    std::error_code failed;
    const fs::path place = fs::canonical((folder / path).parent_path(), failed);
    if (failed ||
        std::mismatch(folder.begin(), folder.end(), place.begin(), place.end()).first != folder.end())
      continue;
    try {
      return node_.folders.dataToRead(filesOf((place / path.filename()).string()).front());
    } catch (const Error&) {
      if (path.is_absolute()) break;
    }
  }
  return node_.folders.dataToRead(name);  // or why not
}

std::vector<std::string> FirstLooks::filesToRead(const std::string& name) const {
  const std::string file = fileOf(name);
  if (!isCollection(file)) return {file};
  std::vector<std::string> files;
  const TimeStep first = readCollection(file).front();
  for (const std::string& part : first.files) files.push_back(node_.folders.dataToRead(part));
  return files;
}

State FirstLooks::state(Request& request, const std::vector<std::string>& names, const std::string& array,
                        const LookOptions& options) const {
  const std::string& tenant = request.session().tenant();
  const ReadScope inside = node_.folders.reading();
  std::vector<LookFacts> all;
  const auto taken = [&](const std::string& name) {
    return std::any_of(all.begin(), all.end(), [&](const LookFacts& f) { return f.dataset.name == name; });
  };
  const auto addFile = [&](const std::string& file) {
    const std::string stem = std::filesystem::path(file).stem().string();
    std::string called = stem;
    const auto meansAnother = [&] {
      return taken(called) || (node_.datasets->find(tenant, called) && !isOf(tenant, called, file, array));
    };
    for (int n = 2; meansAnother(); n++) called = stem + "-" + std::to_string(n);
    if (node_.datasets->find(tenant, called)) return all.push_back(factsOf(tenant, called));
    const ReadWatch watch([&] { request.check(); });
    std::vector<LedgerEntry> reading;
    LookFacts facts = factsOfFile(file, array, [&](int64_t bytes) {
      reading.push_back(node_.takeMemory(tenant, "first look", bytes));
    });
    facts.dataset.name = called;
    all.push_back(std::move(facts));
  };
  for (const std::string& name : names) {
    request.check();
    if (node_.datasets->find(tenant, name)) {
      all.push_back(factsOf(tenant, name));
      continue;
    }
    for (const std::string& file : filesToRead(name)) {
      request.check();
      addFile(file);
    }
  }
  State state = firstLook(all, options);
  std::erase_if(state.datasets, [](const DatasetSpec& d) { return d.filename.empty(); });
  return state;
}

}  // namespace gxy::viewer
