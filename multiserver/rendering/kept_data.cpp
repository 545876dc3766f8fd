// SPDX-License-Identifier: Apache-2.0
#include "multiserver/rendering/kept_data.h"

#include <utility>

namespace gxy {

OwnedObject::~OwnedObject() {
  if (!isDropped_)
    serverRank_.work.broadcast("datasets.drop", {{"key", key_.value}}, [](std::vector<Work::Reply>) {});
}

void OwnedObject::drop() {
  isDropped_ = true;
  serverRank_.callAll("datasets.drop", {{"key", key_.value}});
}

KeptData::KeptData(NamedDataset shown, Pin pin) : shown_(std::move(shown)), pin_(std::move(pin)) {}

KeptData::KeptData(NamedDataset shown, std::shared_ptr<const OwnedObject> object)
    : shown_(std::move(shown)), object_(std::move(object)) {}

ObjectGeneration KeptData::where() const {
  const std::lock_guard lock(mutex_);
  return object_ ? ObjectGeneration{object_->key(), 1} : ObjectGeneration{shown_.key, shown_.generation};
}

void KeptData::adopt(std::shared_ptr<const OwnedObject> object) {
  Pin pin;  // let go of without the lock
  const std::lock_guard lock(mutex_);
  object_ = std::move(object);
  pin = std::move(pin_);
}

bool KeptData::isOwned() const {
  const std::lock_guard lock(mutex_);
  return object_ != nullptr;
}

}  // namespace gxy
