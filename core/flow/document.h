// SPDX-License-Identifier: Apache-2.0
// The document of a graph, checked, and with its names replaced by places.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/scene/filter_schema.h"

namespace gxy::flow {

/// A view: what one window may show.
struct ViewSpec {
  std::string name;
  std::vector<std::string> datasets;  ///< names of the datasets that it shows
  bool follow = true;                 ///< newer data are shown by themselves
  bool asItComes = false;             ///< each dataset is shown when it is there, not only all together
  bool operator==(const ViewSpec&) const = default;
};

/// What is done with data beside showing them: files, pictures. It needs them whether or not there is a window.
struct OutputSpec {
  std::string name;
  std::string of;      ///< a dataset or a view
  std::string what{};  ///< what is made; any text. Another text is another output
  bool operator==(const OutputSpec&) const = default;
};

/// What a graph document says that matters for its data. Positions, notes, cameras and looks do not, and are not here.
struct Document {
  std::vector<DatasetSpec> datasets;
  std::vector<ViewSpec> views;
  std::vector<OutputSpec> outputs;
  bool operator==(const Document&) const = default;
};

inline constexpr size_t kMostNodes = 1000;  ///< datasets, views and outputs of a document
inline constexpr size_t kMostEdges = 4096;  ///< names that they use

/// Why a node cannot be evaluated, whatever the data are.
struct Defect {
  enum class Kind { None, Incomplete, Blocked };
  Kind kind = Kind::None;
  std::string node;  ///< which has the defect; of a blocked node the one that blocks it
  std::string text;
};

/// A dataset of a document. A source has neither inputs nor a filter.
struct Node {
  DatasetSpec spec;  ///< its properties in canonical JSON, with defaults
  int version = 1;   ///< of the filter
  Defect defect;
  struct Port {
    std::string input;
    unsigned types = 0;          ///< that it takes: bits of 1 << DatasetType
    std::vector<size_t> places;  ///< of the nodes that are read
  };
  std::vector<Port> ports;  ///< sorted by name

  bool isSource() const { return spec.filter.empty(); }
  bool canEvaluate() const { return !isSource() && defect.kind == Defect::Kind::None; }
};

/// Something that needs data: a view, an output, or somebody who said `run`.
struct TargetId {
  enum class Kind { View, Output, Run };
  Kind kind = Kind::View;
  std::string name{};
  auto operator<=>(const TargetId&) const = default;
};

struct Target {
  TargetId id;
  bool follow = true, asItComes = false;
  std::vector<size_t> shows;    ///< places of nodes, each once
  std::vector<Defect> missing;  ///< names that no dataset has
  std::vector<size_t>
      closure;  ///< all nodes that it needs, in order of evaluation; nodes with defects are left out
  std::vector<size_t> sources;  ///< those of the closure that are sources
};

/// A checked document. It is immutable.
class CompiledDocument {
 public:
  CompiledDocument() = default;
  /// Checks everything before anything is kept. Throws Error for: a name that is empty or given twice, an input that the filter does
  /// not have, a dataset of another type (both named), a cycle (named), properties that the filter does not take, and more than
  /// kMostNodes or kMostEdges. What a user may still be about to add is no error but the node's defect: an input or a property that
  /// is missing, a name that no dataset has, a filter that this program does not have.
  CompiledDocument(const Document& document, const FilterSchemas& filters);

  const Document& document() const { return document_; }
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<size_t>& order() const { return order_; }      ///< filters, each after what it reads
  const std::vector<Target>& targets() const { return targets_; }  ///< views, then outputs
  const std::vector<std::string>& warnings() const {
    return warnings_;
  }  ///< of properties that filters do not know

  std::optional<size_t> place(const std::string& dataset) const;
  const Target* target(const TargetId& id) const;
  /// Returns what evaluates a node.
  Target only(size_t node) const;
  /// Returns what together evaluates all nodes that can be: a target for each that no other of them reads.
  std::vector<Target> everything() const;

 private:
  void compileNode(size_t place, const FilterSchemas& filters);
  void findDefects();
  Target show(TargetId id, const std::vector<std::string>& datasets) const;
  void close(Target& target) const;

  Document document_;
  std::vector<Node> nodes_;
  std::vector<size_t> order_;
  std::vector<Target> targets_;
  std::vector<std::string> warnings_;
  std::vector<std::pair<std::string, size_t>> places_;  // sorted
};

/// Throws the errors of names and limits that CompiledDocument names.
void checkNamesAndLimits(const Document& document);

/// Throws Error if an input that the filter does not have is given, or a dataset of another type; and if a view shows a dataset of a
/// filter that makes none.
void checkTypes(const Document& document, const FilterSchemas& filters);

/// Reads a node's properties as its filter does, and returns them as canonical JSON. Returns nothing, and the name of the property in
/// `missing`, if one that is required is not there. Throws Error for what the filter does not take.
std::optional<std::string> canonicalProperties(const DatasetSpec& dataset, const FilterSchema& filter,
                                               std::string& missing, std::vector<std::string>& warnings);

}  // namespace gxy::flow
