// SPDX-License-Identifier: Apache-2.0
// Verb `histogram`: how often the values of a dataset are in which bin.
#pragma once
#include <deque>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "multiserver/server/module.h"

namespace gxy {

/// The last histograms that were made. An object's key is never used again, so what is kept is never wrong. Thread safe.
class Histograms {
 public:
  static constexpr int64_t kMostBins = 65536;  ///< of all that are kept

  /// What a histogram is of.
  struct Of {
    Key object;
    Generation generation = 0;
    int bins = 0;
    std::optional<int> component;
    bool operator==(const Of&) const = default;
  };
  std::optional<nlohmann::json> find(const Of& of) const;
  void keep(const Of& of, nlohmann::json histogram);

 private:
  mutable std::mutex mutex_;
  std::deque<std::pair<Of, nlohmann::json>> kept_;  ///< the newest last
  int64_t bins_ = 0;                                ///< of all that are kept
};

/// Verb `histogram`, on rank 0. Evaluates Statistics on all ranks unless the histogram is kept.
nlohmann::json histogram(Histograms& histograms, Request& request, protocol::Arguments arguments);

}  // namespace gxy
