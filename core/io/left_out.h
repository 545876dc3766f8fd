// SPDX-License-Identifier: Apache-2.0
// Counts data of files that are not read or not kept.
#pragma once
#include <cstdint>

namespace gxy {

/// The data of files that a rank has not read, or has not kept.
struct LeftOut {
  uint64_t arrays = 0;      ///< arrays of points or cells
  uint64_t components = 0;  ///< components of arrays of volumes that are shown
  uint64_t pieces = 0;      ///< pieces of volumes without data that this rank needs
  uint64_t bytes = 0;       ///< size of all these, in the files' types

  LeftOut& operator+=(const LeftOut& o) {
    arrays += o.arrays;
    components += o.components;
    pieces += o.pieces;
    bytes += o.bytes;
    return *this;
  }
};

}  // namespace gxy
