// SPDX-License-Identifier: Apache-2.0
// Reads ParaView's collections (.pvd), which list files by time.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gxy {

/// The files of one time step, in the collection's order, and its time if that is known.
struct TimeStep {
  std::optional<double> time;
  std::vector<std::string> files;
};

/// Whether the name ends with .pvd, in any letter case.
bool isCollection(std::string_view path);

/// Returns the time steps that the DataSet elements of a collection list, by ascending time. An element
/// without `timestep` is at time 0. Relative file names are relative to the collection's directory. Throws
/// Error if the file is no collection or lists no file, or if the time steps do not have equally many files.
std::vector<TimeStep> readCollection(const std::string& path);

}  // namespace gxy
