// SPDX-License-Identifier: Apache-2.0
// A state document for datasets and data files of which nobody has said how they are to be shown.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/collection_file.h"
#include "core/scene/first_look.h"
#include "core/space/ledger.h"
#include "multiserver/server/module.h"

namespace gxy::viewer {

/// A state document for the first step of what it shows, and of series the files of each step.
struct Look {
  struct Step {
    std::optional<double> time;                ///< where it is known
    std::map<std::string, std::string> files;  ///< by dataset, of those that a series gives other files
  };
  State state;
  std::vector<Step> steps;          ///< none: there is one
  std::vector<LedgerEntry> memory;  ///< of the steps
};

/// One on each rank.
class FirstLooks {
 public:
  explicit FirstLooks(Registration& registration);

  /// Rank 0: the state that shows what the names mean: datasets that the request's tenant sees, else files that clients may
  /// read (of a series by pattern, as step_*.vti, or by a collection, the first step). What is a dataset of such a file already is
  /// not read again. Datasets come first from where they were read; those that were read from no file are not in the document.
  /// Whether files of later steps may be read is seen when they are imported. Waits. Throws Error.
  Look look(Request& request, const std::vector<std::string>& names, const std::string& array,
            const LookOptions& options) const;

 private:
  nlohmann::json sample(const nlohmann::json& parameters) const;
  LookFacts factsOf(const std::string& tenant, const std::string& name) const;
  bool isOf(const std::string& tenant, const std::string& name, const std::string& file,
            const std::string& array) const;
  std::vector<std::string> filesOfName(const std::string& name) const;
  /// The first one's files are checked already.
  std::vector<TimeStep> stepsToRead(const std::string& name) const;

  ServerRank& serverRank_;
};

}  // namespace gxy::viewer
