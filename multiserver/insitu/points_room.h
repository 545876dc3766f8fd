// SPDX-License-Identifier: Apache-2.0
// Room on one rank for particles of one step.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "multiserver/insitu/sent_arrays.h"

namespace gxy {

/// Takes memory when a rank of the simulation says how many particles it has. This rank owns what is sent to it, wherever it lies.
class PointsRoom final : public MeshRoom {
 public:
  /// The mesh must outlive it.
  PointsRoom(const insitu::Mesh& mesh, TakeStepMemory take);

  void store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
             std::span<const std::byte> samples) override {
    sent_.store(piece, array, header, samples);
  }
  /// Particles without numbers of their own are numbered by rank of the simulation. Throws Error also if a number is there twice
  /// or negative. Particles with a coordinate that is not finite are left out, and counted. Values of several components become
  /// their magnitude or a colour, as in files (LookOf).
  std::vector<std::shared_ptr<Dataset>> complete(Collectives& ranks) override;

 private:
  /// Where a particle stands, and its number.
  struct Place {
    uint64_t id = 0;
    int rank = 0;
    uint32_t index = 0;
  };
  glm::dvec3 position(const Place& place) const;
  std::vector<Place> places(const std::map<int, uint64_t>& firstIds) const;
  void checkDistinct(const std::vector<Place>& places, Collectives& ranks) const;
  void giveLook(size_t field, const std::vector<Place>& places, GeometryBlock& block) const;

  const insitu::Mesh& mesh_;
  SentArrays sent_;
};

}  // namespace gxy
