// SPDX-License-Identifier: Apache-2.0
// Heads of lines in meshes.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>

#include "core/rays/heads.h"

namespace gxy {

/// A head that leaves its cell, but not through one of its faces: where the cell's map has no inverse.
inline constexpr int kNoFaceOfCell = 6;

/// One head of a list of kMeshHeads, whose fields head_fields.h describes.
struct MeshHead {
  uint64_t key = 0;       ///< keyOf() its cell
  int32_t cell = -1;      ///< in its block; -1: not known yet
  bool unplaced = false;  ///< a seed whose `place` is one in the world
  int leaving = -1;       ///< the face through which it leaves its cell, or kNoFaceOfCell; -1: it does not
  glm::dvec3 place{0};    ///< reference coordinates
  glm::vec3 near{0};      ///< of a head that goes on in another block: a place in the world near it
  double time = 0, length = 0;  ///< since the seed, world units, without sign
  float step = 1;               ///< cells of way that the next step may have
  int32_t steps = 0, points = 0, stalled = 0;
  float way = 0;
  bool fresh = false;

  static MeshHead of(const HeadList& heads, int i);
  /// Writes all but the line and the direction.
  void writeTo(const HeadList& heads, int i) const;
};

/// Checks heads of meshes that came in a message. Returns what is wrong with the first bad one (a static text), or null.
const char* wrongInMesh(const HeadList& heads);

}  // namespace gxy
