// SPDX-License-Identifier: Apache-2.0
// CRC-32C (Castagnoli), the checksum of iSCSI (RFC 3720, section 12.1), which processors compute.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace gxy {

/// Returns the CRC-32C of `bytes`: by the processor's instruction if it has one (SSE4.2), else by a table.
uint32_t crc32c(std::span<const std::byte> bytes);

/// The same by a table on any processor.
uint32_t crc32cByTable(std::span<const std::byte> bytes);

}  // namespace gxy
