// SPDX-License-Identifier: Apache-2.0
// A file of an unstructured volume becomes the blocks of a rank's partitions.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/complete_mesh.h"
#include "core/data/mesh.h"
#include "core/data/partitioning.h"
#include "core/io/mesh_file.h"

namespace gxy {

/// What one rank has read of an unstructured volume. Each cell is on one rank only.
struct LoadedMesh : EncodedMesh {
  std::string path;   ///< for messages
  std::string name;   ///< that the mesh will have: of the file, and the array after a colon
  MeshReport report;  ///< on all ranks, what reading has counted: cells that are flat, ghosts or unusable
  LeftOut leftOut;    ///< of the files that this rank has read
};

/// Collective over `ranks`. Each rank reads its share of the pieces of a list, else its share of the cells of the file. Values
/// are of the same array of points, or of cells, in all pieces: `array`, or that which a list of VTK's declares, or that is chosen of the
/// first piece with points. They are stored as float, as encodingOf() says. On rank 0 `warnings` receives what was flawed in any file; null: they
/// are logged. `toTake`, if not empty, is told what this rank takes before it does. Tells ranks.done() how far it is. Throws Error, the
/// same on all ranks, if any fails, and if there are no cells with a volume.
LoadedMesh loadMesh(const std::string& path, const std::string& array, Collectives& ranks,
                    const TakeMemory& toTake = {}, std::vector<std::string>* warnings = nullptr);

/// Collective. The cells go into every partition that they touch. On rank 0 `warnings` receives sentences about what the mesh's report
/// counts, null: they are logged. `toTake`: as in distribute(). Throws Error, the same on all ranks, if any fails, and if no cell is
/// left.
std::shared_ptr<const Mesh> meshOf(LoadedMesh loaded, const Partitioning& partitioning, Collectives& ranks,
                                   const TakeMemory& toTake = {},
                                   std::vector<std::string>* warnings = nullptr);

/// Says in sentences what is remarkable in a mesh. Each begins with `path`.
std::vector<std::string> warningsOf(const MeshReport& report, const std::string& path);

}  // namespace gxy
