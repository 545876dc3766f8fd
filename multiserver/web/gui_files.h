// SPDX-License-Identifier: Apache-2.0
// The files of the browser GUI, which the server keeps in memory.
#pragma once
#include <map>
#include <string>
#include <string_view>

namespace gxy {

struct GuiFile {
  std::string content;
  std::string gzip;           ///< the same, compressed; empty: there is no such file
  std::string type;           ///< the value of Content-Type
  std::string tag;            ///< differs between contents
  bool neverChanges = false;  ///< another content has another name, as the names below /assets/ have a hash
};

/// A fixed table from paths in URLs to files. No path of a client ever gets to the file system. Thread safe once
/// it is made.
class GuiFiles {
 public:
  /// Reads all files below the folder: index.html as `/`, others under their paths. FILE.gz is not a file of
  /// its own, but the compressed form of FILE. Links, and what begins with a dot, are left out. An empty
  /// folder name stands for a page that says how to get the GUI. Throws Error if there is no index.html, a file
  /// cannot be read, or all of them are larger than 64 MiB.
  explicit GuiFiles(const std::string& folder);

  /// Returns the file at a path, as `/assets/x.js`; null if there is none.
  const GuiFile* find(std::string_view path) const;

 private:
  void read(const std::string& folder);
  std::map<std::string, GuiFile, std::less<>> files_;
};

}  // namespace gxy
