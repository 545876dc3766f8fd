// SPDX-License-Identifier: Apache-2.0
// EmbreeFields: fields through which lines go, as the ISPC kernels read them.
#pragma once
#include <memory>

#include "core/rays/flow_views.h"

namespace gxy {

class EmbreeFields final : public DeviceFields {
 public:
  EmbreeFields(std::shared_ptr<const CompiledFields> fields, int rank);

  void advance(int partition, HeadList heads, const TraceOptions& options, Done done) const override;
  size_t bytes() const override { return bytesOf(parts_); }

 private:
  void addPoints(const FlowPart& part, const TraceOptions& options, const HeadList& heads,
                 const StoredView& points, size_t count, PathPoints& out) const;

  std::shared_ptr<const CompiledFields> fields_;
  FlowParts parts_;
};

}  // namespace gxy
