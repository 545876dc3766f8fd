// SPDX-License-Identifier: Apache-2.0
// Data that somebody keeps for pictures and filters, wherever in the data space they are now. Rank 0.
#pragma once
#include <memory>
#include <mutex>

#include "multiserver/server/datasets.h"

namespace gxy {

/// An object without a publisher, which all ranks hold. When the last handle goes, all ranks drop it. Immutable.
class OwnedObject {
 public:
  OwnedObject(ServerRank& serverRank, Key key) : serverRank_(serverRank), key_(key) {}
  ~OwnedObject();
  OwnedObject(const OwnedObject&) = delete;
  OwnedObject& operator=(const OwnedObject&) = delete;

  Key key() const { return key_; }
  /// Has all ranks drop it now, and waits for that. Nobody may use it any more.
  void drop();

 private:
  ServerRank& serverRank_;
  const Key key_;
  bool isDropped_ = false;
};

/// One generation of a dataset that is kept: pinned, or an object of its own. Thread safe.
class KeptData {
 public:
  /// `shown` is what users are told of it. Its key and generation name these data for ever.
  KeptData(NamedDataset shown, Pin pin);
  KeptData(NamedDataset shown, std::shared_ptr<const OwnedObject> object);

  const NamedDataset& shown() const { return shown_; }
  /// Where all ranks have it now.
  ObjectGeneration where() const;
  /// The data are now this object, too, and are not pinned any more.
  void adopt(std::shared_ptr<const OwnedObject> object);
  bool isOwned() const;

 private:
  const NamedDataset shown_;
  mutable std::mutex mutex_;
  Pin pin_;
  std::shared_ptr<const OwnedObject> object_;
};

}  // namespace gxy
