// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/io/write_volume.h"
#include "tools/gxydata/commands.h"

namespace gxy::data_tool {
namespace {

std::vector<Field> chosenFields(const std::vector<Field>& fields, const Options& options) {
  const bool several = extensionOf(options.out) == ".vti" && options.array.empty();
  if (several) return fields;
  if (options.array.empty()) return {fields.front()};
  for (const Field& field : fields)
    if (field.name == options.array) return {field};
  std::string names;
  for (const Field& field : fields) names += " " + field.name;
  throw Error("there is no array '" + options.array + "'; this kind has" + names);
}

}  // namespace

void makeVolume(const std::vector<Field>& all, const Options& options) {
  const std::vector<Field> fields = chosenFields(all, options);
  if (extensionOf(options.out) == ".vtu") return makeCells(fields.front(), options);
  if (options.cells != Options().cells || options.displacement != 0)
    throw Error(options.out + ": --cells and --displacement were given, expected a .vtu");
  Grid grid;
  grid.points = options.resolution;
  for (int a = 0; a < 3; ++a) {
    grid.origin[a] = -1;
    grid.spacing[a] = 2.0 / double(std::max(grid.points[size_t(a)] - 1, int64_t(1)));
  }
  std::vector<ArrayInfo> arrays;
  for (const Field& field : fields) arrays.push_back({field.name, ScalarType::Float32, 1, {}});

  const int steps = std::max(options.steps, 1);
  Progress progress("making " + options.out, grid.points[2] * steps);
  for (int step = 0; step < steps; ++step) {
    const VolumeWriter writer(stepName(options, step), grid, arrays);
    const double phase = double(step) / steps;
    parallelFor(int64_t(0), grid.points[2], [&](int64_t k) {
      std::vector<float> slice(size_t(grid.points[0] * grid.points[1]));
      for (size_t f = 0; f < fields.size(); ++f) {
        size_t n = 0;
        for (int64_t j = 0; j < grid.points[1]; ++j)
          for (int64_t i = 0; i < grid.points[0]; ++i)
            slice[n++] = fields[f].value(
                grid.origin + grid.spacing * glm::dvec3(double(i), double(j), double(k)), phase);
        writer.write(f, k, std::as_bytes(std::span(slice)));
      }
      progress.advance();
    });
  }
}

}  // namespace gxy::data_tool
