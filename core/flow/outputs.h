// SPDX-License-Identifier: Apache-2.0
// What evaluations have made, and which of them have failed.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/data/dataset.h"
#include "core/flow/actions.h"
#include "core/flow/node_key.h"

namespace gxy::flow {

/// What the host says of an output.
struct Made {
  Generation generation = 0;
  double seconds = 0;
  int64_t bytes = 0;
};

/// The outputs that are held, by the keys of their nodes.
class Outputs {
 public:
  struct Output {
    Made made;
    std::vector<Origin> origins;
    uint64_t lastUse = 0;
  };

  void add(const NodeKey& key, const Made& made, std::vector<Origin> origins);
  bool remove(const NodeKey& key) { return outputs_.erase(key) > 0; }
  void use(const NodeKey& key);
  /// Returns null if there is none.
  const Output* find(const NodeKey& key) const;
  /// Returns the output that was used longest ago of those that are not needed.
  std::optional<NodeKey> oldest(const std::set<NodeKey>& needed) const;

 private:
  std::map<NodeKey, Output> outputs_;
  uint64_t uses_ = 0;
};

/// Keys whose evaluation has failed or was cancelled by a user. They are not tried again unless somebody asks.
class Failures {
 public:
  static constexpr size_t kMost = 4096;  ///< the oldest are forgotten

  void add(const NodeKey& key, Problem problem);
  void remove(const NodeKey& key) { failures_.erase(key); }
  void clear() { failures_.clear(); }
  const Problem* find(const NodeKey& key) const;

 private:
  struct Failure {
    Problem problem;
    uint64_t number = 0;
  };
  std::map<NodeKey, Failure> failures_;
  uint64_t number_ = 0;
};

}  // namespace gxy::flow
