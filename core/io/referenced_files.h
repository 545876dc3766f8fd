// SPDX-License-Identifier: Apache-2.0
// Which files reading a data file opens.
#pragma once
#include <string>
#include <vector>

namespace gxy {

/// The file itself and all that it refers to (raw samples, pieces), directly or not, as they will be opened. For a server
/// that may open some folders only: nothing but descriptions is read here. Throws Error for a description that cannot be
/// read, or more than 2^20 files.
std::vector<std::string> filesOpenedFor(const std::string& path);

}  // namespace gxy
