// SPDX-License-Identifier: Apache-2.0
// A module with a filter that runs as long as a test wants, and fails on the rank that it names.
#include <chrono>
#include <filesystem>
#include <thread>

#include "core/analysis/filter.h"
#include "multiserver/server/module.h"

namespace {

using namespace gxy;

/// Gives its input back.
struct Trial {
  std::string gate;
  int failsOn = -1;

  static FilterInfo info() {
    return {"Trial", 1, "Its input.", {{"field", kVolumes, "The field."}}, DatasetType::Volume};
  }
  static std::vector<KeyRow<Trial>> properties() {
    return {textKey("gate", &Trial::gate, "It runs until this file is in the server's folder."),
            integerKey("fails on", &Trial::failsOn, {-1, 1e6}, "The rank that fails; -1: none.")};
  }
  FilterResult run(FilterRun& run) const {
    run.begin(0, 2, "trying");
    agree(run.ranks, [&] {
      if (run.ranks.rank() == failsOn) throw Error("this rank was told to fail");
    });
    for (bool isOpen = gate.empty(); !isOpen;) {
      agree(run.ranks, [&] { run.ranks.check(); });
      isOpen = sumOfCounts(run.ranks, std::filesystem::exists(gate) ? 1 : 0) == uint64_t(run.ranks.size());
      if (!isOpen) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const Dataset& from = *run.input("field").data;
    LedgerEntry memory;
    agree(run.ranks, [&] { memory = run.takeMemory("volume", from.bytes); });
    return {run.made(from.volume, from.partitioning, std::move(memory)), {}};
  }
};

}  // namespace

GALAXY_MODULE(registration) { registration.filter<Trial>(); }
