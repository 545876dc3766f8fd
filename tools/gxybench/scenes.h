// SPDX-License-Identifier: Apache-2.0
// The scenes that gxybench renders: its own, for which it makes the data, and those of state files.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace gxy::bench {

/// A file of a scene's data, and the function that makes it.
struct DataFile {
  std::string name;  ///< includes what the data depend on, so that a changed field is another file
  std::function<void(const std::string&)> make;  ///< writes the file to a path
};

/// One visualization from one camera.
struct Scene {
  std::string name, about;
  State state;
  std::string directory;       ///< folder of the datasets' files; empty: the folder of data that are made
  std::vector<DataFile> data;  ///< data that must be made

  bool rendersVolumes() const;
  bool hasExtinctionMaps() const;  ///< whether a rendered volume has one
  bool isosurfacesAlone() const;
};

/// The fixed list of scenes; `quick`: small ones, for a test of the program.
std::vector<Scene> fixedScenes(bool quick);

/// One scene for each visualization and camera of a state file. Warnings go to `warn`. Throws Error for files
/// that cannot be read or show nothing.
std::vector<Scene> scenesOf(const std::string& stateFile,
                            const std::function<void(const std::string&)>& warn);

/// Makes the scene's data in `folder` if they are not there yet, and sets its directory.
void makeData(Scene& scene, const std::string& folder);

/// How a scene is rendered for one row of the table.
struct Setting {
  std::string method, label;
  State state;
};

struct Ladders {
  std::vector<std::string> methods{"adaptive", "fixed", "uncorrected"};
  std::vector<double> tolerances, steps;
};

/// Returns the settings of a scene, from coarse to fine within each method:
///   adaptive     the integrator that users get, at each tolerance
///   fixed        midpoint segments of each step, in cells
///   uncorrected  the earlier Galaxy's rule: one sample a cell takes the map's opacity, whatever thickness
///                that is for. In terms of a state file: step 1, and `reference length` left out. Not for
///                scenes with extinction maps, which are for no thickness.
/// A scene without volume rendering has one setting, adaptive at the scene's own tolerance.
std::vector<Setting> settingsOf(const Scene& scene, const Ladders& ladders);

/// A number as a text such as "1/512" or "0.3".
std::string fractionText(double x);

}  // namespace gxy::bench
