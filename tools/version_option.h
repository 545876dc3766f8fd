// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "core/comm/version.h"

namespace gxy {

/// Gives a program the option --version, which prints "PROGRAM 0.1.0".
inline void addVersion(CLI::App& app, const std::string& program) {
  app.set_version_flag("--version", program + " " + kVersion, "Print the version, and end");
}

}  // namespace gxy
