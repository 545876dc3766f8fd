// SPDX-License-Identifier: Apache-2.0
#include "tests/insitu/catalyst/recorder.h"

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

}  // namespace

gxy_sim& recorded() {
  static gxy_sim sim;
  return sim;
}

}  // namespace gxy::test

gxy_sim* gxy_open(const char* name, int rank, int ranks, const char* options) {
  gxy_sim& sim = gxy::test::recorded();
  sim = {};
  sim.name = name, sim.options = options, sim.rank = rank, sim.ranks = ranks;
  if (sim.options == R"({"to": "off"})") sim.published = GXY_OFF;
  return &sim;
}

int gxy_statistics(gxy_sim* sim, gxy_stat* statistics) {
  *statistics = {};
  if (sim->options[0] == '{') return GXY_TAKEN;
  sim->message = "expected a JSON object";
  return GXY_WRONG;
}

int gxy_grid(gxy_sim* sim, const char* mesh, int block, int of, const int64_t size[3], const int64_t first[3],
             const int64_t count[3], const double origin[3], const double spacing[3]) {
  gxy_sim::Grid grid{of, {}, {}, {}, {}, {}};
  for (size_t a = 0; a < 3; a++) {
    grid.size[a] = size[a], grid.first[a] = first[a], grid.count[a] = count[a];
    grid.origin[a] = origin[a], grid.spacing[a] = spacing[a];
    if (size[a] < (of == GXY_OF_POINTS ? 2 : 1) || first[a] < 0 || count[a] < 0 ||
        first[a] + count[a] > size[a]) {
      sim->message = "expected a block inside the grid";
      return GXY_WRONG;
    }
  }
  sim->grids[{mesh, block}] = grid;
  return GXY_TAKEN;
}

int gxy_points(gxy_sim* sim, const char* mesh, int64_t count, gxy_array positions, gxy_array ids,
               const double box[6]) {
  const auto known = sim->points.find(mesh);
  if ((known == sim->points.end() && !sim->steps.empty()) || positions.components != 3) {
    sim->message = "wrong points";
    return GXY_WRONG;
  }
  sim->points[mesh] = {positions, ids, box ? std::vector<double>(box, box + 6) : std::vector<double>()};
  sim->grids[{mesh, 0}] = {GXY_OF_POINTS, {}, {}, {count, 1, 1}, {}, {}};
  return GXY_TAKEN;
}

int gxy_field(gxy_sim* sim, const char* mesh, int block, const char* field, int, gxy_array values) {
  const auto before = sim->fields.find({mesh, block, field});
  if (values.components > 16 || (before != sim->fields.end() && before->second.type != values.type) ||
      (before == sim->fields.end() && !sim->steps.empty())) {
    sim->message = "a wrong field";
    return GXY_WRONG;
  }
  sim->fields[{mesh, block, field}] = values;
  return GXY_TAKEN;
}

int gxy_publish(gxy_sim* sim, int64_t step, double time) {
  if (sim->published == GXY_LOST) sim->message = "there is no connection";
  if (sim->published != GXY_TAKEN) return sim->published;
  if (sim->grids.empty()) return GXY_WRONG;
  for (const auto& [key, array] : sim->fields)
    sim->read[key] = gxy::test::valuesOf(array, sim->grids.at({std::get<0>(key), std::get<1>(key)}).count);
  for (auto& [mesh, points] : sim->points) {
    const auto& count = sim->grids.at({mesh, 0}).count;
    points.at = gxy::test::valuesOf(points.positions, count);
    points.numbers = points.ids.components ? gxy::test::valuesOf(points.ids, count) : std::vector<double>();
  }
  sim->steps.emplace_back(step, time);
  return GXY_TAKEN;
}

int gxy_skip(gxy_sim* sim, int64_t step, double time) {
  if (sim->published == GXY_TAKEN) sim->skipped.emplace_back(step, time);
  return sim->published;
}

int gxy_publish_last(gxy_sim* sim, int64_t step, double time) {
  sim->last = true;
  return gxy_publish(sim, step, time);
}

const char* gxy_message(gxy_sim* sim) { return sim->message.c_str(); }

void gxy_close(gxy_sim* sim, double seconds) { sim->closed = seconds; }
