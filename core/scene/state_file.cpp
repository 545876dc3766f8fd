// SPDX-License-Identifier: Apache-2.0
#include "core/scene/state_file.h"

#include "core/scene/schema.h"

namespace gxy {

StateFile readState(std::string_view text, const std::string& sourceName, const NamedFileReader& readFile) {
  const JsonValue root = parseJson(text, sourceName);
  ReadContext context;
  context.sourceName = sourceName;
  context.readFile = readFile;
  StateFile out;
  out.hasRenderer = root.find("Renderer") != nullptr;
  readObject(context, root, stateSchema(), out.state);
  out.warnings = std::move(context.warnings);
  if (context.suppressedWarnings > 0) {
    out.warnings.push_back(sourceName + ": and " + std::to_string(context.suppressedWarnings) +
                           " more warnings");
  }
  return out;
}

StateFile readState(std::string_view text, const std::string& sourceName,
                    const std::filesystem::path& directory) {
  return readState(text, sourceName, [&](const std::string& name) { return readTextFile(directory / name); });
}

StateFile readStateFile(const std::filesystem::path& path) {
  const std::filesystem::path directory = path.has_parent_path() ? path.parent_path() : ".";
  return readState(readTextFile(path), path.string(), directory);
}

}  // namespace gxy
