// SPDX-License-Identifier: Apache-2.0
// What a document comes to for one step of its sources.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/flow/actions.h"
#include "core/flow/document.h"
#include "core/flow/outputs.h"
#include "core/flow/step.h"

namespace gxy::flow {

/// Computes keys of a document's nodes, and remembers each node's last, since most do not change from call to call.
class NodeKeys {
 public:
  explicit NodeKeys(std::shared_ptr<const CompiledDocument> document);

  const CompiledDocument& document() const { return *document_; }
  /// Returns the key of each filter in `closure`, by place; none for a filter that reads a source that `step` does not have.
  std::vector<std::optional<NodeKey>> of(const std::vector<size_t>& closure, const Step& step);

 private:
  struct Last {
    std::vector<KeyInput> inputs;
    NodeKey key;
  };
  std::shared_ptr<const CompiledDocument> document_;
  std::vector<std::optional<Last>> last_;
};

/// What there is of a node.
struct Outcome {
  enum class Kind { None, There, Problem, Pending };  ///< None: nobody asked for it
  Kind kind = Kind::None;
  DataId data{};         ///< There
  Problem problem{};     ///< Problem
  bool isCause = false;  ///< of a problem: it is the node's own, and not that of a node which it reads
};

/// What there is, beside a document, that outcomes depend on.
struct Stock {
  Outputs outputs;
  Failures failures;
  std::map<std::string, Problem> sourceFailures;  ///< by source
  std::map<std::string, NodeKey> lastGood;        ///< by node: the output that it had last
};

/// Returns the outcome of each node of `closure`, by place.
std::vector<Outcome> outcomes(NodeKeys& keys, const std::vector<size_t>& closure, const Step& step,
                              const Stock& stock);

/// What a target shows.
struct Picture {
  std::vector<ShownData> data;
  std::vector<Problem> problems;
  bool isPending = false;  ///< something that it shows is still to be made
  bool operator==(const Picture&) const = default;
};

/// Returns what a target shows for these outcomes. In place of what has a problem, and with Target::asItComes of what is pending, it
/// shows the node's last good output, if that mixes no steps with what is there; else nothing.
Picture pictureOf(const CompiledDocument& document, const Target& target,
                  const std::vector<Outcome>& outcomes, const Step& step, const Stock& stock);

}  // namespace gxy::flow
