// SPDX-License-Identifier: Apache-2.0
// Facts of data files for a first look, read by one rank alone.
#pragma once
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/io/geometry_file.h"
#include "core/scene/first_look.h"

namespace gxy {

/// Reads what a first look at a file needs: of a volume all samples while they are at most 256 MiB, else some layers; of
/// geometry all of the file. `array` as in a state file. The dataset is named after the file. Throws Error for what is not a
/// data file. `toTake`, if any, is told what is read at a time before it is.
LookFacts factsOfFile(const std::string& path, const std::string& array = {}, const TakeMemory& toTake = {});

/// The same of several files, with different names.
std::vector<LookFacts> factsOfFiles(std::span<const std::string> paths, const std::string& array = {});

/// Whether a geometry file is looked at for its values; `array` as in a state file. What scanners leave beside the points of a
/// .ply, as their confidence, is shown where it is named.
bool valuesCount(const std::string& path, const std::string& array);

/// The piece of a geometry file that tells what all of them hold: the first with cells, else with points, else the first.
std::pair<std::string, GeometrySummary> tellingPiece(const std::string& path, const TakeMemory& toTake = {});

}  // namespace gxy
