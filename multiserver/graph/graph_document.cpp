// SPDX-License-Identifier: Apache-2.0
#include "multiserver/graph/graph_document.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/dataset_type.h"
#include "core/scene/filter_schema.h"
#include "core/scene/json_text.h"
#include "multiserver/protocol/json.h"
#include "multiserver/rendering/cost.h"
#include "multiserver/server/datasets.h"

namespace gxy {
namespace {

using nlohmann::json;

size_t depthOf(const json& value) {
  size_t depth = 0;
  if (value.is_structured())
    for (const json& item : value) depth = std::max(depth, depthOf(item));
  return depth + (value.is_structured() ? 1 : 0);
}

std::string foundText(const json& value) { return inQuotes(protocol::dump(value)); }

/// Messages of readers begin with the place in a text that nobody has seen: "PATH:1:20: ".
std::string withoutPlace(std::string text, const std::string& path) {
  if (!text.starts_with(path + ":")) return text;
  size_t at = path.size();
  for (int number = 0; number < 2 && at < text.size() && text[at] == ':'; number++) {
    size_t end = at + 1;
    while (end < text.size() && std::isdigit(static_cast<unsigned char>(text[end]))) end++;
    if (end == at + 1) break;
    at = end;
  }
  if (text.compare(at, 2, ": ") == 0) at += 2;
  return text.substr(at);
}

class DocumentReading {
 public:
  DocumentReading(const std::string& graph, const FilterSchemas& filters, const StateReader& readState,
                  std::vector<DocumentProblem>* problems)
      : graph_(graph), filters_(filters), readState_(readState), problems_(problems) {}

  GraphDocument read(json document) {
    out_.json = std::move(document);
    if (!attempt("document", [&] { checkLimits(); })) return std::move(out_);
    for (const char* key : {"Datasets", "Operators", "Visualizations", "Cameras", "Outputs"}) {
      const std::string name = key;
      const std::string alias = name == "Visualizations" ? "Visualization"
                                : name == "Cameras"      ? "Camera"
                                                         : "";
      attempt(name, [&] { makeList(name, alias); });
    }
    if (!attempt("document", [&] { checkNodes(); })) return std::move(out_);
    readDatasets();
    readOperators();
    readSettings();
    readViews();
    readOutputs();
    return std::move(out_);
  }

 private:
  static constexpr size_t kMostProblems = 100;
  // Each view has a copy of an operator that it names.
  static constexpr int64_t kMostBytesOfLooks = 64 << 20;

  /// Problems of `work` are problems of the document at this path. Returns false if there are any.
  template <class Work>
  bool attempt(const std::string& path, const Work& work) {
    try {
      work();
      return true;
    } catch (const Error& e) {
      const std::string text = withoutPlace(e.what(), path);
      if (!problems_) throw Error(path + ": " + text);
      if (problems_->size() < kMostProblems) problems_->push_back({path, text});
      return false;
    }
  }

  void checkLimits() {
    if (!out_.json.is_object()) throw Error("expected an object, found " + foundText(out_.json));
    const size_t bytes = protocol::dump(out_.json).size();
    if (bytes > kMostDocumentBytes)
      throw Error("it has " + std::to_string(bytes) + " bytes, expected at most " +
                  std::to_string(kMostDocumentBytes));
    if (depthOf(out_.json) > kMostDocumentDepth)
      throw Error("expected arrays and objects at most " + std::to_string(kMostDocumentDepth) + " deep");
    if (const auto version = out_.json.find("version"); version != out_.json.end() && *version != 1)
      throw Error("`version`: expected 1, found " + foundText(*version) + "; a newer Galaxy may read it");
  }

  // Before anything of them is read.
  void checkNodes() const {
    for (const char* key : {"Datasets", "Operators", "Visualizations", "Outputs"})
      if (section(key).size() > flow::kMostNodes)
        throw Error(inQuotes(key, '`') + ": expected at most " + std::to_string(flow::kMostNodes) +
                    ", found " + std::to_string(section(key).size()));
  }

  void makeList(const std::string& key, const std::string& alias) {
    json& document = out_.json;
    if (!document.is_object()) document = json::object();
    if (!alias.empty() && document.contains(alias)) {
      if (document.contains(key)) throw Error("expected it or " + inQuotes(alias, '`') + ", found both");
      document[key] = std::move(document[alias]);
      document.erase(alias);
    }
    const auto found = document.find(key);
    if (found != document.end() && !found->is_array()) *found = json::array({*found});
  }

  const json& section(const char* key) const {
    static const json none = json::array();
    const auto found = out_.json.find(key);
    return found == out_.json.end() ? none : *found;
  }

  static std::string pathOf(const char* section, size_t place, const json& element) {
    const bool hasName = element.is_object() && element.value("name", json()).is_string();
    return std::string(section) + "[" +
           (hasName ? inQuotes(element["name"].get_ref<const std::string&>()) : std::to_string(place)) + "]";
  }

  static void expectObject(const json& element) {
    if (!element.is_object()) throw Error("expected an object, found " + foundText(element));
  }

  void readDatasets() {
    const json& all = section("Datasets");
    for (size_t i = 0; i < all.size(); i++) {
      const std::string path = pathOf("Datasets", i, all[i]);
      attempt(path, [&] {
        expectObject(all[i]);
        StateFile read = readDatasetEntries(protocol::dump(all[i]), path, nullptr);
        DatasetSpec& dataset = read.state.datasets.at(0);
        checkDatasetName(graph_ + "/" + dataset.name);
        if (dataset.isLive() && dataset.name.starts_with(graph_ + "/"))
          throw Error("`name`: expected data of others; names that begin with " + inQuotes(graph_ + "/") +
                      " are of what this graph makes");
        for (const std::string& w : read.warnings)
          out_.warnings.push_back(path + ": " + withoutPlace(w, path));
        places_.emplace(dataset.name, out_.flow.datasets.size());
        out_.flow.datasets.push_back(std::move(dataset));
      });
    }
  }

  void readOperators() {
    const json& all = section("Operators");
    for (size_t i = 0; i < all.size(); i++) {
      const std::string path = pathOf("Operators", i, all[i]);
      attempt(path, [&] {
        expectObject(all[i]);
        const json name = all[i].value("name", json());
        if (!name.is_string() || name == "")
          throw Error("`name` is missing, expected one by which views call it");
        if (!operators_.emplace(name.get<std::string>(), all[i]).second)
          throw Error("there are two of this name, expected each name once");
        stateOf({{"operators", json::array({plain(all[i])})}}, json(),
                path);  // also of those that no view has
      });
    }
  }

  static json plain(json vis) {
    if (vis.is_object()) vis.erase("name");
    return vis;
  }

  void readSettings() {
    if (!out_.json.contains("Renderer")) return;
    attempt("Renderer", [&] {
      StateFile read = readState_(protocol::dump(json{{"Renderer", out_.json["Renderer"]}}), "Renderer");
      out_.settings = read.state.settings;
      for (const std::string& w : read.warnings)
        out_.warnings.push_back("Renderer: " + withoutPlace(w, "Renderer"));
    });
  }

  /// Adds those datasets to a state that a visualization names and whose types are known.
  void addTypes(json& state, const json& visualization) const {
    std::set<std::string> names;
    for (const json& vis : visualization.value("operators", json::array()))
      if (vis.is_object() && vis.value("dataset", json()).is_string())
        names.insert(vis["dataset"].get<std::string>());
    for (const std::string& name : names) {
      const auto place = places_.find(name);
      if (place == places_.end()) continue;
      const DatasetSpec& d = out_.flow.datasets[place->second];
      std::optional<DatasetType> type = d.type;
      if (!d.filter.empty()) {
        const FilterSchema* filter = filters_.find(d.filter);
        type = filter && filter->makesLike.empty() ? filter->makes : std::nullopt;
      }
      if (type) state["Datasets"].push_back({{"name", name}, {"type", nameOf(*type)}, {"filename", "-"}});
    }
  }

  /// Reads a visualization as a state file has it.
  State stateOf(const json& visualization, const json& camera, const std::string& path) {
    json state{{"Datasets", json::array()}, {"Visualizations", json::array({visualization})}};
    addTypes(state, visualization);
    if (!camera.is_null()) state["Cameras"] = json::array({camera});
    StateFile read = readState_(protocol::dump(state), path);
    for (const std::string& w : read.warnings)
      if (w.find("no dataset ") == std::string::npos)  // states of nodes say that
        out_.warnings.push_back(path + ": " + withoutPlace(w, path));
    return std::move(read.state);
  }

  void readViews() {
    const json& all = section("Visualizations");
    for (size_t i = 0; i < all.size(); i++) {
      const std::string path = pathOf("Visualizations", i, all[i]);
      attempt(path, [&] {
        expectObject(all[i]);
        readView(all[i], path);
      });
    }
  }

  void readView(json view, const std::string& path) {
    flow::ViewSpec spec;
    ViewLook look;
    json resolved = json::array();
    if (const auto operators = view.find("operators"); operators != view.end() && operators->is_array()) {
      checkOperators(operators->size());  // before any is copied
      for (const json& item : *operators) {
        json vis = plain(item);
        if (item.is_string()) {
          const auto known = operators_.find(item.get<std::string>());
          if (known == operators_.end()) {
            look.missing = "there is no operator " + inQuotes(item.get<std::string>());
            continue;
          }
          vis = plain(known->second);
        }
        const json dataset = vis.is_object() ? vis.value("dataset", json()) : json();
        if (dataset.is_string() && std::count(spec.datasets.begin(), spec.datasets.end(), dataset) == 0)
          spec.datasets.push_back(dataset.get<std::string>());
        resolved.push_back(std::move(vis));
      }
      *operators = resolved;
    }
    const bool hasCamera = view.contains("camera") || section("Cameras").empty();
    State state = stateOf(view, hasCamera ? json() : section("Cameras")[0], path);
    look.visualization = std::move(state.visualizations.at(0));
    const ViewSettings settings = std::exchange(look.visualization.view, {});
    spec.name = settings.name;
    spec.follow = settings.follow;
    spec.asItComes = settings.asItComes;
    look.size = settings.size;
    checkCost(look.visualization);
    bytesOfLooks_ += bytesOf(look.visualization);
    if (bytesOfLooks_ > kMostBytesOfLooks)
      throw Error("`operators`: all views have " + std::to_string(bytesOfLooks_) +
                  " bytes of them, expected at most " + std::to_string(kMostBytesOfLooks));
    look.camera = settings.camera;
    if (!state.cameras.empty()) look.camera = state.cameras[0];
    if (spec.name.empty()) return;
    out_.looks.emplace(spec.name, std::move(look));
    out_.flow.views.push_back(std::move(spec));
  }

  void readOutputs() {
    const json& all = section("Outputs");
    for (size_t i = 0; i < all.size(); i++) {
      const std::string path = pathOf("Outputs", i, all[i]);
      attempt(path, [&] {
        expectObject(all[i]);
        StateFile read = readState_(protocol::dump(json{{"Outputs", json::array({all[i]})}}), path);
        for (const std::string& w : read.warnings)
          out_.warnings.push_back(path + ": " + withoutPlace(w, path));
        const OutputSpec& output = read.state.outputs.at(0);
        checkOutput(output);
        if (!out_.outputs.emplace(output.name, output).second)
          throw Error("there are two of this name, expected each name once");
        out_.flow.outputs.push_back(
            {output.name, output.of, std::string(nameOf(output.type)) + " " + output.to});
      });
    }
  }

  void checkOutput(const OutputSpec& output) const {
    const auto dataset = places_.find(output.of);
    if (output.type == OutputSpec::Type::Pictures && dataset != places_.end())
      throw Error("`of`: expected a view, found " + inQuotes(output.of) + ", which is a dataset");
    if (output.type == OutputSpec::Type::Pictures) return;
    if (dataset == places_.end() && out_.looks.contains(output.of))
      throw Error("`of`: expected a dataset, found " + inQuotes(output.of) + ", which is a view");
    if (output.type != OutputSpec::Type::Publish) return;
    checkDatasetName(output.to);
    if (output.to.find('/') != std::string::npos)
      throw Error("`to`: expected a name without /, found " + inQuotes(output.to));
    if (const auto own = places_.find(output.to);
        own != places_.end() && out_.flow.datasets[own->second].isLive())
      throw Error("`to`: " + inQuotes(output.to) + " is what this graph reads; expected another name");
  }

  const std::string& graph_;
  const FilterSchemas& filters_;
  const StateReader& readState_;
  std::vector<DocumentProblem>* const problems_;
  std::map<std::string, size_t> places_;  // of datasets
  std::map<std::string, json> operators_;
  int64_t bytesOfLooks_ = 0;
  GraphDocument out_;
};

}  // namespace

StateReader stateReaderOf(ServerRank& serverRank, const std::string& tenant) {
  return [&serverRank, tenant](std::string_view text, const std::string& what) {
    std::vector<LedgerEntry> memory;
    const auto makeRoom = [&](std::string_view content) {
      memory.push_back(serverRank.takeMemory(tenant, "documents", parsingBytes(content)));
    };
    makeRoom(text);
    const NamedFileReader readFile = [&](const std::string& name) {
      std::string content = serverRank.folders.textOf(name, int64_t(kMaxJsonBytes));
      makeRoom(content);
      return content;
    };
    return readState(text, what, readFile, &serverRank.filters);
  };
}

DocumentProblem problemOf(const std::string& flowError) {
  for (const auto& [kind, section] :
       {std::pair{"dataset \"", "Datasets"}, std::pair{"view \"", "Visualizations"}}) {
    const std::string begin = kind;
    const size_t end = flowError.find('"', begin.size());
    if (!flowError.starts_with(begin) || end == std::string::npos) continue;
    const std::string named = flowError.substr(0, end + 1);
    return {std::string(section) + "[" + named.substr(begin.size() - 1) + "]",
            withoutPlace(flowError, named)};
  }
  return {"document", flowError};
}

const DatasetSpec* GraphDocument::dataset(const std::string& name) const {
  for (const DatasetSpec& d : flow.datasets)
    if (d.name == name) return &d;
  return nullptr;
}

GraphDocument readGraphDocument(const std::string& graph, json document, const FilterSchemas& filters,
                                const StateReader& readState, std::vector<DocumentProblem>* problems) {
  return DocumentReading(graph, filters, readState, problems).read(std::move(document));
}

}  // namespace gxy
