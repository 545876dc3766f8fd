// SPDX-License-Identifier: Apache-2.0
// The folders that clients may read and write files in, and nothing beyond.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/io/file.h"

namespace gxy {

/// Names from clients become paths without links or `..` that lie in one of the folders. Immutable.
class DataFolders {
 public:
  /// Throws Error for a folder that does not exist. None given: the current one.
  explicit DataFolders(const std::vector<std::string>& folders);

  /// An existing regular file to read; a relative name is looked for in each folder, in their order. Throws Error where
  /// there is none, and for what lies outside, without telling whether that exists.
  std::string toRead(const std::string& name) const;

  /// A data file to read, and that all files it refers to lie inside (core/io/referenced_files.h).
  std::string dataToRead(const std::string& name) const;

  /// While it lives, nothing that lies outside is read on this thread, though a link to it has taken the place of a file that
  /// was found here.
  [[nodiscard]] ReadScope reading() const;

  /// The content of such a file, of at most `limit` bytes.
  std::string textOf(const std::string& name, int64_t limit) const;

  /// A file to write; a relative name means the first folder. Its own folder must exist.
  std::string toWrite(const std::string& name) const;
  /// Writes such a file, whole or not at all. What toWrite() found is looked at once more when it is open, and no link is
  /// followed: whoever puts links in its place meanwhile gains nothing. Throws Error.
  void write(const std::string& path, std::span<const std::byte> bytes) const;

  const std::vector<std::filesystem::path>& folders() const { return folders_; }

 private:
  bool holds(const std::filesystem::path& canonical) const;
  [[noreturn]] void refuse(const std::string& name, const std::string& reason) const;

  std::vector<std::filesystem::path> folders_;  ///< canonical
};

}  // namespace gxy
