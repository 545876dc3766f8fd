// SPDX-License-Identifier: Apache-2.0
// Reads and writes the earlier Galaxy's list of the pieces of a geometry (.part, JSON):
//
//   {"parts": [{"extent": [xmin, xmax, ymin, ymax, zmin, zmax], "filename": "piece_0.vtu"}, ...]}
//
// The extents are the boxes that the pieces were cut with. They are checked but not used, because primitives
// are sent to the partitions that they touch, whatever piece they come from. There may be any number of pieces.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/data/box.h"

namespace gxy {

struct GeometryPart {
  Box extent;        ///< empty if the document states none
  std::string file;  ///< as written: absolute, or relative to the document
};

/// Parses the text and opens no file. Throws Error with `where` and the part. Pieces that come from a socket
/// (host, port) are an error.
std::vector<GeometryPart> parsePart(std::string_view text, const std::string& where);
std::string formatPart(const std::vector<GeometryPart>& parts);

}  // namespace gxy
