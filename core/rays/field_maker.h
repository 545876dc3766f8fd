// SPDX-License-Identifier: Apache-2.0
// FieldMaker: fields for lines, on whichever backend can advance them.
#pragma once
#include <memory>
#include <mutex>

#include "core/rays/backend.h"
#include "core/rays/device_fields.h"

namespace gxy {

class Ledger;

/// Makes fields on the backend in use. If that cannot advance lines, it makes them on the backend that the
/// registry has for them (BackendRegistry::forFields), which is made when it is needed first. Thread safe.
/// Fields must be destroyed before it.
class FieldMaker {
 public:
  /// `inUse` must outlive the object. `ledger` is as in BackendRegistry::make().
  FieldMaker(const Backend& inUse, const BackendRegistry& registry, Ledger* ledger = nullptr);

  /// Makes fields for the partitions of a rank. Throws Error if no backend can, and what backends throw.
  std::unique_ptr<DeviceFields> make(std::shared_ptr<const CompiledFields> fields, int rank);

 private:
  const Backend& other();

  const Backend& inUse_;
  const BackendRegistry::Maker makeOther_;
  Ledger* const ledger_;
  std::mutex mutex_;
  std::unique_ptr<Backend> other_;
};

}  // namespace gxy
