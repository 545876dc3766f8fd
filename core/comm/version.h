// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace gxy {

/// Galaxy's version, "0.1.0", as CMakeLists.txt states it.
extern const char* const kVersion;

}  // namespace gxy
