// SPDX-License-Identifier: Apache-2.0
// Pictures that should have the same bits.
#pragma once
#include <string>

#include "gxy/render/framebuffer.h"

namespace gxy::test {

/// The first pixels in which two pictures differ in any bit, in words; empty if they are the same. Where they
/// are not, both and their difference (times 8) are written as TEST-NUMBER_{expected,found,difference}.png
/// into the test's temporary folder.
std::string difference(const Picture& expected, const Picture& found);

}  // namespace gxy::test
