// SPDX-License-Identifier: Apache-2.0
// The list of the filters that all programs have.
#include "core/analysis/density_filter.h"
#include "core/analysis/derive_filter.h"
#include "core/analysis/filter.h"
#include "core/analysis/interpolate_filter.h"
#include "core/analysis/isosurface_filter.h"
#include "core/analysis/number_filter.h"
#include "core/analysis/ray_filter.h"
#include "core/analysis/resample_filter.h"
#include "core/analysis/seeds_filter.h"
#include "core/analysis/statistics_filter.h"
#include "core/analysis/stream_tracer_filter.h"

namespace gxy {

void addStandardFilters(Filters& filters) {
  filters.add<DensitySampler>();
  filters.add<Derive>();
  filters.add<Interpolate>();
  filters.add<IsosurfaceSampler>();
  filters.add<NumberFilter>();
  filters.add<RaySampler>();
  filters.add<Resample>();
  filters.add<Seeds>();
  filters.add<StatisticsFilter>();
  filters.add<StreamTracer>();
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
