// SPDX-License-Identifier: Apache-2.0
#include "tests/insitu/catalyst/recorder.h"

#include <dlfcn.h>

#include <cstring>

namespace gxy::test {
namespace {

double valueAt(const std::byte* at, int type) {
  const auto as = [at](auto value) {
    std::memcpy(&value, at, sizeof value);
    return double(value);
  };
  switch (type) {
    case GXY_INT8:
      return as(int8_t());
    case GXY_UINT8:
      return as(uint8_t());
    case GXY_INT16:
      return as(int16_t());
    case GXY_UINT16:
      return as(uint16_t());
    case GXY_INT32:
      return as(int32_t());
    case GXY_UINT32:
      return as(uint32_t());
    case GXY_INT64:
      return as(int64_t());
    case GXY_UINT64:
      return as(uint64_t());
    case GXY_FLOAT32:
      return as(float());
    default:
      return as(double());
  }
}

std::vector<double> valuesOf(const gxy_array& a, const std::array<int64_t, 3>& count) {
  std::vector<double> values;
  const auto* data = static_cast<const std::byte*>(a.data);
  for (int64_t k = 0; k < count[2]; k++)
    for (int64_t j = 0; j < count[1]; j++)
      for (int64_t i = 0; i < count[0]; i++)
        for (int c = 0; c < a.components; c++)
          values.push_back(valueAt(
              data + i * a.stride[0] + j * a.stride[1] + k * a.stride[2] + c * a.component_stride, a.type));
  return values;
}

// The function of libgalaxy_insitu, which checks what is recorded.
#define REAL(function) reinterpret_cast<decltype(&(function))>(dlsym(library(), #function))

void* library() {
  static void* loaded = dlopen("libgalaxy_insitu.so.1", RTLD_LAZY | RTLD_NOLOAD);
  return loaded;
}

bool isWrong(gxy_sim* sim, int result) {
  sim->message = result == GXY_WRONG ? REAL(gxy_message)(sim->checks) : "";
  return result == GXY_WRONG;
}

}  // namespace

gxy_sim& recorded() {
  static gxy_sim sim;
  return sim;
}

}  // namespace gxy::test

using namespace gxy::test;

gxy_sim* gxy_open(const char* name, int rank, int ranks, const char* options) {
  gxy_sim& sim = recorded();
  sim = {};
  sim.name = name, sim.options = options, sim.rank = rank, sim.ranks = ranks;
  const char* nowhere = R"({"to": "127.0.0.1:1", "token-file": "-", "reconnect": 0})";
  sim.checks = REAL(gxy_open)(name, rank, ranks, sim.options == "{}" ? nowhere : options);
  return &sim;
}

int gxy_statistics(gxy_sim* sim, gxy_stat* statistics) {
  return isWrong(sim, REAL(gxy_statistics)(sim->checks, statistics)) ? GXY_WRONG : GXY_TAKEN;
}

int gxy_grid(gxy_sim* sim, const char* mesh, int block, int of, const int64_t size[3], const int64_t first[3],
             const int64_t count[3], const double origin[3], const double spacing[3]) {
  if (isWrong(sim, REAL(gxy_grid)(sim->checks, mesh, block, of, size, first, count, origin, spacing)))
    return GXY_WRONG;
  gxy_sim::Grid grid{of, {}, {}, {}, {}, {}};
  for (size_t a = 0; a < 3; a++) {
    grid.size[a] = size[a], grid.first[a] = first[a], grid.count[a] = count[a];
    grid.origin[a] = origin[a], grid.spacing[a] = spacing[a];
  }
  sim->grids[{mesh, block}] = grid;
  return GXY_TAKEN;
}

int gxy_points(gxy_sim* sim, const char* mesh, int64_t count, gxy_array positions, gxy_array ids,
               const double box[6]) {
  if (isWrong(sim, REAL(gxy_points)(sim->checks, mesh, count, positions, ids, box))) return GXY_WRONG;
  sim->points[mesh] = {positions, ids, box ? std::vector<double>(box, box + 6) : std::vector<double>()};
  sim->grids[{mesh, 0}] = {GXY_OF_POINTS, {}, {}, {count, 1, 1}, {}, {}};
  return GXY_TAKEN;
}

int gxy_cells(gxy_sim* sim, const char* mesh, int64_t points, gxy_array positions, int64_t cells,
              gxy_array types, gxy_array offsets, gxy_array connectivity) {
  if (isWrong(sim,
              REAL(gxy_cells)(sim->checks, mesh, points, positions, cells, types, offsets, connectivity)))
    return GXY_WRONG;
  const std::map<int, int> pointsOf{{GXY_LINE, 2},        {GXY_TRIANGLE, 3},   {GXY_QUAD, 4},
                                    {GXY_TETRAHEDRON, 4}, {GXY_HEXAHEDRON, 8}, {GXY_WEDGE, 6},
                                    {GXY_PYRAMID, 5}};
  gxy_sim::Points& of = sim->points[mesh] = {positions, {}, {}};
  of.connectivity = connectivity, of.types = types, of.offsets = offsets, of.cells = cells;
  if (offsets.components == 0)
    of.pointsOfEach = pointsOf.at(int(valueAt(static_cast<const std::byte*>(types.data), types.type)));
  sim->grids[{mesh, 0}] = {GXY_OF_POINTS, {}, {}, {points, 1, 1}, {}, {}};
  return GXY_TAKEN;
}

int gxy_field(gxy_sim* sim, const char* mesh, int block, const char* field, int of, gxy_array values) {
  if (isWrong(sim, REAL(gxy_field)(sim->checks, mesh, block, field, of, values))) return GXY_WRONG;
  sim->fields[{mesh, block, field}] = values;
  if (of == GXY_OF_CELLS && sim->points.count(mesh)) sim->ofCells[mesh].insert(field);
  return GXY_TAKEN;
}

int gxy_publish(gxy_sim* sim, int64_t step, double time) {
  const int result = (sim->last ? REAL(gxy_publish_last) : REAL(gxy_publish))(sim->checks, step, time);
  if (isWrong(sim, result) || result == GXY_OFF) return result;
  if (sim->published == GXY_LOST) {
    sim->message = "there is no connection";
    return GXY_LOST;
  }
  for (const auto& [key, array] : sim->fields) {
    const auto& [mesh, block, field] = key;
    const auto ofCells = sim->ofCells.find(mesh);
    const bool isOfCells = ofCells != sim->ofCells.end() && ofCells->second.count(field) > 0;
    sim->read[key] = valuesOf(array, isOfCells ? std::array<int64_t, 3>{sim->points.at(mesh).cells, 1, 1}
                                               : sim->grids.at({mesh, block}).count);
  }
  for (auto& [mesh, points] : sim->points) {
    const auto& count = sim->grids.at({mesh, 0}).count;
    points.at = valuesOf(points.positions, count);
    const bool hasOffsets = points.offsets.components != 0 && points.cells > 0;
    points.begins = valuesOf(points.offsets, {hasOffsets ? points.cells + 1 : 0, 1, 1});
    points.kinds = valuesOf(points.types, {points.cells, 1, 1});
    const int64_t corners = hasOffsets ? int64_t(points.begins.back()) : points.cells * points.pointsOfEach;
    points.corners = valuesOf(points.connectivity, {corners, 1, 1});
    points.numbers = points.ids.components ? valuesOf(points.ids, count) : std::vector<double>();
  }
  sim->steps.emplace_back(step, time);
  return GXY_TAKEN;
}

int gxy_skip(gxy_sim* sim, int64_t step, double time) {
  if (isWrong(sim, REAL(gxy_skip)(sim->checks, step, time))) return GXY_WRONG;
  sim->skipped.emplace_back(step, time);
  return GXY_TAKEN;
}

int gxy_publish_last(gxy_sim* sim, int64_t step, double time) {
  sim->last = true;
  return gxy_publish(sim, step, time);
}

const char* gxy_message(gxy_sim* sim) { return sim->message.c_str(); }

void gxy_close(gxy_sim* sim, double seconds) {
  sim->closed = seconds;
  REAL(gxy_close)(sim->checks, 0);
}
