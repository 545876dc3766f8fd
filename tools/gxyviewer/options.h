// SPDX-License-Identifier: Apache-2.0
// The command line of gxyviewer.
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
  std::vector<std::string> files;  ///< a state file, or data files or names of datasets on the server
  LookOptions look;                ///< options of the first look at data
  std::string array;
  std::string snapshot;            ///< a picture to write; empty: open a window
  std::string output;              ///< prefix of saved files: OUTPUT.json, OUTPUT_00000.png, ...
  std::optional<glm::ivec2> size;  ///< replaces the camera's dimensions
  bool annotated = true;           ///< the window starts with legend, axes and box
  uint32_t passes = 0;  ///< passes of a frame at rest; 0: as in the state file, but at least 16 in a window
};

/// Returns the exit code if the program should end at once (0 after --help, 2 for wrong usage), or nothing.
std::optional<int> parseOptions(int argc, char** argv, ViewOptions& options);

}  // namespace gxy
