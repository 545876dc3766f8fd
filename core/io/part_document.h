// SPDX-License-Identifier: Apache-2.0
// The earlier Galaxy's list of the pieces of a geometry (.part, JSON):
//
//   {"parts": [{"extent": [xmin, xmax, ymin, ymax, zmin, zmax], "filename": "piece_0.vtu"}, ...]}
//
// The extents are the boxes that the pieces were cut with; they are checked, but not needed: primitives are
// brought to the partitions they touch, whatever piece they come from. There may be any number of pieces.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/data/box.h"

namespace gxy {

struct GeometryInPartition {
  Box extent;        ///< empty where the document states none
  std::string file;  ///< as written: absolute, or relative to the document
};

/// Parses text only. Throws Error naming `where` and the part; pieces that come from a socket (host, port)
/// are an error.
std::vector<GeometryInPartition> parsePart(std::string_view text, const std::string& where);
std::string formatPart(const std::vector<GeometryInPartition>& parts);

}  // namespace gxy
