// SPDX-License-Identifier: Apache-2.0
// Publishes new data of several objects, which become current together: on all ranks, or on none.
//
// Every rank makes one Publication of the same items and calls, in this order: reserve(), before the data are made, so that
// no object ever has three buffers; stage() for each item; commit(). An item is the next generation of an object, or a new
// object, whose key nobody else knows until rank 0 gives it a name. Whatever fails on any rank, also between these calls, ends
// the Publication, and what it has reserved and staged is given up.
//
// This part knows keys and generations. The server's rank 0 chooses them, and it alone knows names, the rights to them, and who
// is told of changes (multiserver/server/datasets.h). It takes part in the commit by way of `Root`.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/comm/collectives.h"
#include "core/space/objects.h"

namespace gxy {

/// One thread uses it. After a call has thrown, it can only be destroyed.
class Publication {
 public:
  struct Item {
    Key key;
    Generation generation = 1;  ///< 1: the object is new
    std::string label;          ///< for messages: `dataset "pressure"`
  };

  /// `objects` and `ranks` must outlive this. Objects that are new get `whenTaken`, for their updates by
  /// later Publications.
  Publication(Objects& objects, Collectives& ranks, std::vector<Item> items, WhenTaken whenTaken = {});
  ~Publication();
  Publication(const Publication&) = delete;
  Publication& operator=(const Publication&) = delete;

  const std::vector<Item>& items() const { return items_; }

  /// Collective. Reserves room for all items on all ranks. Rank 0 goes first: a generation that is pinned there keeps all ranks
  /// from giving it up. Where a generation is in the way, reserve() waits as long as the object's own
  /// WhenTaken says, which was stored when the object was added (Objects::add). If there is no room then, all
  /// ranks throw Error.
  void reserve();

  /// Takes the data of an item on this rank.
  void stage(size_t item, Payload data);

  /// What rank 0 does besides in a commit.
  struct Root {
    std::function<void()>
        decide;  ///< throws to refuse; called once all ranks have staged all, so that nothing else can fail
    std::function<void()> also;  ///< called in the moment of rank 0's commit: see Objects::commit
  };
  /// Collective. Makes the data current if all ranks have staged all items and rank 0 does not refuse. Rank 0 goes last, so that
  /// what it shows is on all ranks. Otherwise all ranks throw Error, and nothing has changed. Only rank 0 uses `root`.
  void commit(const Root& root = {});

 private:
  void take();
  void store();

  Objects& objects_;
  Collectives& ranks_;
  const std::vector<Item> items_;
  const WhenTaken whenTaken_;
  std::vector<Payload> data_;  ///< by item
  size_t taken_ = 0,
         stored_ = 0;  ///< items that room has been taken for on this rank, and that it has stored
};

}  // namespace gxy
