// SPDX-License-Identifier: Apache-2.0
// What tests/support renders on here where it is not told: Embree, to compare with.
#include "tests/support/backends.h"

#include "backends/embree/embree_backend.h"

namespace gxy::test {

const Backend& embree() {
  static const std::unique_ptr<Backend> backend = makeEmbreeBackend();
  return *backend;
}

const Backend& testedBackend() { return embree(); }

}  // namespace gxy::test
