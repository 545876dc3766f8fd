// SPDX-License-Identifier: Apache-2.0
#include "core/space/freed_memory.h"

#include <malloc.h>

namespace gxy {

void returnFreedMemory() noexcept {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace gxy
