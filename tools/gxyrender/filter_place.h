// SPDX-License-Identifier: Apache-2.0
// What filters are given on a rank of gxyrender.
#pragma once
#include "core/analysis/sampler.h"
#include "core/analysis/tracer.h"
#include "core/rays/field_maker.h"
#include "tools/gxyrender/load.h"

namespace gxy {

/// There is one on each rank, for a whole run. All arguments must outlive it.
class FilterPlace {
 public:
  /// `runners`: most tasks of each kind at once; 0: no limit.
  FilterPlace(Transport& transport, int runners, const BackendRegistry& registry, const Backend& backend,
              Ledger& ledger)
      : tracer_(transport, tracerOptions(runners, ledger)),
        fieldMaker_(backend, registry, &ledger),
        sampler_(transport, backend, samplerOptions(runners, registry, ledger)) {
    services_.takeMemory = [&ledger](const std::string& purpose, int64_t bytes) {
      return ledger.enter(kTenant, purpose, bytes);
    };
    services_.tracer = &tracer_;
    services_.fieldMaker = &fieldMaker_;
    services_.sampler = &sampler_;
    services_.tenant = kTenant;
  }
  const FilterServices& services() const { return services_; }

 private:
  static Tracer::Options tracerOptions(int runners, Ledger& ledger) {
    Tracer::Options options;
    options.runners = runners;
    options.ledger = &ledger;
    options.tenant = kTenant;
    return options;
  }
  static Sampler::Options samplerOptions(int runners, const BackendRegistry& registry, Ledger& ledger) {
    Sampler::Options options;
    options.runners = runners;
    options.ledger = &ledger;
    options.tenant = kTenant;
    options.other = registry.forFields();
    return options;
  }

  Tracer tracer_;
  FieldMaker fieldMaker_;
  Sampler sampler_;
  FilterServices services_;
};

}  // namespace gxy
