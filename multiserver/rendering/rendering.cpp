// SPDX-License-Identifier: Apache-2.0
#include "multiserver/rendering/rendering.h"

namespace gxy {

std::shared_ptr<Rendering> renderingOf(Registration& registration) {
  return registration.shared<Rendering>([&] { return std::make_shared<Rendering>(registration); });
}

}  // namespace gxy
