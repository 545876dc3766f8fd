// SPDX-License-Identifier: Apache-2.0
// A graph document: a state file's JSON, what core/flow needs of it, and how its views look.
#pragma once
#include <functional>
#include <glm/vec2.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/flow/document.h"
#include "core/scene/state_file.h"

namespace gxy {

/// How a view is rendered.
struct ViewLook {
  Visualization visualization;
  std::optional<Camera> camera;    ///< its own, else the document's first
  std::optional<glm::ivec2> size;  ///< of its window, in pixels
  std::string missing;             ///< why a part of it is left out: an operator that is not there
  bool operator==(const ViewLook&) const = default;
};

/// A checked document. Values.
struct GraphDocument {
  nlohmann::json json = nlohmann::json::object();
  flow::Document flow;
  RenderSettings settings;
  std::map<std::string, ViewLook> looks;      ///< by view
  std::map<std::string, OutputSpec> outputs;  ///< by name
  std::vector<std::string> warnings;          ///< of keys that mean nothing

  const DatasetSpec* dataset(const std::string& name) const;
};

/// Something that a document must not say.
struct DocumentProblem {
  std::string path, text;
};

/// Reads a state document, with the files that it names. `what` is its name in messages.
using StateReader = std::function<StateFile(std::string_view text, const std::string& what)>;

/// Returns what an error of flow::CompiledDocument or flow::Flow::edit() says, with the path of the dataset or the view that it names.
DocumentProblem problemOf(const std::string& flowError);

struct ServerRank;
/// Returns a reader that charges the tenant for what it parses. Other than a DocumentReader it does not wait for its turn among the
/// tenant's documents, since whoever reads a graph's document keeps others from editing it. The server rank must outlive it.
StateReader stateReaderOf(ServerRank& serverRank, const std::string& tenant);

inline constexpr size_t kMostDocumentBytes = size_t(1) << 20;
inline constexpr size_t kMostDocumentDepth = 32;

/// Reads a document of the graph `graph`, and checks all of it but what flow::CompiledDocument checks. Sections that may be one object
/// are made lists, and old names of sections new ones, so that paths of edits are the same for all documents. Keys that nothing knows stay.
/// Throws Error "PATH: ..." for the first problem, or adds all of them to `problems` unless that is null.
GraphDocument readGraphDocument(const std::string& graph, nlohmann::json document,
                                const FilterSchemas& filters, const StateReader& readState,
                                std::vector<DocumentProblem>* problems = nullptr);

}  // namespace gxy
