// SPDX-License-Identifier: Apache-2.0
// Compiles operators that show unstructured volumes; a part of compileScene().
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/comm/advance.h"
#include "core/rays/compiled_scene.h"

namespace gxy {

/// Fills in the operator's map, component and isovalues. Throws Error for what unstructured volumes cannot show yet: places at equal
/// distances.
void compileMesh(CompiledOperator& op, const CompiledScene& scene);

/// Says that isosurfaces of flat cells are those of averages at points, if the operator asks for such; for users.
std::optional<std::string> warningOf(const Vis& vis, const Mesh& mesh);

/// Fills in the cells of each local partition in which the map shows something, and the cells that isosurfaces and slices pass, and says
/// that these partitions are visible. If one of `others` shows the same of the same mesh, its cells are used.
void planMesh(CompiledOperator& op, CompiledScene& scene,
              std::span<const std::shared_ptr<const CompiledScene>> others, const Advance& advance);

}  // namespace gxy
