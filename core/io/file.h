// SPDX-License-Identifier: Apache-2.0
// Files by position, with 64-bit offsets, and small text files as a whole.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace gxy {

/// An open file. Reads and writes at a position are safe from any thread. Errors name the file and the
/// system's reason.
class File {
 public:
  static File open(const std::string& path);    ///< an existing regular file, for reading
  static File create(const std::string& path);  ///< for writing; an older file is emptied
  File(File&& other) noexcept;
  File& operator=(File&&) = delete;
  ~File();

  const std::string& path() const { return path_; }
  /// A name of what is open, whatever is at its path by now, for as long as it is.
  std::string opened() const;
  int64_t size() const;
  /// Fills `out` from `offset` on; Error when the file ends before.
  void readAt(int64_t offset, std::span<std::byte> out) const;
  void writeAt(int64_t offset, std::span<const std::byte> data) const;

 private:
  File(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  std::string path_;
  int descriptor_;
};

/// While one exists, the files that File opens for reading on this thread, and with it all readers of this part, are those
/// that it lets. The inner one of two counts.
class ReadScope {
 public:
  /// `check` throws Error unless a file may be read: its path as asked for, and the path, without links, of what has been
  /// opened.
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

/// While one exists, `check` is called on this thread before File reads some megabytes or less, by all readers of this part; what
/// it throws ends them. The inner one of two counts.
class ReadWatch {
 public:
  explicit ReadWatch(std::function<void()> check);
  ~ReadWatch();
  ReadWatch(const ReadWatch&) = delete;
  ReadWatch& operator=(const ReadWatch&) = delete;

  /// Calls the check of the innermost one on this thread, if there is any: for readers that get bytes by themselves.
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

/// Gives the calling thread's rules. A plugin (core/comm/plugin.h) has a copy of these functions: the program that opens it
/// hands its own readRules() to the plugin's shareReadRules() before it calls anything else there, so that the same rules hold
/// in both.
RulesOfThread readRules();
void shareReadRules(RulesOfThread ofProgram);

/// The whole of a text file of at most `limit` bytes.
std::string readText(const std::string& path, int64_t limit = int64_t(64) << 20);
void writeText(const std::string& path, const std::string& text);

/// Lower-case extension with its dot, ".vti"; empty if there is none.
std::string extensionOf(const std::string& path);

/// `name` as seen from the folder that holds `document`: absolute names stay as they are.
std::string beside(const std::string& document, const std::string& name);

}  // namespace gxy
