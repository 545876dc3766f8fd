// SPDX-License-Identifier: Apache-2.0
// Reads and writes the earlier Galaxy's two descriptions of a raw volume: .vol (text) and volume JSON.
//
//   .vol   type / origin x y z / counts nx ny nz / spacing dx dy dz / name of the raw file, each on a line of its own
//   .json  {"type", "origin": [3], "counts": [3], "delta": [3], "rawdata", "number of components": 1,
//           "byte order": "little" or "big"}; the last two may be absent
//
// Types are float, uchar, int8, uint8, int16, uint16, int32, uint32, int64, uint64 and double. The raw file
// contains the samples of points, x fastest, components interleaved, and nothing else. Its byte order is this
// machine's unless stated.
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
  std::vector<std::string> warnings{};  ///< about unknown keys, each with `where`; at most eleven lines
};

/// Returns the type for a word listed above.
std::optional<ScalarType> scalarTypeOfWord(std::string_view word);

/// These parse the text and open no file. They throw Error with `where` (the file) and the line or key.
VolumeDescription parseVol(std::string_view text, const std::string& where);
VolumeDescription parseVolumeJson(std::string_view text, const std::string& where);

/// Returns the text of a description. A .vol has one component only; throws Error for more.
std::string formatVol(const VolumeDescription& volume);
std::string formatVolumeJson(const VolumeDescription& volume);

/// Throws Error unless origin is finite, spacing is positive and finite, there are at least 2 points on each
/// axis and at least 1 component, and the size of all samples in bytes is below 2^63.
void checkGrid(const Grid& grid, ScalarType type, int components, const std::string& where);

}  // namespace gxy
