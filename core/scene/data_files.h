// SPDX-License-Identifier: Apache-2.0
// Interprets file names of a command line: a state file, or data, where a name means a file or a series of files.
#pragma once
#include <string>
#include <vector>

#include "core/scene/collection_file.h"

namespace gxy {

/// Whether a file is a state file: its name ends with .json, and it has at least one of a state file's keys
/// or is not a JSON object (the reader of state files then says what is wrong). Throws Error if the file does
/// not exist, or if it is a JSON object that is neither a state file nor the description of a volume.
bool isStateFile(const std::string& path);

/// Returns the files that a name means. The name of an existing file, or a name without a pattern, means that
/// file. In the last part of the path, * and ? are patterns, and %d or %04d stands for a number: such a name
/// means all files that match, in order, with numbers compared by value. Throws Error if nothing matches, or
/// for a directory.
std::vector<std::string> filesOf(const std::string& name);

/// Returns the time steps of the files that one name means (filesOf). Each file is a step, but a collection
/// (collection_file.h) lists its own steps. Throws Error for a malformed collection; the files that it
/// lists need not exist.
std::vector<TimeStep> stepsOfFiles(const std::vector<std::string>& files);

/// Returns the number of time steps of several names together, where names[i] has steps[i] steps. Names
/// with several steps must have equally many; a name with one step belongs to every step. Throws Error if
/// the numbers differ.
size_t commonSteps(const std::vector<std::string>& names, const std::vector<size_t>& steps);

/// Returns the time steps of several names together. A step's time comes from the first name that has one for
/// it. Throws Error as the functions above do, and for a file that does not exist.
std::vector<TimeStep> stepsOf(const std::vector<std::string>& names);

}  // namespace gxy
