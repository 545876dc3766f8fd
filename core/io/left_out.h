// SPDX-License-Identifier: Apache-2.0
// What is skipped of files.
#pragma once
#include <cstdint>

namespace gxy {

/// What of files a rank has not read, or has not kept.
struct LeftOut {
  uint64_t arrays = 0;      ///< of points or cells
  uint64_t components = 0;  ///< of the arrays of volumes that are shown
  uint64_t pieces = 0;      ///< of volumes' files in several, with nothing that this rank needs
  uint64_t bytes = 0;       ///< of these, as the files' types have them

  LeftOut& operator+=(const LeftOut& o) {
    arrays += o.arrays;
    components += o.components;
    pieces += o.pieces;
    bytes += o.bytes;
    return *this;
  }
};

}  // namespace gxy
