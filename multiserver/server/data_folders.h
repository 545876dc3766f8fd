// SPDX-License-Identifier: Apache-2.0
// Restricts the files that clients may read and write to some folders.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/io/file.h"

namespace gxy {

/// Resolves names from clients to paths in one of the folders, without symbolic links or `..`. Immutable; any
/// thread may use it.
class DataFolders {
 public:
  /// Without `folders`, the current folder is the only one. Throws Error for a folder that does not exist.
  explicit DataFolders(const std::vector<std::string>& folders);

  /// Returns the path of an existing regular file to read. A relative name is searched for in each folder, in
  /// their order. Throws Error if there is none, and for a file outside the folders, without revealing
  /// whether it exists.
  std::string toRead(const std::string& name) const;

  /// The same for a data file. Throws Error also unless all files that it refers to are inside
  /// (core/io/referenced_files.h).
  std::string dataToRead(const std::string& name) const;

  /// While the result lives, core/io reads no file outside the folders on this thread, even if a symbolic
  /// link has replaced a file that was found inside.
  [[nodiscard]] ReadScope reading() const;

  /// Returns the content of a file that toRead() finds. Throws Error if it has more than `limit` bytes.
  std::string textOf(const std::string& name, int64_t limit) const;

  struct Entry {
    std::string name;  ///< without folders
    bool isFolder = false;
    int64_t bytes = 0;  ///< of a file
  };
  /// Returns the folders and regular files in a folder, sorted by name; "" is each data folder itself. A relative name is
  /// looked for in all data folders, and what is in several of them is there once. Names that begin with a dot are left
  /// out, and what a link leads to outside. At most `most` are returned. Throws Error as toRead() does.
  std::vector<Entry> list(const std::string& name, size_t most) const;

  /// Returns the path of a file to write. A relative name is in the first folder. The file's folder must exist.
  std::string toWrite(const std::string& name) const;
  /// Makes a folder, unless it is there, and returns its path. A relative name is in the first folder. The folder that it lies in must
  /// exist. Throws Error if it cannot be made, or is there and a link or no folder.
  std::string makeFolder(const std::string& name) const;
  /// Writes a file at a path from toWrite(), completely or not at all. It checks the place again after
  /// opening it and follows no symbolic link, so that links that are put there meanwhile have no effect.
  /// Throws Error if it cannot write.
  void write(const std::string& path, std::span<const std::byte> bytes) const;

  const std::vector<std::filesystem::path>& folders() const { return folders_; }

  /// A file that is being written at a path from toWrite(), under another name until finish(). One thread uses it.
  class NewFile {
   public:
    /// Checks the place again. Throws Error if the folder is none of these any more. The folders must outlive it.
    NewFile(const DataFolders& folders, const std::string& path);
    /// Removes what is not finished.
    ~NewFile();
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    /// Where to write, in this process: in the folder that was checked, whatever has taken its place meanwhile. The name is random
    /// and has the extension of the file.
    std::string partial() const;
    /// Gives the file its name, in place of a file that has it. Throws Error if it cannot.
    void finish();

   private:
    friend class DataFolders;
    [[noreturn]] void fail(int reason) const;

    const std::string path_;
    std::string name_, partial_;
    int folder_ = -1;  ///< a descriptor
    bool finished_ = false;
  };

 private:
  bool holds(const std::filesystem::path& canonical) const;
  [[noreturn]] void refuse(const std::string& name, const std::string& reason) const;

  std::vector<std::filesystem::path> folders_;  ///< canonical paths
};

}  // namespace gxy
