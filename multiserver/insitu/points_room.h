// SPDX-License-Identifier: Apache-2.0
// Room on one rank for particles of one step.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/data/owned_geometry.h"
#include "core/space/large_vector.h"
#include "multiserver/insitu/mesh_room.h"

namespace gxy {

/// Takes memory when a rank of the simulation says how many particles it has. This rank owns what is sent to it, wherever it lies.
class PointsRoom final : public MeshRoom {
 public:
  /// The mesh must outlive it.
  PointsRoom(const insitu::Mesh& mesh, TakeStepMemory take);

  void store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
             std::span<const std::byte> samples) override;
  /// Particles without numbers of their own are numbered by rank of the simulation. Throws Error also if a number is there twice
  /// or negative. Particles with a coordinate that is not finite are left out, and counted. Values of several components become
  /// their magnitude, as in files.
  std::vector<std::shared_ptr<Dataset>> complete(Collectives& ranks) override;

 private:
  using Values = LargeVector<std::byte>;
  /// What one rank of the simulation has sent.
  struct Source {
    uint64_t count = 0;
    std::vector<Values> arrays;
    LedgerEntry memory;
  };
  /// Where a particle stands, and its number.
  struct Place {
    uint64_t id = 0;
    int rank = 0;
    uint32_t index = 0;
  };
  uint64_t bytesPerPoint() const;
  glm::dvec3 position(const Place& place) const;
  std::vector<Place> places(const std::map<int, uint64_t>& firstIds) const;
  std::map<int, uint64_t> firstIds(Collectives& ranks) const;
  void checkDistinct(const std::vector<Place>& places, Collectives& ranks) const;
  std::vector<float> values(size_t field, const std::vector<Place>& places) const;

  const insitu::Mesh& mesh_;
  const std::vector<insitu::Field> arrays_;
  const TakeStepMemory take_;
  std::vector<Source> sources_;  ///< by rank of the simulation, up to the last one that has sent something
};

}  // namespace gxy
