// SPDX-License-Identifier: Apache-2.0
// The backend under test, made once per program.
#pragma once
#include "backends/embree/embree_backend.h"

namespace gxy::agreement {

inline const Backend& embree() {
  static const std::unique_ptr<Backend> backend = makeEmbreeBackend();
  return *backend;
}

}  // namespace gxy::agreement
