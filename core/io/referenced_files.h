// SPDX-License-Identifier: Apache-2.0
// Finds the files that reading a data file opens.
#pragma once
#include <string>
#include <vector>

namespace gxy {

/// Returns the file itself and all files that it refers to, directly or indirectly (raw samples, pieces), as
/// paths to open. A server that may open only some folders uses it. It reads descriptions only. Throws Error
/// for a description that cannot be read, and for more than 2^20 files.
std::vector<std::string> filesOpenedFor(const std::string& path);

}  // namespace gxy
