// SPDX-License-Identifier: Apache-2.0
// Compares pictures that should be the same.
#pragma once
#include <string>

#include "core/render/framebuffer.h"
#include "tests/support/backends.h"

namespace gxy::test {

/// Returns text that names the first pixels in which two pictures differ in any bit. It is empty if they are
/// the same in the sense of `asked`. Otherwise both pictures and their difference, divided by its largest
/// value, are written as TEST-NUMBER_{expected,found,difference}.png into the test's temporary folder.
std::string difference(const Picture& expected, const Picture& found, Sameness asked = testedSameness());

struct TestScene;
/// Returns the tested backend's picture of the scene in one piece. Pictures of the scene in several pieces
/// must equal it in all bits. It is expected to be the same as Embree's (testedSameness()).
Picture wholeOnTested(const TestScene& scene);

}  // namespace gxy::test
