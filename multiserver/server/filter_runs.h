// SPDX-License-Identifier: Apache-2.0
// Evaluates filters on all ranks for requests, and names what they make.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "multiserver/server/datasets.h"

namespace gxy {

/// There is one on each rank. Thread safe. All calls but addWorks() are for rank 0, and wait for all ranks.
class FilterRuns {
 public:
  explicit FilterRuns(ServerRank& serverRank) : serverRank_(serverRank) {}
  void addWorks();

  /// Evaluates the filter of one entry. Its inputs are what the request's tenant calls so, all of one moment. The tenant owns the
  /// dataset that is made, or gets its next generation. Returns an object: what the filter tells, and `name`, `type` and
  /// `generation` of the dataset if it makes one. Waits for its turn among the tenant's long works. Throws Error, also when the
  /// request is cancelled; then nothing has changed.
  nlohmann::json make(Request& request, const DatasetSpec& entry, Scope scope);

  /// Carries out what a document says of datasets: reads files, all or nothing, then evaluates filters, each after the filters of its
  /// inputs. Live datasets must be there. Returns what of the files is not used, for their user.
  std::vector<std::string> importAndMake(Request& request, Datasets::Import what);

 private:
  ServerRank& serverRank_;
};

}  // namespace gxy
