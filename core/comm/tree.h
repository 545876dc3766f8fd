// SPDX-License-Identifier: Apache-2.0
// The binary tree over all ranks along which messages are broadcast, rooted at any rank.
#pragma once
#include <cstdint>

namespace gxy {

/// Calls `action(child)` for each of the at most two children of `rank` in the tree rooted at `root` over
/// `size` ranks.
template <class Action>
void forEachTreeChild(int rank, int root, int size, Action&& action) {
  const int64_t place = (int64_t(rank) - root + size) % size;
  for (int64_t child = 2 * place + 1; child <= 2 * place + 2 && child < size; ++child)
    action(int((child + root) % size));
}

}  // namespace gxy
