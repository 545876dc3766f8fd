// SPDX-License-Identifier: Apache-2.0
#include "core/flow/holds.h"

namespace gxy::flow {

void Holds::pin(const std::string& source, const SourceData& data, std::vector<Action>& actions) {
  if (holds_.contains(data.id)) return;
  const uint64_t number = next_++;
  holds_.emplace(data.id, Hold{number, source, data, Hold::State::Pinned, std::nullopt});
  actions.push_back(PinGeneration{number, source, data.id});
}

void Holds::want(const SourceGeneration& id, uint64_t now) {
  const auto found = holds_.find(id);
  if (found != holds_.end() && !found->second.wantedSince) found->second.wantedSince = now;
}

void Holds::adopted(uint64_t hold) {
  if (Hold* found = numbered(hold)) found->state = Hold::State::Adopted;
}

std::optional<SourceGeneration> Holds::refused(uint64_t hold, uint64_t now) {
  Hold* found = numbered(hold);
  if (!found) return std::nullopt;
  found->state = Hold::State::Pinned;
  found->wantedSince = now;
  return found->data.id;
}

const Holds::Hold* Holds::find(const SourceGeneration& id) const {
  const auto found = holds_.find(id);
  return found == holds_.end() ? nullptr : &found->second;
}

std::vector<SourceData> Holds::of(Key object) const {
  std::vector<SourceData> out;
  for (auto it = holds_.rbegin(); it != holds_.rend(); ++it)
    if (it->first.object == object) out.push_back(it->second.data);
  return out;
}

Holds::Hold* Holds::numbered(uint64_t hold) {
  for (auto& [id, found] : holds_)
    if (found.number == hold) return &found;
  return nullptr;
}

}  // namespace gxy::flow
