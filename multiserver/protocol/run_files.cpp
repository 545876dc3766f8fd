// SPDX-License-Identifier: Apache-2.0
#include "gxy/protocol/run_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

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

void writeToken(const std::string& path, const std::string& token) {
  unlink(path.c_str());  // of a server that was killed
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  const std::string line = token + "\n";
  const bool written = file >= 0 && write(file, line.data(), line.size()) == ssize_t(line.size());
  const int reason = errno;
  if (file >= 0) close(file);
  if (!written) throw Error(path + ": cannot write the token: " + std::strerror(reason));
}

}  // namespace gxy::protocol
