// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/recorded_fields.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/analysis/field_values.h"
#include "core/comm/error.h"

namespace gxy {

std::string nameOfComponent(const std::string& name, int components, int component) {
  if (components == 1) return name;
  return component < 0 ? "mag(" + name + ")" : name + "." + std::to_string(component);
}

void checkNames(std::span<const FilterSource> sources, const std::string& filter, bool gradient) {
  for (size_t i = 0; i < sources.size(); i++) {
    if (gradient && sources[i].name == kGradientField)
      throw Error(filter + ": among the fields of points is " + inQuotes(kGradientField) +
                  ", as their gradients are called, expected another name or no `gradient`");
    for (size_t k = 0; k < i; k++)
      if (sources[i].name == sources[k].name)
        throw Error(filter + ": " + inQuotes(sources[i].name) +
                    " is there twice among the fields of points, expected different ones");
  }
}

void setField(GeometryBlock& block, PointField field) {
  const auto found = std::find_if(block.fields.begin(), block.fields.end(),
                                  [&](const PointField& f) { return f.name == field.name; });
  if (found == block.fields.end())
    block.fields.push_back(std::move(field));
  else
    *found = std::move(field);
}

std::vector<PointsWithout> recordFields(FilterRun& run, std::span<const FilterSource> sources,
                                        GeometryBlock& block, std::vector<LedgerEntry>& memory) {
  std::vector<PointsWithout> without;
  for (const FilterSource& source : sources) {
    std::vector<int> components(size_t(source.data->components()));
    std::iota(components.begin(), components.end(), 0);
    agree(run.ranks, [&] {
      memory.push_back(
          run.takeMemory("geometry", int64_t(block.points.size() * components.size() * sizeof(float))));
    });
    FieldValues found = ValueReader(run, source).at(components, block.points, run.ranks);
    without.push_back({found.outside, found.noData});
    setField(block, {source.name, int(components.size()), std::move(found.values)});
  }
  return without;
}

namespace {

/// Collective. Takes memory for a field of three components.
void takeThree(FilterRun& run, const GeometryBlock& block, std::vector<LedgerEntry>& memory) {
  agree(run.ranks, [&] {
    memory.push_back(run.takeMemory("geometry", int64_t(block.points.size() * 3 * sizeof(float))));
  });
}

/// Three numbers of a volume's polynomial at each point become a field.
void recordThree(FilterRun& run, const Dataset& of, const char* name, GeometryBlock& block,
                 std::vector<LedgerEntry>& memory,
                 const std::function<glm::dvec3(const FieldReader&, int partition, const GridPlace&)>& read) {
  takeThree(run, block, memory);
  const auto write = [&](const FieldReader& reader, int partition, const GridPlace& place, float* values) {
    const glm::dvec3 three = read(reader, partition, place);
    for (int a = 0; a < 3; a++) values[a] = float(three[a]);
  };
  FieldValues found = readAt(*of.volume, *of.partitioning, 3, write, block.points, run.ranks);
  setField(block, {name, 3, std::move(found.values)});
}

}  // namespace

void recordGradient(FilterRun& run, const Dataset& volume, int component, GeometryBlock& block,
                    std::vector<LedgerEntry>& memory) {
  recordThree(run, volume, kGradientField, block, memory,
              [component](const FieldReader& reader, int partition, const GridPlace& place) {
                return reader.gradient(partition, place, component);
              });
}

void recordVorticity(FilterRun& run, const FilterSource& vectors, GeometryBlock& block,
                     std::vector<LedgerEntry>& memory) {
  const auto curl = [](glm::dvec3 u, glm::dvec3 v, glm::dvec3 w) {
    return glm::dvec3(w.y - v.z, u.z - w.x, v.x - u.y);
  };
  constexpr const char* kName = "vorticity";
  if (vectors.data->volume)
    return recordThree(run, *vectors.data, kName, block, memory,
                       [curl](const FieldReader& reader, int partition, const GridPlace& place) {
                         return curl(reader.gradient(partition, place, 0),
                                     reader.gradient(partition, place, 1),
                                     reader.gradient(partition, place, 2));
                       });
  takeThree(run, block, memory);
  const ReadMeshPlace read = [curl](const Mesh& mesh, const MeshPlace& place, float* values) {
    const glm::dvec3 three =
        curl(gradientAt(mesh, place, 0), gradientAt(mesh, place, 1), gradientAt(mesh, place, 2));
    for (int a = 0; a < 3; a++) values[a] = float(three[a]);
  };
  FieldValues found = ValueReader(run, vectors).inCellsAt(3, read, block.points, run.ranks);
  setField(block, {kName, 3, std::move(found.values)});
}

SampledVolumes sampledVolumes(std::span<const FilterSource> sources, const std::string& filter,
                              bool gradient) {
  checkNames(sources, filter, gradient);
  SampledVolumes all;
  for (const FilterSource& source : sources) {
    const auto& volume = source.data->volume;
    const int n = volume->components;
    if (all.sampled.empty()) {
      all.sampled.push_back({volume, -1});
      all.array = nameOfComponent(source.name, n, -1);
      if (n == 1) continue;
    }
    all.fields.push_back({source.name, n, {}});
    for (int c = 0; c < n; c++) all.sampled.push_back({volume, c});
  }
  if (all.sampled.size() > kMostSampledFields)
    throw Error(filter + ": " + std::to_string(all.sampled.size()) +
                " components of fields are to be recorded, expected at most " +
                std::to_string(kMostSampledFields));
  return all;
}

}  // namespace gxy
