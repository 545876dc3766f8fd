// SPDX-License-Identifier: Apache-2.0
// A dataset: a volume, a mesh or a geometry with its partitioning, and where it comes from.
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
#include "core/data/mesh.h"
#include "core/data/owned_geometry.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"
#include "core/space/key.h"
#include "core/space/ledger.h"
#include "core/space/observers.h"

namespace gxy {

/// One step of one source of data. A simulation's stream is a source: `source` is its number, and `step` is the number that the
/// simulation gave. An imported dataset is its own source: `source` is the key of its object, and `step` is the generation.
struct Origin {
  uint64_t source = 0;
  int64_t step = 0;
  auto operator<=>(const Origin&) const = default;
};

/// The origins of one input of a computation. Error messages call it `name`.
struct InputOrigins {
  std::string name;
  std::span<const Origin> origins;
};

/// Returns the origins of what is made of these inputs: their union, sorted. Throws Error if two of them are of different
/// steps of one source, because nothing may mix two steps; the message names both inputs and steps.
std::vector<Origin> originsOf(std::span<const InputOrigins> inputs);

/// Says how a filter made a dataset. `filter` is empty if the dataset was imported.
struct Provenance {
  struct Input {
    std::string input;  ///< of the filter
    std::string name;   ///< when it was used
    Key key;
    Generation generation = 0;
  };
  std::string filter;      ///< its name: "StreamTracer"
  int version = 1;         ///< of the filter: another one may make other data of the same properties
  std::string properties;  ///< a JSON object
  std::vector<Input> inputs;
};

/// One generation of a dataset on one rank: the data of an object of the data space. It is immutable once it is in the space,
/// and any thread may read it.
struct Dataset {
  std::string file, array, radiusArray;  ///< where it was read; empty for what a filter has made
  std::vector<std::string> fields;       ///< the arrays of the file that were asked for besides
  std::string stream;  ///< of which simulation `array` is a field; empty for what was read or made
  glm::dvec4 color{0.8, 0.8, 0.8, 1};
  std::shared_ptr<const Partitioning> partitioning;
  std::shared_ptr<const Volume> volume;           ///< of a volume on a uniform grid
  std::shared_ptr<const Mesh> mesh;               ///< of an unstructured volume
  std::shared_ptr<const OwnedGeometry> geometry;  ///< else
  std::vector<Origin> origins;                    ///< sorted, at most one of each source
  /// Simulation time, in the simulation's unit; NaN: unknown. Streams set it; no import does so far.
  double time = std::numeric_limits<double>::quiet_NaN();
  Provenance provenance;
  int64_t bytes = 0;  ///< on this rank, those that other datasets share included
  LedgerEntry memory;
  std::shared_ptr<const LedgerEntry>
      sharedMemory;  ///< of what other datasets share: the cells of a simulation's mesh

  Box box() const;      ///< world
  Range range() const;  ///< of the values, or of the magnitude of several components
  int components() const;
};

/// Throws Error if a dataset is an unstructured volume, because `what`, such as "export", does not take these yet. `name`: of the
/// dataset.
void refuseMesh(const Dataset& dataset, const std::string& name, const std::string& what);

/// Returns the newest step of the sources of a dataset; 0 if it has none.
int64_t newestStep(const Dataset& dataset);

}  // namespace gxy
