// SPDX-License-Identifier: Apache-2.0
#include "core/rays/field_maker.h"

#include <utility>

#include "core/comm/error.h"

namespace gxy {

FieldMaker::FieldMaker(const Backend& inUse, const BackendRegistry& registry, Ledger* ledger)
    : inUse_(inUse), makeOther_(registry.forFields()), ledger_(ledger) {}

const Backend& FieldMaker::other() {
  const std::lock_guard lock(mutex_);
  if (!other_ && makeOther_) other_ = makeOther_(ledger_);
  if (!other_)
    throw Error("backend " + inUse_.name() +
                " cannot trace lines, and this program has no other one that can");
  return *other_;
}

std::unique_ptr<DeviceFields> FieldMaker::make(std::shared_ptr<const CompiledFields> fields, int rank) {
  if (auto made = inUse_.makeFields(fields, rank)) return made;
  auto made = other().makeFields(std::move(fields), rank);
  if (!made) throw Error("backend " + other().name() + " cannot trace lines, expected one that can");
  return made;
}

}  // namespace gxy
