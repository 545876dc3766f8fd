// SPDX-License-Identifier: Apache-2.0
// A state document for datasets and data files of which nobody has said how they are to be shown.
#pragma once
#include <string>
#include <vector>

#include "gxy/scene/first_look.h"
#include "gxy/server/module.h"

namespace gxy::viewer {

/// One on each rank.
class FirstLooks {
 public:
  explicit FirstLooks(Registration& registration);

  /// Rank 0: the state that shows what the names mean: datasets that the request's tenant sees, else files that clients may
  /// read (of a series by pattern, as step_*.vti, the first). What is a dataset of such a file already is not read again. Datasets come first from where they were read; those that were
  /// read from no file are not in the document. Waits. Throws Error.
  State state(Request& request, const std::vector<std::string>& names, const std::string& array,
              const LookOptions& options) const;

 private:
  nlohmann::json sample(const nlohmann::json& parameters) const;
  LookFacts factsOf(const std::string& tenant, const std::string& name) const;
  bool isOf(const std::string& tenant, const std::string& name, const std::string& file,
            const std::string& array) const;
  std::string fileOf(const std::string& name) const;
  /// Those of the first step, checked already.
  std::vector<std::string> filesToRead(const std::string& name) const;

  Node& node_;
};

}  // namespace gxy::viewer
