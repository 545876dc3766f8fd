// SPDX-License-Identifier: Apache-2.0
// The list of the filters that all programs have.
#include "core/analysis/filter.h"
#include "core/analysis/isosurface_filter.h"
#include "core/analysis/ray_filter.h"
#include "core/analysis/seeds_filter.h"

namespace gxy {

void addStandardFilters(Filters& filters) {
  filters.add<IsosurfaceSampler>();
  filters.add<RaySampler>();
  filters.add<Seeds>();
}

const Filters& standardFilters() {
  static const std::unique_ptr<const Filters> filters = [] {
    auto all = std::make_unique<Filters>();
    addStandardFilters(*all);
    return all;
  }();
  return *filters;
}

}  // namespace gxy
