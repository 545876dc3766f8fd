// SPDX-License-Identifier: Apache-2.0
#include "core/data/dataset.h"

#include <algorithm>
#include <map>

#include "core/comm/error.h"

namespace gxy {

std::vector<Origin> originsOf(std::span<const InputOrigins> inputs) {
  std::map<uint64_t, std::pair<int64_t, const std::string*>> steps;  // by source, with the input that has it
  for (const InputOrigins& input : inputs)
    for (const auto& [source, step] : input.origins) {
      const auto [known, isNew] = steps.emplace(source, std::pair(step, &input.name));
      if (!isNew && known->second.first != step)
        throw Error("\"" + *known->second.second + "\" is of step " + std::to_string(known->second.first) +
                    " and \"" + input.name + "\" of step " + std::to_string(step) +
                    " of the same source, expected data of one step");
    }
  std::vector<Origin> origins;
  for (const auto& [source, known] : steps) origins.push_back({source, known.first});
  return origins;
}

Box Dataset::box() const { return volume ? volume->grid.box() : mesh ? mesh->box : geometry->box; }
Range Dataset::range() const {
  return volume ? volume->ranges.back() : mesh ? mesh->ranges.back() : geometry->range;
}
int Dataset::components() const { return volume ? volume->components : mesh ? mesh->components : 1; }

void refuseMesh(const Dataset& dataset, const std::string& name, const std::string& what) {
  if (dataset.mesh)
    throw Error(what + ": \"" + name +
                "\" is an unstructured volume, which is not supported here yet; expected a volume on a "
                "uniform grid or geometry");
}

int64_t newestStep(const Dataset& dataset) {
  int64_t newest = 0;
  for (const Origin& origin : dataset.origins) newest = std::max(newest, origin.step);
  return newest;
}

}  // namespace gxy
