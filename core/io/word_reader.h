// SPDX-License-Identifier: Apache-2.0
// Words and lines of a file of any size, of which a few kilobytes are held, and the places where bytes among them begin. Used
// inside core/io only.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/io/file.h"

namespace gxy {

class WordReader {
 public:
  explicit WordReader(std::shared_ptr<const File> file) : file_(std::move(file)), size_(file_->size()) {}

  /// The next word between white space; empty at the end. Throws Error for one of more than 64 KiB, as do the next two.
  std::string word();
  /// The rest of the current line, without its end ("\n" or "\r\n"), which is passed over.
  std::string line();
  /// The same without white space at its ends; the line's end is not passed over.
  std::string restOfLine();

  /// Passes over the rest of a line whose words have all been read, where its end has not been: what follows is data. Throws Error
  /// if there are more words on the line.
  void dataBegins();
  void skipBytes(int64_t bytes);
  void skipWords(int64_t words);
  /// Of the next byte.
  int64_t position() const { return at_; }

  /// Throws Error: the path, near which byte, and what.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  int peek();  ///< -1 at the end

  std::shared_ptr<const File> file_;
  int64_t size_, at_ = 0;
  bool lineEnded_ = true;  ///< nothing has been read of the line
  std::vector<std::byte> buffer_;
  int64_t buffered_ = 0;  ///< position of the buffer's first byte
};

}  // namespace gxy
