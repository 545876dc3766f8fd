// SPDX-License-Identifier: Apache-2.0
// The first bytes of a connection, by which one port serves programs and browsers.
#pragma once
#include <cstddef>
#include <span>

namespace gxy {

/// What the other side speaks: Unknown until enough bytes have come to tell.
enum class Opening { Unknown, Galaxy, Web, Neither };

/// At most so many bytes are needed.
inline constexpr size_t kOpeningBytes = 4;

/// Tells by the first bytes: those of the preamble (docs/protocol.md, section 1), or of a method of HTTP.
Opening openingOf(std::span<const std::byte> first);

}  // namespace gxy
