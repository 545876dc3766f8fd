// SPDX-License-Identifier: Apache-2.0
// Parses numbers in text, piece by piece. Used inside core/io only.
#pragma once
#include <optional>
#include <string_view>

#include "core/data/scalar.h"
#include "core/io/byte_stream.h"

namespace gxy {

/// The numbers of a text in a file from `position` on, up to its end or a '<', as `bytes` bytes of values of `type` in this
/// machine's byte order, in blocks of 65536 values. Numbers are separated by white space; "nan" and "inf" in any letter case are
/// numbers. Where the blocks begin is found, on all cores, when one is opened for the first time. A block's read() takes whole
/// values only, and throws Error, which begins with `where`, for a word that is not a number.
std::shared_ptr<const BlockedBytes> textBlocks(std::shared_ptr<const File> file, int64_t position,
                                               ScalarType type, int64_t bytes, const std::string& where);

/// Returns the number that the whole text is; nothing if it is not a number.
std::optional<double> valueOfText(std::string_view text);

}  // namespace gxy
