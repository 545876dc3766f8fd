// SPDX-License-Identifier: Apache-2.0
// What the parts of a run of gxyrender have in common.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/analysis/filter.h"
#include "core/comm/collective.h"
#include "core/comm/collectives.h"
#include "core/comm/mpi_transport.h"
#include "core/rays/backend.h"
#include "core/render/renderer.h"
#include "core/scene/collection_file.h"
#include "core/scene/scene.h"
#include "core/space/ledger.h"

namespace gxy {

inline constexpr uint64_t kRunKey = 1;  ///< of this run's collectives

/// What is rendered: the state of each step, alike but for the files.
struct Steps {
  State state;
  std::vector<TimeStep> series;  ///< whose files are those of the datasets; none: those of the state, once
  std::string directory;         ///< that names of files are relative to

  size_t count() const { return series.empty() ? 1 : series.size(); }
  std::optional<double> time(size_t step) const {
    return series.empty() ? std::optional<double>() : series[step].time;
  }
  /// Gives datasets the files of a step.
  void giveFiles(std::vector<DatasetSpec>& datasets, size_t step) const {
    for (size_t i = 0; step < series.size() && i < series[step].files.size(); i++)
      datasets[i].filename = series[step].files[i];
  }
  State at(size_t step) const {
    State out = state;
    giveFiles(out.datasets, step);
    return out;
  }
};

/// Where a run takes place; the same for all its steps.
struct Place {
  MpiTransport& transport;
  Collective& collective;
  Collectives& ranks;
  Ledger& ledger;
  Backend& backend;
  const FilterServices& services;
  bool root, showProgress;
};

/// Collective: returns on all ranks the text that `make` gives on the root. If it throws there, all throw Error with its message, told
/// without a rank.
std::string textOfRoot(Collective& collective, bool root, const std::function<std::string()>& make);

/// Frames that are rendered one after the other, several at once. Frame 0 is the one that the Renderer begins after `before` others.
struct Frames {
  FrameId before = 0;
  size_t count = 0;
  int concurrent = 1;
  std::function<FrameRequest(size_t frame)> request;  ///< called on the root
  /// Called on the rank that has the frame's picture, by any thread, for several frames at once. It may throw.
  std::function<void(size_t frame, const FrameRequest&, Picture)> take;
  std::function<void(size_t done)> show = [](size_t) {};  ///< called on the root, once a frame has ended
};
/// Collective. Renders them. Throws Error on all ranks if a frame fails or take() throws, once all have ended.
void renderFrames(const Frames& frames, Renderer& renderer, const Place& at);

}  // namespace gxy
