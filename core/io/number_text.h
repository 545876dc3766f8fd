// SPDX-License-Identifier: Apache-2.0
// Parses numbers in text, piece by piece. Used inside core/io only.
#pragma once
#include <optional>
#include <string_view>

#include "core/data/scalar.h"
#include "core/io/byte_stream.h"

namespace gxy {

/// Converts the numbers of a text, up to its end or a '<', to values of `type` in this machine's byte order.
/// Numbers are separated by white space; "nan" and "inf" in any letter case are numbers. The size passed to
/// read() must be a multiple of a value's size. read() throws Error, which begins with `where`, for a word
/// that is not a number.
ByteStreamPtr numbersOfText(ByteStreamPtr text, ScalarType type, const std::string& where);

/// The same for text in a file from `position` on, as one block of `bytes` bytes of values.
std::shared_ptr<const BlockedBytes> textBlock(std::shared_ptr<const File> file, int64_t position,
                                              ScalarType type, int64_t bytes, const std::string& where);

/// Returns the number that the whole text is; nothing if it is not a number.
std::optional<double> valueOfText(std::string_view text);

}  // namespace gxy
