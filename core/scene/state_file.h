// SPDX-License-Identifier: Apache-2.0
// The state file: a JSON description of data, renderer, visualizations and cameras. docs/state-file.md is its
// reference.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.h"

namespace gxy {

/// What a state file says, and what is to be told to the user: unknown keys, deprecated ones, values that
/// were mended, each "SOURCE:LINE:COLUMN: ..." (at most 100, then one line with the count of the others).
struct StateFile {
  State state;
  std::vector<std::string> warnings;
  bool hasRenderer = false;  ///< whether the text says anything of the renderer
};

/// Gives the content of a preset or camera file by its name in a text, at most kMaxJsonBytes (json_text.h). Throws
/// Error where the file cannot or may not be read.
using NamedFileReader = std::function<std::string(const std::string& name)>;

/// Reads a text. Files of the earlier Galaxy load. Every top-level key may be absent. Preset and camera files come
/// from `readFile`, which is asked once for each name; together they have at most kMaxJsonBytes, and presets give at
/// most kMaxJsonValues points of maps. Dataset file names stay as written. Throws Error
/// "SOURCE:LINE:COLUMN: `key`: expected ..., found ..." for whatever is wrong. No other exception, however
/// hostile the text; stateless, safe from any thread.
StateFile readState(std::string_view text, const std::string& sourceName, const NamedFileReader& readFile);

/// The same with file names that are relative to `directory`; any file of this machine may be named.
StateFile readState(std::string_view text, const std::string& sourceName,
                    const std::filesystem::path& directory = ".");

/// Reads a file, whose directory is the one above. Throws Error also where it cannot be read.
StateFile readStateFile(const std::filesystem::path& path);

/// The text that readState turns into an equal State, provided the State is one that can be said (maps
/// ascending, values within their ranges). Throws Error on NaN and infinity.
std::string writeState(const State& state);

/// The tables of docs/state-file.md, in Markdown, made from the schema.
std::string stateReference();

}  // namespace gxy
