// SPDX-License-Identifier: Apache-2.0
#include "multiserver/web/gui_files.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/comm/error.h"

namespace gxy {

namespace fs = std::filesystem;

namespace {

constexpr uintmax_t kMost = uintmax_t(64) << 20;  // bytes of all files

constexpr const char* kMissingPage = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Galaxy</title></head><body>
<h1>This Galaxy server has no browser GUI</h1>
<p>It was built or installed without it. Build Galaxy where npm and Node.js 18 or newer are installed, or name a folder
that has the GUI's files: <code>gxyserver --gui DIR</code>.</p>
<p>Programs work as ever: <code>msdata</code>, <code>gxyviewer</code>, and the client in Python.</p>
</body></html>
)";

std::string typeOf(const fs::path& file) {
  static const std::map<std::string, std::string> types{{".html", "text/html; charset=utf-8"},
                                                        {".js", "text/javascript; charset=utf-8"},
                                                        {".css", "text/css; charset=utf-8"},
                                                        {".json", "application/json"},
                                                        {".svg", "image/svg+xml"},
                                                        {".png", "image/png"},
                                                        {".ico", "image/x-icon"},
                                                        {".woff2", "font/woff2"},
                                                        {".txt", "text/plain; charset=utf-8"}};
  const auto found = types.find(file.extension().string());
  return found == types.end() ? "application/octet-stream" : found->second;
}

std::string contentsOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw Error("--gui: " + path.string() + " cannot be read");
  return content;
}

// FNV-1a with 64 bits, and the size. It only tells the versions of one file apart.
std::string tagOf(const std::string& content) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const char c : content) hash = (hash ^ uint8_t(c)) * 0x100000001b3;
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%016llx-%zx", static_cast<unsigned long long>(hash),
                content.size());
  return text.data();
}

}  // namespace

GuiFiles::GuiFiles(const std::string& folder) {
  if (folder.empty()) {
    files_["/"] = {kMissingPage, {}, typeOf("index.html"), tagOf(kMissingPage)};
    return;
  }
  try {
    read(folder);
  } catch (const fs::filesystem_error& e) {
    throw Error("--gui: " + std::string(e.what()));
  }
}

void GuiFiles::read(const std::string& folder) {
  if (!fs::is_regular_file(fs::path(folder) / "index.html"))
    throw Error("--gui: there is no index.html in " + folder + ", expected the files of the built GUI");
  uintmax_t bytes = 0;
  for (fs::recursive_directory_iterator at(folder), end; at != end; ++at) {
    const fs::path& path = at->path();
    if (path.filename().string().starts_with('.')) {
      at.disable_recursion_pending();
      continue;
    }
    if (at->is_symlink() || !at->is_regular_file()) continue;
    bytes += at->file_size();
    if (bytes > kMost) throw Error("--gui: the files in " + folder + " have more than 64 MiB");
    const std::string name = "/" + path.lexically_relative(folder).generic_string();
    const bool packed = path.extension() == ".gz";
    GuiFile& file = files_[packed ? name.substr(0, name.size() - 3) : name];
    (packed ? file.gzip : file.content) = contentsOf(path);
    if (packed) continue;
    file.type = typeOf(path);
    file.tag = tagOf(file.content);
    file.neverChanges = name.starts_with("/assets/");
  }
  std::erase_if(files_, [](const auto& entry) { return entry.second.tag.empty(); });  // FILE.gz without FILE
  files_["/"] = files_["/index.html"];
}

const GuiFile* GuiFiles::find(std::string_view path) const {
  const auto found = files_.find(path);
  return found == files_.end() ? nullptr : &found->second;
}

}  // namespace gxy
