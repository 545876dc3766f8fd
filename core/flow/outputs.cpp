// SPDX-License-Identifier: Apache-2.0
#include "core/flow/outputs.h"

#include <algorithm>
#include <utility>

namespace gxy::flow {

void Outputs::add(const NodeKey& key, const Made& made, std::vector<Origin> origins) {
  outputs_[key] = {made, std::move(origins), ++uses_};
}

void Outputs::use(const NodeKey& key) {
  if (const auto found = outputs_.find(key); found != outputs_.end()) found->second.lastUse = ++uses_;
}

const Outputs::Output* Outputs::find(const NodeKey& key) const {
  const auto found = outputs_.find(key);
  return found == outputs_.end() ? nullptr : &found->second;
}

std::optional<NodeKey> Outputs::oldest(const std::set<NodeKey>& needed) const {
  std::optional<NodeKey> oldest;
  for (const auto& [key, output] : outputs_)
    if (!needed.contains(key) && (!oldest || output.lastUse < outputs_.at(*oldest).lastUse)) oldest = key;
  return oldest;
}

void Failures::add(const NodeKey& key, Problem problem) {
  failures_[key] = {std::move(problem), ++number_};
  if (failures_.size() <= kMost) return;
  failures_.erase(std::min_element(failures_.begin(), failures_.end(), [](const auto& a, const auto& b) {
    return a.second.number < b.second.number;
  }));
}

const Problem* Failures::find(const NodeKey& key) const {
  const auto found = failures_.find(key);
  return found == failures_.end() ? nullptr : &found->second.problem;
}

}  // namespace gxy::flow
