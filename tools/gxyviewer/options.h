// SPDX-License-Identifier: Apache-2.0
// What gxyviewer was asked on its command line.
#pragma once
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/first_look.h"
#include "multiserver/client/client.h"

namespace gxy {

struct ViewOptions {
  Client::Options client;
  std::vector<std::string> files;  ///< a state file; or data files, or names of datasets of the server
  LookOptions look;                ///< at the latter
  std::string array;
  std::string snapshot;            ///< a picture to write; empty: open a window
  std::string output;              ///< what the window saves: OUTPUT.json, OUTPUT_00000.png, ...
  std::optional<glm::ivec2> size;  ///< instead of the camera's dimensions
  bool annotated = true;           ///< a window begins with legend, axes and box
  uint32_t passes = 0;  ///< of a frame at rest; 0: as the state file says, and in a window 16 or more
};

/// The exit code to end with at once (0 after --help, 2 for wrong usage), or nothing.
std::optional<int> parseOptions(int argc, char** argv, ViewOptions& options);

}  // namespace gxy
