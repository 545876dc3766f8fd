// SPDX-License-Identifier: Apache-2.0
// A partitioning as bytes, to be sent to other ranks.
#pragma once
#include <span>

#include "core/comm/transport.h"
#include "core/data/partitioning.h"

namespace gxy {

Bytes written(const Partitioning& partitioning);
/// Reads what written() wrote. Throws Error for anything else.
Partitioning readPartitioning(std::span<const std::byte> message);

}  // namespace gxy
