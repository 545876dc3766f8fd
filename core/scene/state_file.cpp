// SPDX-License-Identifier: Apache-2.0
#include "core/scene/state_file.h"

#include "core/comm/error.h"
#include "core/scene/json_text.h"
#include "core/scene/schema.h"

namespace gxy {

namespace {

StateFile readRoot(const JsonValue& root, const std::string& sourceName, const NamedFileReader& readFile,
                   const FilterSchemas* filters) {
  ReadContext context;
  context.sourceName = sourceName;
  context.readFile = readFile;
  context.filters = filters;
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

}  // namespace

StateFile readState(std::string_view text, const std::string& sourceName, const NamedFileReader& readFile,
                    const FilterSchemas* filters) {
  return readRoot(parseJson(text, sourceName), sourceName, readFile, filters);
}

StateFile readState(std::string_view text, const std::string& sourceName,
                    const std::filesystem::path& directory, const FilterSchemas* filters) {
  return readState(
      text, sourceName, [&](const std::string& name) { return readTextFile(directory / name); }, filters);
}

StateFile readStateFile(const std::filesystem::path& path, const FilterSchemas* filters) {
  const std::filesystem::path directory = path.has_parent_path() ? path.parent_path() : ".";
  return readState(readTextFile(path), path.string(), directory, filters);
}

StateFile readDatasetEntries(std::string_view text, const std::string& sourceName,
                             const FilterSchemas* filters) {
  JsonValue root = parseJson(text, sourceName);
  if (!root.find("Datasets")) {
    const TextPosition at = root.at;
    JsonMember member{"Datasets", at, std::move(root)};
    root = {at, JsonValue::Object()};
    std::get<JsonValue::Object>(root.value).push_back(std::move(member));
  }
  for (const JsonMember& member : *root.object())
    if (member.key != "Datasets")
      throw Error(locationPrefix(sourceName, member.at) + inQuotes(member.key, '`') +
                  ": expected datasets only");
  const NamedFileReader noFiles = [](const std::string&) -> std::string {
    throw Error("there are no files");
  };
  return readRoot(root, sourceName, noFiles, filters);
}

}  // namespace gxy
