// SPDX-License-Identifier: Apache-2.0
// What the names on a command line mean: a state file, or data, each a file or a series.
#pragma once
#include <string>
#include <vector>

#include "core/scene/collection_file.h"

namespace gxy {

/// Whether a file is a state file: one that ends with .json and holds at least one of a state file's keys. Throws Error for
/// what is there neither to be read nor a state file nor a volume's description.
bool isStateFile(const std::string& path);

/// The files that a name means, in order: itself, if there is such a file or the name holds no pattern; else, of a pattern
/// with * or ? in the name of the file, or a number as %d or %04d, those that match, numbers in the names by their value.
/// Throws Error for a pattern that nothing matches, and for a directory.
std::vector<std::string> filesOf(const std::string& name);

/// The steps of files that a name means (filesOf): a step each, but a collection (collection_file.h) says its steps itself.
/// Throws Error for a collection that is wrong; what it names need not be there.
std::vector<TimeStep> stepsOfFiles(const std::vector<std::string>& files);

/// How many steps names have together of which each has so many: those with several have equally many, the others are in each
/// step. Throws Error.
size_t commonSteps(const std::vector<std::string>& names, const std::vector<size_t>& steps);

/// The steps of several names together. A step's time is that of the first name that knows it. Throws Error also for a file
/// that is not there.
std::vector<TimeStep> stepsOf(const std::vector<std::string>& names);

}  // namespace gxy
