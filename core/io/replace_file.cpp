// SPDX-License-Identifier: Apache-2.0
#include "replace_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "gxy/comm/error.h"

namespace gxy {

void replaceFile(const std::string& path, std::span<const std::byte> bytes) {
  const std::string partial = path + ".partial";
  std::FILE* file = std::fopen(partial.c_str(), "wb");
  bool well = file && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  int reason = errno;
  if (file && std::fclose(file) != 0 && well) well = false, reason = errno;
  if (well && std::rename(partial.c_str(), path.c_str()) != 0) well = false, reason = errno;
  if (well) return;
  if (file) std::remove(partial.c_str());
  throw Error(path + ": cannot be written: " + std::strerror(reason));
}

}  // namespace gxy
