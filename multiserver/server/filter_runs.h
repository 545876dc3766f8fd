// SPDX-License-Identifier: Apache-2.0
// Evaluates filters on all ranks for requests, and names what they make.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "multiserver/server/datasets.h"

namespace gxy {

/// Returns what clients are told of the filters that there are: `filters`, with their inputs and properties, and `text`.
nlohmann::json described(const Filters& filters);

/// There is one on each rank. Thread safe. All calls but addWorks() are for rank 0, and wait for all ranks.
class FilterRuns {
 public:
  explicit FilterRuns(ServerRank& serverRank) : serverRank_(serverRank) {}
  void addWorks();

  struct Made {
    size_t entry = 0;  ///< its place
    nlohmann::json
        told;  ///< by the filter, with `name`, `type` and `generation` of the dataset if it makes one
    std::optional<DatasetDraft> dataset;
  };
  /// Evaluates the filters of entries, each after the filters of its inputs, and returns what they have made, in this order. Inputs are
  /// what the request's tenant calls so, all of one moment: of a simulation, those of one step. The tenant owns the datasets that are
  /// made, or gets their next generations. Waits for its turns among the tenant's long works. Throws Error, also when the request is
  /// cancelled; what has been made before stays.
  std::vector<Made> make(Request& request, const std::vector<DatasetSpec>& entries, Scope scope);

  /// Carries out what a document says of datasets: reads files, all or nothing, then evaluates filters as make() does. Live datasets
  /// must be there. With `onlyMissing` nothing is made again that is what its entry would make now. `pinned` gets what filters have read
  /// and made, and the datasets of these names `shown` that exist, of the same moment. Returns what of the files is not used, for
  /// their user.
  std::vector<std::string> importAndMake(Request& request, Datasets::Import what,
                                         const std::vector<std::string>& shown, PinnedData& pinned);
  std::vector<std::string> importAndMake(Request& request, Datasets::Import what);

  /// An evaluation whose output gets no name, for a graph.
  struct Evaluation {
    struct Source {
      std::string input, name;  ///< of the filter; of the dataset, for messages
      ObjectGeneration data;
      Pin pin;  ///< on rank 0
    };
    std::string tenant;
    std::string label;    ///< for messages: what is made
    std::string purpose;  ///< of its memory, in the ledger
    std::string filter, properties;
    /// Returns what is read, the sources of each input together. It is called once, when the tenant's turn has come. The pins are
    /// let go of once all ranks have the data, which whoever asks must keep from being given up from then on.
    std::function<std::vector<Source>()> sources;
    std::function<void(uint64_t exchange)> begun = [](uint64_t) {};  ///< what to cancel
  };
  struct Evaluated {
    Key key;  ///< of the new object, of generation 1; invalid: the filter makes no dataset
    DatasetType type = DatasetType::Volume;
    int64_t bytes = 0;  ///< on all ranks
    nlohmann::json told;
  };
  /// Evaluates a filter on all ranks, after its turn among the tenant's long works. Throws NoRoom, and Error also for what `asker.check`
  /// throws; then nothing has changed.
  Evaluated evaluate(const Asker& asker, const Evaluation& what);

 private:
  void taken(uint64_t exchange);
  std::vector<Made> makeAll(Request& request, const std::vector<DatasetSpec>& entries, Scope scope,
                            bool onlyMissing, const std::vector<std::string>& shown, PinnedData& pinned);
  Made makeOne(Request& request, const DatasetSpec& entry, Scope scope, PinnedData& pinned);
  bool makesDataset(const DatasetSpec& entry) const;
  bool isMade(const std::string& tenant, const DatasetSpec& entry, PinnedData& pinned) const;

  ServerRank& serverRank_;
  std::mutex mutex_;
  std::map<uint64_t, std::vector<Pin>> reading_;  ///< rank 0: what evaluations read, until all ranks have it
};

}  // namespace gxy
