// SPDX-License-Identifier: Apache-2.0
// What gxyviewer was asked on its command line.
#pragma once
#include <glm/vec2.hpp>
#include <optional>
#include <string>

#include "gxy/client/client.h"

namespace gxy {

struct ViewOptions {
  Client::Options client;
  std::string stateFile;
  std::string snapshot;            ///< a picture to write; empty: open a window
  std::string output;              ///< what the window saves: OUTPUT.json, OUTPUT_00000.png, ...
  std::optional<glm::ivec2> size;  ///< instead of the camera's dimensions
  uint32_t passes = 0;  ///< of a frame at rest; 0: as the state file says, and in a window 16 or more
};

/// The exit code to end with at once (0 after --help, 2 for wrong usage), or nothing.
std::optional<int> parseOptions(int argc, char** argv, ViewOptions& options);

}  // namespace gxy
