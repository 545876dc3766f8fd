// SPDX-License-Identifier: Apache-2.0
// The backend with the kernels of one instruction set alone, as the only symbol of a shared library.
#include "backends/embree/embree_backend.h"

__attribute__((visibility("default"))) std::unique_ptr<gxy::Backend> MAKER() {
  return gxy::makeEmbreeBackend();
}
