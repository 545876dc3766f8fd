// SPDX-License-Identifier: Apache-2.0
// Reads the facts of data files that a first look needs. One rank reads them alone.
#pragma once
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/io/geometry_file.h"
#include "core/scene/first_look.h"

namespace gxy {

/// Reads the facts of a file. Of a volume it reads all samples if they have at most 256 MiB, and otherwise
/// some layers; of geometry and unstructured volumes it reads the whole file. `array` is as in a state file. The dataset is named
/// after the file. `inside`: cells with a volume are an unstructured volume; else they are triangles, their outer surface. `toTake`, if not empty, is called with the number of bytes before memory for them is
/// taken. Throws Error if this is not a data file.
LookFacts factsOfFile(const std::string& path, const std::string& array = {}, bool inside = false,
                      const TakeMemory& toTake = {});

/// The same for several files; each dataset gets a different name.
std::vector<LookFacts> factsOfFiles(std::span<const std::string> paths, const std::string& array = {},
                                    bool inside = false);

/// Whether a first look colours a geometry file by its values. `array` is as in a state file. The values of a
/// .ply file, such as the confidence that scanners write, are shown only if `array` names them.
bool valuesCount(const std::string& path, const std::string& array);

/// Returns the path and summary of the piece that represents all pieces of a geometry file: the first with
/// cells, else the first with points, else the first. Throws Error if there are no pieces.
std::pair<std::string, GeometrySummary> tellingPiece(const std::string& path, const TakeMemory& toTake = {});

}  // namespace gxy
