// SPDX-License-Identifier: Apache-2.0
// Where the simulation's arrays of cells lie, and copies of them in the form in which they are sent.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "insitu/api/galaxy_insitu.h"
#include "insitu/plan/description.h"

namespace gxy::insitu {

/// The cells of one rank. Functions that read the simulation's arrays say so.
struct CellArrays {
  uint64_t count = 0;
  int allOf = 0;  ///< the type of VTK that all cells are of; 0: `types` says it
  gxy_array types{}, offsets{}, connectivity{};

  /// Throws Error, which begins with `what`, unless the arrays can be read. Reads the type of all cells, if there is one.
  void describe(const std::string& what);
  Mesh::Shape shape() const;  ///< as far as it is known without reading `types`

  /// Reads the offsets. 0 if they are wrong; the server then finds the wrong one in what copyEnds() has made of it.
  uint64_t corners() const;
  void copyTypes(std::byte* to) const;
  void copyEnds(std::byte* to) const;  ///< kNoPlace for a wrong offset
  void copyConnectivity(uint64_t corners, std::byte* to) const;

  /// Reads all arrays. Throws Error, which begins with `what`, unless the cells can be shown. Returns what they become.
  Mesh::Shape checked(const std::string& what, uint64_t points,
                      const std::function<glm::dvec3(size_t point)>& position) const;
  /// Copies all arrays to `memory`, and reads the copies from then on.
  void keep(std::vector<std::vector<std::byte>>& memory);
};

/// Copies integers of any type as those of 64 bits.
void copyIds(const gxy_array& ids, uint64_t count, std::byte* to);

}  // namespace gxy::insitu
