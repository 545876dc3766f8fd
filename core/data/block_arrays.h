// SPDX-License-Identifier: Apache-2.0
// The list of the arrays of a block of geometry, for what is done in the same way to each.
#pragma once
#include <cstddef>
#include <span>

#include "core/data/geometry.h"

namespace gxy {

/// Calls use(of, each) for each array of points of blocks with these fields. of(block) is the array of a block; it has `each`
/// entries for each point, or none.
template <class Use>
void forPointArrays(std::span<const PointField> fields, Use use) {
  use(
      [](auto& block) -> auto& { return block.points; }, size_t(1));
  use(
      [](auto& block) -> auto& { return block.normals; }, size_t(1));
  use(
      [](auto& block) -> auto& { return block.values; }, size_t(1));
  use(
      [](auto& block) -> auto& { return block.colors; }, size_t(1));
  use(
      [](auto& block) -> auto& { return block.radiusValues; }, size_t(1));
  for (size_t f = 0; f < fields.size(); f++)
    use(
        [f](auto& block) -> auto& { return block.fields[f].values; }, size_t(fields[f].components));
}

/// Calls use(of) for each array of primitives of blocks. of(block) is the array of a block; it has an entry for each primitive,
/// or none.
template <class Use>
void forPrimitiveArrays(Use use) {
  use([](auto& block) -> auto& { return block.triangles; });
  use([](auto& block) -> auto& { return block.segments; });
  use([](auto& block) -> auto& { return block.neighbours; });
  use([](auto& block) -> auto& { return block.ids; });
}

}  // namespace gxy
