// SPDX-License-Identifier: Apache-2.0
// The reference picture of a scene, which is kept on disk.
#pragma once
#include <functional>
#include <string>

#include "core/scene/scene.h"
#include "tools/gxybench/errors.h"

namespace gxy::bench {

using Progress = std::function<void(double)>;  ///< the fraction done

/// Returns the truth of a state whose files are relative to `directory`, from the folder `cache` if it was
/// rendered before. It is found by the content of data, visualization and camera; tolerance and step do not
/// matter.
Truth truthOf(const State& state, const std::string& directory, const std::string& cache,
              const Progress& progress);

}  // namespace gxy::bench
