// SPDX-License-Identifier: Apache-2.0
// Reads and writes the state file, a JSON description of data, renderer, visualizations and cameras.
// docs/state-file.md is its reference.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.h"

namespace gxy {

/// The content of a state file.
struct StateFile {
  State state;
  /// Warnings for the user about unknown keys, deprecated keys and corrected values, each
  /// "SOURCE:LINE:COLUMN: ...": at most 100, then one line with the number of the others.
  std::vector<std::string> warnings;
  bool hasRenderer = false;  ///< whether the text has the key `Renderer`
};

class FilterSchemas;

/// Returns the content of the preset or camera file that a state file calls `name`, at most kMaxJsonBytes
/// (json_text.h). Throws Error if the file cannot be read or access to it is not allowed.
using NamedFileReader = std::function<std::string(const std::string& name)>;

/// Reads the text of a state file. Files of the earlier Galaxy load. Every top-level key may be absent.
/// `readFile` gives the content of preset and camera files and is called once for each name. Together these
/// files have at most kMaxJsonBytes, and presets give at most kMaxJsonValues points of maps. Dataset file
/// names stay as written. Throws Error "SOURCE:LINE:COLUMN: `key`: expected ..., found ..." for any mistake,
/// and no other exception, however malformed the text. Has no state: any thread may call it. Entries of datasets that filters
/// make are checked against `filters`; if that is null, they are kept as they are.
StateFile readState(std::string_view text, const std::string& sourceName, const NamedFileReader& readFile,
                    const FilterSchemas* filters = nullptr);

/// The same; preset and camera file names are relative to `directory` and may name any file of this machine.
StateFile readState(std::string_view text, const std::string& sourceName,
                    const std::filesystem::path& directory = ".", const FilterSchemas* filters = nullptr);

/// The same for a file; names are relative to its directory. Throws Error also if it cannot be read.
StateFile readStateFile(const std::filesystem::path& path, const FilterSchemas* filters = nullptr);

/// Reads datasets alone: an object with `Datasets` only, or one entry of these, or a list of entries. Throws as readState() does.
StateFile readDatasetEntries(std::string_view text, const std::string& sourceName,
                             const FilterSchemas* filters = nullptr);

/// Returns a text that readState() turns into an equal State, if the State is valid (points of maps ascend,
/// values lie within their ranges). Throws Error for NaN and infinity.
std::string writeState(const State& state);

/// Returns the tables of docs/state-file.md, in Markdown, made from the schema.
std::string stateReference();

/// Returns the same tables for programs: the text of a JSON list with an object for each (schemaJson()).
std::string stateTables();

}  // namespace gxy
