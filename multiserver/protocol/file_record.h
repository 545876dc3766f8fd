// SPDX-License-Identifier: Apache-2.0
// Records of the file channel (docs/protocol.md, section 7).
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/comm/transport.h"
#include "multiserver/protocol/json.h"

namespace gxy::protocol {

/// Makes a record: the length of its header as text (4 bytes), the header, and the content.
inline Bytes fileRecord(const nlohmann::json& header, std::span<const std::byte> content) {
  const std::string text = dump(header);
  const auto size = uint32_t(text.size());
  Bytes record(sizeof size + text.size() + content.size());
  std::memcpy(record.data(), &size, sizeof size);
  std::memcpy(record.data() + sizeof size, text.data(), text.size());
  std::copy(content.begin(), content.end(), record.begin() + std::ptrdiff_t(sizeof size + text.size()));
  return record;
}

}  // namespace gxy::protocol
