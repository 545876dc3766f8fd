// SPDX-License-Identifier: Apache-2.0
// For whom a frame is rendered.
#pragma once
#include <cstdint>

namespace gxy {

struct Share {
  uint32_t tenant = 0;
  bool interactive = false;  ///< somebody looks at it: may go before what nobody watches
  uint64_t stream = 0;       ///< of the tenant: one window or batch, whose frames are wanted in their order
};

}  // namespace gxy
