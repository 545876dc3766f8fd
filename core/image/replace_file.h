// SPDX-License-Identifier: Apache-2.0
// Writes files that are complete or absent at any time.
#pragma once
#include <cstddef>
#include <span>
#include <string>

namespace gxy {

/// Writes the bytes to PATH.partial and renames that file to `path` when it is complete. If the process ends
/// meanwhile, `path` is the old file or the complete new one. Devices and pipes are written directly; a
/// symbolic link stays a link. Throws Error with `path` and the system's reason (disk full, no such folder,
/// ...), and then leaves no partial file.
void replaceFile(const std::string& path, std::span<const std::byte> bytes);

}  // namespace gxy
