// SPDX-License-Identifier: Apache-2.0
// Reads and writes files at 64-bit positions, and whole small text files. Limits which files may be read.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace gxy {

/// An open file. Any thread may read and write. Errors name the file and the system's reason.
class File {
 public:
  static File open(const std::string& path);    ///< opens an existing regular file for reading
  static File create(const std::string& path);  ///< opens a file for writing; an existing file is emptied
  File(File&& other) noexcept;
  File& operator=(File&&) = delete;
  ~File();

  const std::string& path() const { return path_; }
  /// A path that leads to the open file as long as it is open, even if another file has its path by now.
  std::string opened() const;
  int64_t size() const;
  /// Fills `out` with the bytes from `offset` on. Throws Error if the file ends before.
  void readAt(int64_t offset, std::span<std::byte> out) const;
  void writeAt(int64_t offset, std::span<const std::byte> data) const;

 private:
  File(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  std::string path_;
  int descriptor_;
};

/// While one exists, File::open(), and so every reader in core/io, opens only files that `check` allows, on
/// this thread. Of several scopes, only the innermost counts.
class ReadScope {
 public:
  /// Throws Error unless the file may be read. `path` is the path that was asked for; `place` is the path,
  /// without symbolic links, of the file that has been opened.
  using Check = std::function<void(const std::string& path, const std::string& place)>;
  explicit ReadScope(Check check);
  ~ReadScope();
  ReadScope(const ReadScope&) = delete;
  ReadScope& operator=(const ReadScope&) = delete;

 private:
  friend class File;
  const Check check_;
  const ReadScope* const outer_;
};

/// While one exists, every reader in core/io calls `check` on this thread before each read of at most 8 MiB.
/// An exception from it ends the reading. Of several, only the innermost counts.
class ReadWatch {
 public:
  explicit ReadWatch(std::function<void()> check);
  ~ReadWatch();
  ReadWatch(const ReadWatch&) = delete;
  ReadWatch& operator=(const ReadWatch&) = delete;

  /// Calls the check of the innermost one on this thread, if there is one. Readers that do not read by File
  /// call it.
  static void check();

 private:
  const std::function<void()> check_;
  const ReadWatch* const outer_;
};

/// The innermost scope and watch of a thread.
struct ReadRules {
  const ReadScope* scope = nullptr;
  const ReadWatch* watch = nullptr;
};
using RulesOfThread = ReadRules& (*)();

/// readRules() returns the function that gives the calling thread's rules. A plugin (core/comm/plugin.h) has
/// its own copy of the code in this file. The program that opens it passes its readRules() to the plugin's
/// shareReadRules() before any other call, so that the same rules apply in both.
RulesOfThread readRules();
void shareReadRules(RulesOfThread ofProgram);

/// Returns the content of a text file. Throws Error if it has more than `limit` bytes.
std::string readText(const std::string& path, int64_t limit = int64_t(64) << 20);
void writeText(const std::string& path, const std::string& text);

/// Returns the extension in lower case with its dot, such as ".vti"; empty if there is none.
std::string extensionOf(const std::string& path);

/// Returns the path of `name`, which is relative to the folder of `document` unless it is absolute.
std::string beside(const std::string& document, const std::string& name);

}  // namespace gxy
