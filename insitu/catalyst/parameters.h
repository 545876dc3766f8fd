// SPDX-License-Identifier: Apache-2.0
// What a simulation, or its user, says to Galaxy beside the data (docs/insitu.md lists it).
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "insitu/catalyst/blueprint.h"

namespace gxy::catalyst {

/// A whole grid. The library does not communicate, so several ranks have to say it.
struct WholeGrid {
  std::optional<Index> size;  ///< in points
  std::optional<Position> origin, spacing;
};

struct Parameters {
  std::string name = "catalyst", options = "{}";
  int rank = 0, ranks = 1;
  std::map<std::string, WholeGrid> wholes;  ///< by mesh; "": of those that are not named
  bool shared = true;                       ///< neighbouring blocks have a layer of points in common
  std::string ghosts, association, ids;
  std::optional<std::vector<double>> box;  ///< the domain of particles
  double seconds = 5;                      ///< that catalyst_finalize waits
};

/// Those at catalyst/galaxy of the node of catalyst_initialize, and over them those in the JSON file that the environment variable
/// GALAXY_CATALYST names. Throws std::runtime_error.
Parameters readParameters(const Node& params);

}  // namespace gxy::catalyst
