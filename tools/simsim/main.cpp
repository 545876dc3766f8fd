// SPDX-License-Identifier: Apache-2.0
// simsim: publishes steps between two volumes to a Galaxy server, as a running simulation does.
#include <algorithm>
#include <cstdlib>
#include <future>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "tools/simsim/inputs.h"
#include "tools/simsim/interrupts.h"
#include "tools/simsim/options.h"
#include "tools/simsim/rank.h"
#include "tools/simsim/report.h"
#include "tools/simsim/saved_steps.h"

namespace gxy::simsim {
namespace {

constexpr double kLastStepSeconds = 5;  // for the last step to reach the server

/// The ranks of the simulation that are in this process.
class Ranks {
 public:
  /// Opens the stream on all ranks, and then reads their blocks. Meanwhile the library connects.
  Ranks(const SimulationOptions& options, const Place& place, const Inputs& inputs,
        const Interrupts& interrupts) {
    const bool threads = place.ranks == 1;
    const int count = threads ? options.threads : 1, all = threads ? options.threads : place.ranks;
    ranks_.reserve(size_t(count));
    for (int i = 0; i < count; ++i)
      ranks_.emplace_back(inputs, options.name, threads ? i : place.rank, all, options.ofStream());
    readBlocks(inputs, ranks_, [&interrupts] { interrupts.check(); });
  }

  /// Computes a step on all ranks, and saves it.
  void compute(double weight, const VolumeWriter* writer) {
    onAll([weight, writer](size_t, Rank& rank) {
      rank.compute(weight);
      if (writer) rank.write(*writer);
    });
  }

  /// Offers a step on all ranks.
  Outcome publish(int64_t step) {
    results_.resize(ranks_.size());
    onAll([this, step](size_t i, Rank& rank) { results_[i] = rank.publish(step); });
    return outcomeOf(results_);
  }

  /// Returns the text of a rank that had no connection in the last step; if all had one, that of any rank.
  std::string message() const {
    const auto lost = std::ranges::find(results_, int(GXY_LOST));
    return ranks_[lost == results_.end() ? 0 : size_t(lost - results_.begin())].message();
  }

  void close() {
    onAll([](size_t, Rank& rank) { rank.close(kLastStepSeconds); });
  }

 private:
  /// Calls work(i, rank) for all ranks at once, each on a thread of its own, and waits for all.
  template <class Work>
  void onAll(const Work& work) {
    std::vector<std::future<void>> calls;
    for (size_t i = 0; i < ranks_.size(); ++i)
      calls.push_back(std::async(std::launch::async, [this, &work, i] { work(i, ranks_[i]); }));
    for (std::future<void>& call : calls) call.get();
  }

  std::vector<Rank> ranks_;
  std::vector<int> results_;  ///< of the last step, by rank
};

/// Numbers of steps, for the summary.
struct Count {
  int64_t offered = 0, taken = 0, lost = 0;
};

/// Computes, saves and publishes all steps. Throws Interrupted when a signal comes.
Count publishSteps(const SimulationOptions& options, const SavedSteps* saved, Ranks& ranks,
                   const Interrupts& interrupts, std::ostream& out) {
  Count count;
  for (int64_t step = 1; options.steps == 0 || step <= options.steps; ++step) {
    interrupts.wait(step > 1 ? options.pause : 0);
    std::optional<VolumeWriter> writer;
    if (saved) writer.emplace(saved->create(step));
    ranks.compute(options.wave.weight(step), writer ? &*writer : nullptr);
    const Outcome outcome = ranks.publish(step);
    ++count.offered;
    count.taken += outcome == Outcome::Taken;
    count.lost += outcome == Outcome::NoConnection;
    out << lineAbout(step, outcome, ranks.message()) << std::endl;
  }
  return count;
}

int run(const SimulationOptions& options, const Place& place) {
  const Interrupts interrupts;  // before any thread
  std::ostream nowhere(nullptr);
  const bool speaks = place.rank == 0;
  std::ostream& out = speaks && !options.quiet ? std::cerr : nowhere;
  const Inputs inputs = openInputs(options.first, options.second, options.arrays);
  for (const VolumeFile& file : {inputs.arrays.front().first, inputs.arrays.front().second})
    for (const std::string& warning : file.warnings)
      if (speaks) std::cerr << "simsim: warning: " << file.path << ": " << warning << '\n';
  std::optional<SavedSteps> saved;
  if (!options.savedFolder.empty())
    saved.emplace(options.savedFolder, options.name, inputs, options.first, options.second);
  Ranks ranks(options, place, inputs, interrupts);
  const Count count = publishSteps(options, saved ? &*saved : nullptr, ranks, interrupts, out);
  const std::string message = ranks.message();
  ranks.close();
  if (count.lost == count.offered)
    throw Error("no step has reached a server" + (message.empty() ? std::string() : ": " + message));
  out << "simsim: " << count.taken << " of " << count.offered << " step(s) were taken\n";
  return 0;
}

}  // namespace
}  // namespace gxy::simsim

int main(int argc, char** argv) {
  using namespace gxy::simsim;
  Place place;
  std::string who = "simsim";
  try {
    place = placeFrom([](const char* name) -> const char* { return std::getenv(name); });
    if (place.ranks > 1) who += ": rank " + std::to_string(place.rank);
    SimulationOptions options;
    if (const auto code = parseOptions(argc, argv, place, options)) return *code;
    return run(options, place);
  } catch (const Interrupted& interrupted) {
    if (place.rank == 0) std::cerr << "simsim: interrupted\n";
    return 128 + interrupted.signal;
  } catch (const std::exception& e) {
    std::cerr << who << ": error: " << gxy::textOf(e) << '\n';
    return 1;
  }
}
