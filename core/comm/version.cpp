// SPDX-License-Identifier: Apache-2.0
#include "core/comm/version.h"

namespace gxy {

const char* const kVersion = GALAXY_VERSION;

}  // namespace gxy
