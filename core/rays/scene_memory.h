// SPDX-License-Identifier: Apache-2.0
// Enters the memory of scenes into a ledger.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "core/rays/backend.h"
#include "core/space/ledger.h"
#include "core/space/shared_by.h"

namespace gxy {

/// Enters what scenes hold. What several scenes hold together is entered once, with the first of them, and
/// stays for as long as one of them has its entries. Thread safe.
class SceneMemory {
 public:
  using Entries = std::vector<std::shared_ptr<const LedgerEntry>>;

  /// Returns the entries of a scene. `enter` makes an entry of that many bytes, or throws. The scenes must
  /// live as long as the entries.
  Entries enter(const CompiledScene& scene, const DeviceScene& device,
                const std::function<LedgerEntry(int64_t bytes)>& enter) {
    Entries entries{std::make_shared<const LedgerEntry>(enter(int64_t(scene.bytes() + device.bytes())))};
    for (const auto& all : {scene.sharedBytes(), device.sharedBytes()})
      for (const SharedBytes& shared : all)
        entries.push_back(shared_.get(shared.what, [&] { return enter(int64_t(shared.bytes)); }));
    return entries;
  }

 private:
  SharedBy<const void*, LedgerEntry> shared_;
};

}  // namespace gxy
