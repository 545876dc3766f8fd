// SPDX-License-Identifier: Apache-2.0
// A line over TCP alone, as programs have it.
#pragma once
#include <memory>

#include "multiserver/web/line.h"

namespace gxy {

/// What is written is the header and the payload, and nothing more.
std::shared_ptr<Line> makeTcpLine(Line::Socket socket);

}  // namespace gxy
