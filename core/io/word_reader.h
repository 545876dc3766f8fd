// SPDX-License-Identifier: Apache-2.0
// Reads words and lines of a file of any size, with a few kilobytes of memory, and finds positions of binary
// data between them. Used inside core/io only.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/io/file.h"

namespace gxy {

class WordReader {
 public:
  explicit WordReader(std::shared_ptr<const File> file) : file_(std::move(file)), size_(file_->size()) {}

  /// Returns the next word between white space; empty at the end. This and the next two throw Error beyond 64 KiB.
  std::string word();
  /// Returns the rest of the current line without its end ("\n" or "\r\n"), and moves to the next line.
  std::string line();
  /// Returns the rest of the current line without surrounding white space, and stays before the line's end.
  std::string restOfLine();

  /// Moves past the end of the current line, unless that has happened: data follow. Throws Error if there are
  /// more words on the line.
  void dataBegins();
  void skipBytes(int64_t bytes);
  void skipWords(int64_t words);
  /// The position of the next byte.
  int64_t position() const { return at_; }

  /// Throws Error with the path, the position and `what`.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  int peek();  ///< -1 at the end

  std::shared_ptr<const File> file_;
  int64_t size_, at_ = 0;
  bool lineEnded_ = true;  ///< nothing of the current line has been read
  std::vector<std::byte> buffer_;
  int64_t buffered_ = 0;  ///< position of the buffer's first byte
};

}  // namespace gxy
