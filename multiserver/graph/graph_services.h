// SPDX-License-Identifier: Apache-2.0
// What the graphs of a server have in common. Rank 0.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/flow/outputs.h"
#include "multiserver/rendering/kept_data.h"

namespace gxy {

struct Rendering;

/// What a filter has made for graphs. Immutable.
struct GraphOutput {
  flow::Made made;
  DatasetType type = DatasetType::Volume;
  nlohmann::json told;
  std::shared_ptr<OwnedObject> object;  ///< null: the filter makes no dataset
};

/// The outputs that graphs hold, by tenant and key: equal nodes of a tenant share one. Thread safe.
class GraphOutputs {
 public:
  void add(const std::string& tenant, const flow::NodeKey& key,
           const std::shared_ptr<const GraphOutput>& output) {
    const std::lock_guard lock(mutex_);
    std::erase_if(outputs_, [](const auto& item) { return item.second.expired(); });
    outputs_[{tenant, key}] = output;
  }
  /// Returns null if no graph holds it.
  std::shared_ptr<const GraphOutput> find(const std::string& tenant, const flow::NodeKey& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = outputs_.find({tenant, key});
    return found == outputs_.end() ? nullptr : found->second.lock();
  }

  /// Forgets an output that nobody but the caller holds, so that no graph takes it any more. Returns false if others hold it.
  bool removeIfUnused(const std::string& tenant, const flow::NodeKey& key,
                      const std::shared_ptr<const GraphOutput>& output) {
    const std::lock_guard lock(mutex_);
    if (output.use_count() > 1 || output->object.use_count() > 1) return false;
    const auto found = outputs_.find({tenant, key});
    if (found != outputs_.end() && found->second.lock() == output) outputs_.erase(found);
    return true;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::pair<std::string, flow::NodeKey>, std::weak_ptr<const GraphOutput>> outputs_;
};

struct GraphServices {
  ServerRank& serverRank;
  std::shared_ptr<Rendering> rendering;
  GraphOutputs outputs;
  std::function<void()> wake;  ///< has Graph::tick() called soon, until it returns false; any thread
};

}  // namespace gxy
