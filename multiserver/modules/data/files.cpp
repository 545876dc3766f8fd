// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/data/files.h"

#include <algorithm>

#include "core/io/file.h"
#include "core/io/volume_file.h"
#include "core/scene/collection_file.h"
#include "multiserver/protocol/json.h"

namespace gxy {

using nlohmann::json;

namespace {

constexpr size_t kMost = 10000;  // entries of a folder

// Whether readers of data, of collections or of state files take files of this name.
bool canBeOpened(const std::string& name) {
  const std::string extension = extensionOf(name);
  if (extension.empty()) return false;
  if (isCollection(name) || (name.size() > 7 && name.ends_with(".nii.gz"))) return true;
  const std::string known = " " + readableFormats() + ",";
  for (const char* end : {" ", ","})
    if (known.find(" " + extension + end) != known.npos) return true;
  return false;
}

}  // namespace

json files(Request& request, protocol::Arguments arguments) {
  const std::string folder = arguments.word().value_or("");
  arguments.expectEnd();
  json folders = json::array(), found = json::array();
  std::string text;
  const auto entries = request.session().serverRank().folders.list(folder, kMost + 1);
  const bool more = entries.size() > kMost;
  for (size_t i = 0; i < std::min(entries.size(), kMost); i++) {
    const DataFolders::Entry& entry = entries[i];
    if (!protocol::isUtf8(entry.name)) continue;  // no JSON can name it
    if (entry.isFolder)
      folders.push_back(entry.name);
    else if (canBeOpened(entry.name))
      found.push_back({{"name", entry.name}, {"bytes", entry.bytes}});
    else
      continue;
    text += (text.empty() ? "" : "\n") + protocol::printable(entry.name) + (entry.isFolder ? "/" : "");
  }
  return {{"folder", folder}, {"folders", folders}, {"files", found}, {"more", more}, {"text", text}};
}

}  // namespace gxy
