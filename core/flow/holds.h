// SPDX-License-Identifier: Apache-2.0
// The generations of sources that a graph keeps from being given up.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/flow/actions.h"
#include "core/flow/step.h"

namespace gxy::flow {

/// Pins and adoptions. A publisher may want the buffer of a pinned generation back. After a while the graph makes such a generation its
/// own, if it still needs it.
class Holds {
 public:
  struct Hold {
    enum class State { Pinned, Adopting, Adopted };
    uint64_t number = 0;
    std::string source;
    SourceData data;
    State state = State::Pinned;
    std::optional<uint64_t> wantedSince;  ///< in ticks
  };

  /// Pins a generation unless it is held.
  void pin(const std::string& source, const SourceData& data, std::vector<Action>& actions);
  /// Releases all that `isNeeded` does not name.
  template <class F>
  void keepOnly(const F& isNeeded, std::vector<Action>& actions) {
    for (auto it = holds_.begin(); it != holds_.end();) {
      if (isNeeded(it->first)) {
        ++it;
        continue;
      }
      actions.push_back(ReleaseGeneration{it->second.number});
      it = holds_.erase(it);
    }
  }

  void want(const SourceGeneration& id, uint64_t now);
  /// Asks for what has been wanted for `after` ticks and is needed: what is only read until a cancelled evaluation has ended is not.
  template <class F>
  void adopt(uint64_t now, uint64_t after, const F& isNeeded, std::vector<Action>& actions) {
    for (auto& [id, hold] : holds_) {
      if (hold.state != Hold::State::Pinned || !hold.wantedSince || now - *hold.wantedSince < after) continue;
      if (!isNeeded(id)) continue;
      hold.state = Hold::State::Adopting;
      actions.push_back(AdoptGeneration{hold.number});
    }
  }
  void adopted(uint64_t hold);
  /// Returns the generation that cannot be adopted; nothing if it is not held any more. It is asked for again after a while.
  std::optional<SourceGeneration> refused(uint64_t hold, uint64_t now);
  void forget(const SourceGeneration& id) { holds_.erase(id); }

  const Hold* find(const SourceGeneration& id) const;
  /// Returns what is held of an object, newest first.
  std::vector<SourceData> of(Key object) const;
  bool empty() const { return holds_.empty(); }

 private:
  Hold* numbered(uint64_t hold);

  std::map<SourceGeneration, Hold> holds_;
  uint64_t next_ = 1;
};

}  // namespace gxy::flow
