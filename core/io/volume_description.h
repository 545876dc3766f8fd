// SPDX-License-Identifier: Apache-2.0
// The earlier Galaxy's two descriptions of a raw volume: .vol (text) and volume JSON.
//
//   .vol   type / origin x y z / counts nx ny nz / spacing dx dy dz / name of the raw file, each on a line of
//   its own .json  {"type", "origin": [3], "counts": [3], "delta": [3], "rawdata", "number of components": 1,
//           "byte order": "little" or "big"}; the last two may be absent
//
// Types: float, uchar, int8, uint8, int16, uint16, int32, uint32, int64, uint64, double. The raw file holds
// point samples, x fastest, components interleaved, in the byte order of this machine unless stated, and
// nothing else.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/data/volume.h"

namespace gxy {

struct VolumeDescription {
  ScalarType type = ScalarType::Float32;
  Grid grid;
  int components = 1;
  std::string rawFile;                  ///< as written: absolute, or relative to the description
  bool swapBytes = false;               ///< the file's byte order is not this machine's
  std::vector<std::string> warnings{};  ///< keys that mean nothing, each with `where`; at most eleven lines
};

/// By the words above.
std::optional<ScalarType> scalarTypeOfWord(std::string_view word);

/// Both parse text only, open nothing, and throw Error naming `where` (the file) and the line or key.
VolumeDescription parseVol(std::string_view text, const std::string& where);
VolumeDescription parseVolumeJson(std::string_view text, const std::string& where);

/// The text of a description. A .vol can hold one component only: Error for more.
std::string formatVol(const VolumeDescription& volume);
std::string formatVolumeJson(const VolumeDescription& volume);

/// Throws Error unless origin is finite, spacing positive and finite, points >= 2 on each axis, components >=
/// 1, and the size of all samples in bytes fits into 63 bits.
void checkGrid(const Grid& grid, ScalarType type, int components, const std::string& where);

}  // namespace gxy
