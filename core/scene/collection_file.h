// SPDX-License-Identifier: Apache-2.0
// ParaView's collections (.pvd): which files are there at which time.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gxy {

/// The files of one time step, in the collection's order, and its time, where that is known.
struct TimeStep {
  std::optional<double> time;
  std::vector<std::string> files;
};

/// Whether a name ends as a collection's does.
bool isCollection(std::string_view path);

/// The steps that the DataSet elements of a collection name, by ascending time; without a `timestep` they are at 0. Files that are
/// named relatively lie relative to the collection. Throws Error for what is no collection or has no file, and where not all
/// times have equally many.
std::vector<TimeStep> readCollection(const std::string& path);

}  // namespace gxy
