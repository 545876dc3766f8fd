// SPDX-License-Identifier: Apache-2.0
// A dataset: a volume or a geometry with its partitioning, where it comes from, and which step of a simulation it shows.
#pragma once
#include <compare>
#include <cstdint>
#include <glm/vec4.hpp>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/data/box.h"
#include "core/data/owned_geometry.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"
#include "core/space/key.h"
#include "core/space/ledger.h"
#include "core/space/observers.h"

namespace gxy {

/// One step of one source of data. The source of what a stream publishes is the stream, by its id, and `step` the number that
/// the simulation gave the step. What is imported is its own source: `source` is the key of its object, `step` its generation.
struct Origin {
  uint64_t source = 0;
  int64_t step = 0;
  auto operator<=>(const Origin&) const = default;
};

/// The origins of one input of a computation, with the name that people know it by.
struct InputOrigins {
  std::string name;
  std::span<const Origin> origins;
};

/// The origins of what is made of these inputs: the union, sorted. Throws Error, naming both inputs and steps, if two of them
/// are of different steps of one source: nothing may mix two steps.
std::vector<Origin> originsOf(std::span<const InputOrigins> inputs);

/// How a dataset was made by a filter; `filter` is empty for what was imported.
struct Provenance {
  struct Input {
    std::string name;  ///< when it was used
    Key key;
    Generation generation = 0;
  };
  std::string filter;      ///< with its module: "example.threshold"
  int version = 1;         ///< of the filter: another one may make other data of the same properties
  std::string properties;  ///< a JSON object
  std::vector<Input> inputs;
};

/// What an object of the data space holds on a rank: one generation of a dataset. Immutable once it is in the space; safe to
/// read from any thread.
struct Dataset {
  std::string file, array, radiusArray;  ///< where it was read; empty for what a filter has made
  glm::dvec4 color{0.8, 0.8, 0.8, 1};
  std::shared_ptr<const Partitioning> partitioning;
  std::shared_ptr<const Volume> volume;           ///< of a volume
  std::shared_ptr<const OwnedGeometry> geometry;  ///< else
  std::vector<Origin> origins;                    ///< sorted, at most one of each source
  double time =
      std::numeric_limits<double>::quiet_NaN();  ///< of the simulation, in its unit; NaN: there is none
  Provenance provenance;
  int64_t bytes = 0;  ///< on this rank
  LedgerEntry memory;

  Box box() const;      ///< world
  Range range() const;  ///< of the values, or of the magnitude of several components
  int components() const;
};

}  // namespace gxy
