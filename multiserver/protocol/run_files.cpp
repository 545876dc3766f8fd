// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/run_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <thread>

#include "core/comm/error.h"

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

namespace {

/// An open file. If it could not be opened, it is negative and errno has the reason.
class File {
 public:
  explicit File(const std::string& path, int flags = 0)
      : file_(open(path.c_str(), O_RDONLY | O_CLOEXEC | flags)) {}
  ~File() {
    if (file_ >= 0) close(file_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  operator int() const { return file_; }

 private:
  const int file_;
};

// Locks a file for as long as it is open. Refused: another process has locked it. Impossible: the file
// system has no locks.
enum class Lock { Taken, Refused, Impossible };
Lock lock(int file, int mode) {
  if (flock(file, mode | LOCK_NB) == 0) return Lock::Taken;
  return errno == EWOULDBLOCK ? Lock::Refused : Lock::Impossible;
}

// Returns whether a running server has locked the file, and locks it otherwise. A client that tests whether a
// file is locked locks it for a moment; the attempts wait for that.
bool inUse(int file) {
  for (int attempt = 0; attempt < 10; attempt++) {
    if (lock(file, LOCK_EX) != Lock::Refused) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

bool isAt(const std::string& path, int file) {
  struct stat open = {}, there = {};
  return fstat(file, &open) == 0 && lstat(path.c_str(), &there) == 0 && open.st_ino == there.st_ino &&
         open.st_dev == there.st_dev;
}

std::string contentOf(int file) {
  std::array<char, 256> text{};
  const ssize_t size = read(file, text.data(), text.size());
  return {text.data(), size_t(size > 0 ? size : 0)};
}

// Whether a file is a regular file that is empty or has a token as newToken() makes it.
bool looksLikeToken(int file) {
  struct stat info = {};
  std::array<char, 66> text{};
  if (fstat(file, &info) != 0 || !S_ISREG(info.st_mode)) return false;
  const ssize_t size = read(file, text.data(), text.size());
  if (size < 0 || size > 65) return false;
  const std::string_view line(text.data(), size_t(size));
  return line.find_first_not_of("0123456789abcdef\n") == line.npos;
}

std::string tokenIn(const File& file, const std::string& path) {
  if (file < 0)
    throw Error(path + ": cannot read the server's token: " + std::strerror(errno) +
                "; is a server running here? else copy its token file and name it with --token-file");
  std::string token = contentOf(file);
  token.erase(token.find_last_not_of(" \r\n\t") + 1);
  if (token.empty()) throw Error(path + ": there is no token in it, expected one line of text");
  return token;
}

[[noreturn]] void failNoToken(const std::string& path) {
  throw Error(path +
              ": there is something that is no token, expected a new file or one that a server has left");
}

[[noreturn]] void failInUse(const std::string& path) {
  throw Error(path + ": a server that runs has its token there, expected another port or --token-file");
}

}  // namespace

std::string readToken(const std::string& path) { return tokenIn(File(path), path); }

std::string readServerToken(uint16_t port) {
  const std::string path = tokenFile(port);
  const File file(path);
  std::string token = tokenIn(file, path);
  if (lock(file, LOCK_SH) == Lock::Taken)
    throw Error(path + ": a server that was killed has left this token, and none runs on port " +
                std::to_string(port) + " now");
  return token;
}

void removeStaleToken(const std::string& path) {
  const File file(path, O_NOFOLLOW | O_NONBLOCK);
  struct stat info = {};
  // A server may be about to lock an empty file.
  if (file < 0 || !looksLikeToken(file) || fstat(file, &info) != 0 || info.st_size == 0) return;
  if (lock(file, LOCK_EX) == Lock::Taken && isAt(path, file)) unlink(path.c_str());
}

void removeStaleTokens() {
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(runDirectory(), failed))
    if (entry.path().extension() == ".token") removeStaleToken(entry.path());
}

TokenFile::TokenFile(std::string path, const std::string& token) : path_(std::move(path)) {
  const File old(path_, O_NOFOLLOW | O_NONBLOCK);  // While it is locked, no one removes its successor.
  if (old < 0 && errno != ENOENT) failNoToken(path_);
  if (old >= 0 && inUse(old)) failInUse(path_);
  if (old >= 0 && !looksLikeToken(old)) failNoToken(path_);
  unlink(path_.c_str());  // left by a server that was killed
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
  if (isAt(path_, file_)) unlink(path_.c_str());  // Without locks, it may be another server's file by now.
  close(file_);
}

}  // namespace gxy::protocol
