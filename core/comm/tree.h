// SPDX-License-Identifier: Apache-2.0
// The binary tree over all ranks along which messages go down to all ranks and up to one, rooted at any rank.
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

/// Calls `action(r)` for `rank` and all ranks below it in that tree.
template <class Action>
void forEachInSubtree(int rank, int root, int size, const Action& action) {
  action(rank);
  forEachTreeChild(rank, root, size, [&](int child) { forEachInSubtree(child, root, size, action); });
}

/// Returns the parent of `rank` in that tree, or -1 for the root.
inline int treeParent(int rank, int root, int size) {
  const int64_t place = (int64_t(rank) - root + size) % size;
  return place == 0 ? -1 : int(((place - 1) / 2 + root) % size);
}

/// Returns the number of children of `rank` in that tree.
inline int treeChildren(int rank, int root, int size) {
  int children = 0;
  forEachTreeChild(rank, root, size, [&](int) { ++children; });
  return children;
}

}  // namespace gxy
