// SPDX-License-Identifier: Apache-2.0
// Numbers written as text, piece by piece. Used inside core/io only.
#pragma once
#include <optional>
#include <string_view>

#include "core/data/scalar.h"
#include "core/io/byte_stream.h"

namespace gxy {

/// The numbers between white space as values of `type` in this machine's byte order, up to the text's end or a '<'. "nan" and
/// "inf" in any case are numbers. Its read() takes whole values only, and throws Error, which begins with `where`, for what is none.
ByteStreamPtr numbersOfText(ByteStreamPtr text, ScalarType type, const std::string& where);

/// The same in a file, of `bytes` bytes in all as values, as one block.
std::shared_ptr<const BlockedBytes> textBlock(std::shared_ptr<const File> file, int64_t position,
                                              ScalarType type, int64_t bytes, const std::string& where);

/// The number that is all of a text; none if it is no number.
std::optional<double> valueOfText(std::string_view text);

}  // namespace gxy
