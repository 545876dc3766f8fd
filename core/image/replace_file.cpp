// SPDX-License-Identifier: Apache-2.0
#include "core/image/replace_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "core/comm/error.h"

namespace gxy {

void replaceFile(const std::string& path, std::span<const std::byte> bytes) {
  // A device or a pipe cannot be replaced. Of a symbolic link, the file that it points to is replaced.
  std::error_code none;
  const auto kind = std::filesystem::status(path, none).type();
  const bool special =
      kind != std::filesystem::file_type::regular && kind != std::filesystem::file_type::not_found;
  const std::string place =
      kind == std::filesystem::file_type::regular ? std::filesystem::canonical(path, none).string() : path;
  const std::string partial = special ? place : place + ".partial";
  std::FILE* file = std::fopen(partial.c_str(), "wb");
  bool well = file && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  int reason = errno;
  if (file && std::fclose(file) != 0 && well) well = false, reason = errno;
  if (well && !special && std::rename(partial.c_str(), place.c_str()) != 0) well = false, reason = errno;
  if (well) return;
  if (file && !special) std::remove(partial.c_str());
  throw Error(path + ": cannot be written: " + std::strerror(reason));
}

}  // namespace gxy
