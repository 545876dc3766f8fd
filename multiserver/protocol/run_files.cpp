// SPDX-License-Identifier: Apache-2.0
#include "gxy/protocol/run_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "gxy/comm/error.h"

namespace gxy::protocol {

std::string runDirectory() {
  const char* user = std::getenv("XDG_RUNTIME_DIR");
  if (user && *user) return std::string(user) + "/galaxy";
  return "/tmp/galaxy-" + std::to_string(getuid());
}

void makeRunDirectory() {
  const std::string directory = runDirectory();
  if (mkdir(directory.c_str(), 0700) != 0 && errno != EEXIST)
    throw Error(directory + ": cannot make the run directory: " + std::strerror(errno));
  struct stat info {};
  if (lstat(directory.c_str(), &info) != 0 || !S_ISDIR(info.st_mode) || info.st_uid != getuid() ||
      (info.st_mode & 077) != 0)
    throw Error(directory + ": it is not a folder of yours alone, expected one with mode 0700");
}

std::string tokenFile(uint16_t port, const std::string& tenant) {
  return runDirectory() + "/" + std::to_string(port) + (tenant.empty() ? "" : "." + tenant) + ".token";
}

std::string readToken(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0)
    throw Error(path + ": cannot read the server's token: " + std::strerror(errno) +
                "; is a server running here? else copy its token file and name it with --token-file");
  std::array<char, 256> text{};
  const ssize_t size = read(file, text.data(), text.size());
  close(file);
  std::string token(text.data(), size_t(size > 0 ? size : 0));
  token.erase(token.find_last_not_of(" \r\n\t") + 1);
  if (token.empty()) throw Error(path + ": there is no token in it, expected one line of text");
  return token;
}

namespace {

// Locked by who wrote it, and so for as long as that runs. File systems without locks lock nothing.
bool inUse(int file) { return flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK; }

// A regular file with nothing in it, or with what newToken() makes.
bool looksLikeToken(int file) {
  struct stat info = {};
  std::array<char, 66> text{};
  if (fstat(file, &info) != 0 || !S_ISREG(info.st_mode)) return false;
  const ssize_t size = read(file, text.data(), text.size());
  if (size < 0 || size > 65) return false;
  const std::string_view line(text.data(), size_t(size));
  return line.find_first_not_of("0123456789abcdef\n") == line.npos;
}

[[noreturn]] void failNoToken(const std::string& path) {
  throw Error(path +
              ": there is something that is no token, expected a new file or one that a server has left");
}

[[noreturn]] void failInUse(const std::string& path) {
  throw Error(path + ": a server that runs has its token there, expected another port or --token-file");
}

}  // namespace

TokenFile::TokenFile(std::string path, const std::string& token) : path_(std::move(path)) {
  if (const int old = open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK); old >= 0) {
    const bool taken = inUse(old), isToken = looksLikeToken(old);
    close(old);
    if (taken) failInUse(path_);
    if (!isToken) failNoToken(path_);
  } else if (errno != ENOENT) {
    failNoToken(path_);
  }
  unlink(path_.c_str());  // of a server that was killed
  file_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file_ >= 0 && inUse(file_)) {
    close(file_);
    failInUse(path_);
  }
  const std::string line = token + "\n";
  if (file_ >= 0 && write(file_, line.data(), line.size()) == ssize_t(line.size())) return;
  const int reason = errno;
  if (file_ >= 0) close(file_);
  throw Error(path_ + ": cannot write the token: " + std::strerror(reason));
}

TokenFile::~TokenFile() {
  if (file_ < 0) return;
  struct stat mine = {}, there = {};  // another's by now, where nothing could be locked
  if (fstat(file_, &mine) == 0 && lstat(path_.c_str(), &there) == 0 && mine.st_ino == there.st_ino &&
      mine.st_dev == there.st_dev)
    unlink(path_.c_str());
  close(file_);
}

}  // namespace gxy::protocol
