// SPDX-License-Identifier: Apache-2.0
// Pictures that should be the same.
#pragma once
#include <string>

#include "core/render/framebuffer.h"
#include "tests/support/backends.h"

namespace gxy::test {

/// The first pixels in which two pictures differ in any bit, in words; empty if they are the same, or if they agree as far as
/// is asked (close_pictures.h). Where they do not, both and their difference (over its largest) are written as
/// TEST-NUMBER_{expected,found,difference}.png into the test's temporary folder.
std::string difference(const Picture& expected, const Picture& found, Sameness asked = testedSameness());

struct TestScene;
/// What pieces are compared with, to the bit: the tested backend's own picture of the scene in one piece, which is expected to be
/// Embree's (testedSameness).
Picture wholeOnTested(const TestScene& scene);

}  // namespace gxy::test
