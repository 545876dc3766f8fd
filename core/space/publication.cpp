// SPDX-License-Identifier: Apache-2.0
#include "core/space/publication.h"

#include <utility>

#include "core/comm/error.h"

namespace gxy {

Publication::Publication(Objects& objects, Collectives& ranks, std::vector<Item> items, WhenTaken whenTaken)
    : objects_(objects),
      ranks_(ranks),
      items_(std::move(items)),
      whenTaken_(whenTaken),
      data_(items_.size()) {}

Publication::~Publication() {
  for (size_t i = 0; i < taken_; i++) try {
      if (items_[i].generation > 1)
        objects_.abandon(items_[i].key);
      else if (i < stored_)
        objects_.drop(items_[i].key);
    } catch (const Error&) {
      // dropped meanwhile
    }
}

void Publication::take() {
  for (; taken_ < items_.size(); taken_++) {
    const Item& item = items_[taken_];
    if (item.generation > 1 && !objects_.reserve(item.key))
      throw Error(item.label + ": both its generations are in use, so this step is left out");
  }
}

void Publication::store() {
  for (; stored_ < items_.size(); stored_++) {
    const Item& item = items_[stored_];
    Payload data = std::exchange(data_[stored_], {});
    if (item.generation > 1)
      objects_.stage(item.key, std::move(data));
    else if (data.empty())
      throw Error(item.label + ": nothing was staged, expected data");
    else
      objects_.add(item.key, std::move(data), whenTaken_);
  }
}

void Publication::reserve() {
  agree(ranks_, [&] {
    if (ranks_.rank() == 0) take();
  });
  agree(ranks_, [&] { take(); });
}

void Publication::stage(size_t item, Payload data) { data_.at(item) = std::move(data); }

void Publication::commit(const Root& root) {
  agree(ranks_, [&] { store(); });
  agree(ranks_, [&] {
    if (ranks_.rank() == 0 && root.decide) root.decide();
  });
  std::vector<ObjectGeneration> next;
  for (const Item& item : items_)
    if (item.generation > 1) next.push_back({item.key, item.generation});
  if (!next.empty())
    agree(ranks_, [&] {
      if (ranks_.rank() != 0) objects_.commit(next);
    });
  agree(ranks_, [&] {
    if (ranks_.rank() != 0) return;
    objects_.commit(next, [&] {
      if (root.also) root.also();
      taken_ = 0;  // Nothing can fail from here on but observers, who are told afterwards.
    });
  });
  taken_ = 0;
}

}  // namespace gxy
