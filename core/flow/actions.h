// SPDX-License-Identifier: Apache-2.0
// What a Flow asks its host to do.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/flow/document.h"
#include "core/flow/node_key.h"

namespace gxy::flow {

/// Keep this generation of a source from being given up. If it is gone, answer Flow::lost().
struct PinGeneration {
  uint64_t hold = 0;
  std::string source;
  SourceGeneration data;
};

/// Make the pinned generation the graph's own, so that its publisher gets its buffer back. Answer Flow::adopted() or Flow::refused().
struct AdoptGeneration {
  uint64_t hold = 0;
};

/// Let go of a generation, pinned or adopted. An adoption that is under way is undone; nothing is answered.
struct ReleaseGeneration {
  uint64_t hold = 0;
};

/// Import the file of this source, and say Flow::update() or Flow::sourceFailed().
struct FetchSource {
  std::string source;
};

/// Evaluate a filter. Answer Flow::finished(), failed() or cancelled(), once. An output that is held elsewhere under the same key, by
/// another graph of the tenant, does as well. What it reads is pinned or held until the answer.
struct StartEvaluation {
  struct Item {
    std::string node;
    DataId data;
  };
  struct Input {
    std::string input;
    std::vector<Item> items;
  };
  uint64_t evaluation = 0;
  std::string node;
  NodeKey key;
  std::string filter;
  int version = 1;
  std::string properties;  ///< canonical JSON
  std::vector<Input> inputs;
};

/// Stop an evaluation on all ranks. It is answered like any other, by cancelled() if this stopped it; if it has ended before, by what
/// came of it.
struct CancelEvaluation {
  uint64_t evaluation = 0;
};

/// Give up an output; room is wanted.
struct DropOutput {
  NodeKey key;
};

/// A dataset of a target.
struct ShownData {
  std::string node;
  DataId data;
  bool older = false;  ///< the node's last good output: it has failed since, or is not there yet
  bool operator==(const ShownData&) const = default;
};

/// Why something is not shown, or is older than it should be.
struct Problem {
  std::string node;  ///< where the cause is
  std::string text;
  int rank = -1;
  bool cancelled = false;
  bool operator==(const Problem&) const = default;
};

/// A view shows these data from now on, all at once; an output is made of them, and answered by Flow::written(). The colours of `node`
/// in the document of this revision hold, whoever made the data. No two of them are of different steps of one publisher.
struct ShowData {
  TargetId target;
  uint64_t wave = 0, revision = 0;
  std::vector<ShownData> data;
  std::vector<Problem> problems;
};

/// The data of a view go: it keeps its last picture until the next ShowData. An output that is not written has to give up.
struct HoldPicture {
  TargetId target;
  std::string text;  ///< why
};

/// A node: a dataset, a view or an output of the document.
struct NodeId {
  enum class Kind { Dataset, View, Output };
  Kind kind = Kind::Dataset;
  std::string name;
  auto operator<=>(const NodeId&) const = default;
};

struct NodeState {
  enum class Kind {
    Incomplete,  ///< an input or a value is missing: `text`
    Blocked,     ///< by the node `by`, for the reason `text`
    Waiting,     ///< for what `text` says
    Queued,      ///< everything is there, but for its turn
    Running,     ///< `done` of `of`, `text`
    Done,        ///< `generation`, `seconds`, `bytes`
    Stale,       ///< what is there is of older properties or data, because `text`
    Failed       ///< `text`, `rank`
  };
  Kind kind = Kind::Waiting;
  std::string text;
  std::string by;
  int rank = -1;
  double done = 0, of = 0;
  Generation generation = 0;
  double seconds = 0;
  int64_t bytes = 0;
  uint64_t leftOut = 0;             ///< of a source: generations that no wave took although they were needed
  bool showsOlder = false;          ///< a view shows an older output of this node
  std::optional<NodeKey> output{};  ///< Done, of a filter: which output it is
  bool operator==(const NodeState&) const = default;
};

/// Tell users. At most the newest state of a node matters.
struct ChangeState {
  NodeId node;
  NodeState state;
};

using Action = std::variant<PinGeneration, CancelEvaluation, FetchSource, ShowData, HoldPicture,
                            StartEvaluation, AdoptGeneration, ReleaseGeneration, DropOutput, ChangeState>;

}  // namespace gxy::flow
