// SPDX-License-Identifier: Apache-2.0
// The scenes that gxybench renders: its own, whose data it makes, and those of state files.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace gxy::bench {

/// A file of a scene's data, and how it is made.
struct DataFile {
  std::string name;  ///< with what it depends on, so that a changed field is another file
  std::function<void(const std::string&)> make;  ///< writes it to a path
};

/// One visualization from one camera.
struct Scene {
  std::string name, about;
  State state;
  std::string directory;       ///< what dataset file names are relative to; empty: the folder of made data
  std::vector<DataFile> data;  ///< to be made

  bool rendersVolumes() const;
  bool hasExtinctionMaps() const;  ///< of a volume that is rendered
  bool isosurfacesAlone() const;
};

/// The fixed list (numerics.md section 8); `quick`: small ones, for a test of the plumbing.
std::vector<Scene> fixedScenes(bool quick);

/// One scene for each visualization and camera of a state file. Warnings go to `warn`. Throws Error for files
/// that cannot be read or show nothing.
std::vector<Scene> scenesOf(const std::string& stateFile,
                            const std::function<void(const std::string&)>& warn);

/// Makes the scene's data in `folder` where they are not there yet, and sets its directory.
void makeData(Scene& scene, const std::string& folder);

/// How a scene is rendered for one row.
struct Setting {
  std::string method, label;
  State state;
};

struct Ladders {
  std::vector<std::string> methods{"adaptive", "fixed", "uncorrected"};
  std::vector<double> tolerances, steps;
};

/// The settings of a scene, from coarse to fine within each method:
///   adaptive     the integrator that users get, at each tolerance
///   fixed        midpoint segments of each step, in cells
///   uncorrected  the earlier Galaxy's rule: one sample a cell takes the map's opacity, whatever thickness the
///                map speaks of. Said by what a state file can say: step 1, and `reference length` left out; not for scenes
///                with extinction maps, which speak of no thickness.
/// A scene without volume rendering has one setting, adaptive at the scene's own tolerance.
std::vector<Setting> settingsOf(const Scene& scene, const Ladders& ladders);

/// "1/512", "0.3".
std::string fractionText(double x);

}  // namespace gxy::bench
