// SPDX-License-Identifier: Apache-2.0
// The `put` of fill_views.h: kernels read the host's own arrays.
#pragma once
#include <vector>

#include "core/data/volume.h"

namespace gxy {

struct ViewPointers {
  struct Any {
    const void* at;
    template <class T>
    operator const T*() const {
      return static_cast<const T*>(at);
    }
    operator const void*() const { return at; }
  };
  template <class T>
  Any operator()(const std::vector<T>& v) const {
    return {v.empty() ? nullptr : v.data()};
  }
  Any samples(const VolumeBlock& block) const { return {block.samples.data()}; }
};

}  // namespace gxy
