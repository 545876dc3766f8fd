// SPDX-License-Identifier: Apache-2.0
// Numbers written as text, piece by piece. Used inside core/io only.
#pragma once
#include "gxy/data/scalar.h"
#include "gxy/io/byte_stream.h"

namespace gxy {

/// The numbers between white space as values of `type` in this machine's byte order, up to the text's end or a '<'. "nan" and
/// "inf" in any case are numbers. Its read() takes whole values only, and throws Error, which begins with `where`, for what is none.
ByteStreamPtr numbersOfText(ByteStreamPtr text, ScalarType type, const std::string& where);

}  // namespace gxy
