// SPDX-License-Identifier: Apache-2.0
// The pictures of a sweep over a state: a scene, a camera and a row of the table for each.
#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "core/scene/state_file.h"
#include "core/scene/sweep.h"

namespace gxy {

/// What several pictures show from different cameras.
struct SweptScene {
  size_t datasets = 0;  ///< index of SweptPictures::datasets
  Visualization visualization;
  RenderSettings settings;
  Annotations annotations;
  bool operator==(const SweptScene&) const = default;
};

struct SweptPicture {
  size_t scene = 0;                     ///< index of SweptPictures::scenes
  Camera camera;                        ///< before fitted() (resolve.h)
  std::vector<std::string> parameters;  ///< of its row; that of the time is empty
};

struct SweptPictures {
  std::vector<std::string> columns;  ///< of the parameters
  std::optional<size_t> time;        ///< the column of the time, if there is one
  std::vector<std::vector<DatasetSpec>>
      datasets;  ///< more than one only where the sweep varies keys of datasets
  std::vector<SweptScene> scenes;
  std::vector<SweptPicture> pictures;  ///< in the order of the table

  /// Returns the state of all scenes with these datasets: the visualizations of the scenes that `scenesOf` lists, in that order,
  /// without cameras.
  State stateOf(size_t datasets) const;
  std::vector<size_t> scenesOf(size_t datasets) const;
  /// The cells of a picture's parameters, with the time in place.
  std::vector<std::string> parametersOf(size_t picture, const std::string& time) const;
};

/// Reads the text of a whole state, as readState() does.
using StateOfText = std::function<StateFile(const std::string& text)>;

/// Returns the number of pictures that a sweep makes of a state in one time step. Throws Error if they are too many, or the sweep
/// does not fit the state.
size_t countOfPictures(const Sweep& sweep, State state);

/// Returns the number of different scenes at most.
size_t countOfScenes(const Sweep& sweep);

/// Returns the pictures. Each equals the picture that the state makes once the values of its row have been written into it. The
/// state has one visualization, and one camera unless the sweep has an axis of them; without any, it has defaultCamera()
/// (resolve.h). A visualization's own camera is the state's only one. `read` reads states in which a value has been changed; `check` is called before each and may throw. Throws Error
/// "SOURCE:LINE:COLUMN: ..." for a sweep that does not fit the state, or a state with its values, and Error for a picture whose
/// file would have a name that is too long.
SweptPictures sweptPictures(const Sweep& sweep, State state, const StateOfText& read,
                            const std::function<void()>& check = {});

}  // namespace gxy
