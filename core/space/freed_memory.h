// SPDX-License-Identifier: Apache-2.0
// Memory that has been freed goes back to the system.
#pragma once

namespace gxy {

/// Gives what this process has freed back to the system. The allocator keeps blocks of up to some megabytes, and
/// may keep hundreds of megabytes of them after files have been read and data distributed. Takes milliseconds. Thread safe.
void returnFreedMemory() noexcept;

}  // namespace gxy
