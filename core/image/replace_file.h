// SPDX-License-Identifier: Apache-2.0
// Files that appear whole or not at all.
#pragma once
#include <cstddef>
#include <span>
#include <string>

namespace gxy {

/// Writes a file beside `path`, as PATH.partial, and gives it its name when all is written: if the process ends
/// meanwhile, under `path` there is the old file or the whole new one. Devices and pipes are written to as they are.
/// Throws Error naming `path` and the system's reason (disk full, no such folder, ...), and then leaves no partial file.
void replaceFile(const std::string& path, std::span<const std::byte> bytes);

}  // namespace gxy
