// SPDX-License-Identifier: Apache-2.0
// The data space as a graph sees it: objects with two buffers each, publishers that fill them, pins, and adopted generations.
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/flow/step.h"

namespace gxy::test {

class ObjectSpace {
 public:
  using Id = flow::SourceGeneration;

  struct Name {
    std::string name;
    uint64_t publisher = 0;
    Key object{};  ///< invalid: the name means nothing
  };

  size_t addName(const std::string& name, uint64_t publisher) {
    names.push_back({name, publisher, {}});
    return names.size() - 1;
  }

  /// Whether the next generation of an object has room: its older one is not pinned. Else `wanted` is the one in the way.
  bool hasRoom(const Name& name, std::optional<Id>& wanted) const {
    if (!name.object.valid()) return true;
    const Generation current = current_.at(name.object);
    if (current < 2) return true;
    const Id older{name.object, current - 1};
    if (!pins_.contains(older)) return true;
    wanted = older;
    return false;
  }

  /// Publishes the next generation of a name; the older one goes.
  flow::SourceData publish(Name& name, int64_t step) {
    if (!name.object.valid()) {
      name.object = {nextKey_++};
      current_[name.object] = 0;
    }
    const Generation generation = ++current_[name.object];
    if (generation > 2) buffers_.erase({name.object, generation - 2});
    const Id id{name.object, generation};
    buffers_.insert(id);
    origins[id] = name.publisher == 0 ? std::vector<Origin>{{id.object.value, int64_t(generation)}}
                                      : std::vector<Origin>{{name.publisher, step}};
    return dataOf(id, name.publisher != 0);
  }

  flow::SourceData dataOf(const Id& id, bool withOrigins) const {
    return {id, DatasetType::Volume, withOrigins ? origins.at(id) : std::vector<Origin>()};
  }

  void drop(Name& name) {
    for (Generation generation = 1; generation <= current_[name.object]; generation++)
      if (const Id id{name.object, generation}; !pins_.contains(id)) buffers_.erase(id);
    dropped_.insert(name.object);
    name.object = {};
  }

  bool isThere(const Id& id) const { return buffers_.contains(id) || adopted_.contains(id); }
  void pin(const Id& id) { pins_.insert(id); }
  void unpin(const Id& id) {
    pins_.erase(pins_.find(id));
    if (!pins_.contains(id) && dropped_.contains(id.object)) buffers_.erase(id);
  }
  /// A pin becomes an adoption: the buffer is free.
  void adopt(const Id& id) {
    unpin(id);
    adopted_.insert(id);
  }
  void release(const Id& id) { adopted_.erase(adopted_.find(id)); }

  const std::multiset<Id>& pins() const { return pins_; }
  const std::multiset<Id>& adopted() const { return adopted_; }
  std::optional<Id> current(const Name& name) const {
    if (!name.object.valid()) return std::nullopt;
    return Id{name.object, current_.at(name.object)};
  }

  std::vector<Name> names;
  std::map<Id, std::vector<Origin>> origins;  ///< of all that there ever was

 private:
  std::map<Key, Generation> current_;
  std::set<Key> dropped_;
  std::set<Id> buffers_;
  std::multiset<Id> pins_, adopted_;
  uint64_t nextKey_ = 1000;
};

}  // namespace gxy::test
