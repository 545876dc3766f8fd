// SPDX-License-Identifier: Apache-2.0
#include "core/comm/error.h"
#include "core/rays/device_fields.h"

namespace gxy {

AdvanceCounters& AdvanceCounters::operator+=(const AdvanceCounters& o) {
  headsAdvanced += o.headsAdvanced;
  cells += o.cells;
  steps += o.steps;
  nsAdvance += o.nsAdvance;
  return *this;
}

std::unique_ptr<DeviceFields> makePlainFields(std::shared_ptr<const CompiledFields>, int) {
  throw Error("lines are not built yet");
}

}  // namespace gxy
