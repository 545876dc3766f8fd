// SPDX-License-Identifier: Apache-2.0
#include "tests/insitu/simsim_stand_in.h"

namespace gxy::test {
namespace {

size_t bytesOfType(int type) {
  constexpr std::array<size_t, 10> bytes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return bytes.at(size_t(type));
}

std::vector<std::byte> valuesOf(const gxy_array& array, const std::array<int64_t, 3>& count) {
  const size_t point = bytesOfType(array.type) * size_t(array.components);
  const auto* data = static_cast<const std::byte*>(array.data);
  std::vector<std::byte> values;
  for (int64_t k = 0; k < count[2]; ++k)
    for (int64_t j = 0; j < count[1]; ++j)
      for (int64_t i = 0; i < count[0]; ++i) {
        const std::byte* at = data + i * array.stride[0] + j * array.stride[1] + k * array.stride[2];
        values.insert(values.end(), at, at + point);
      }
  return values;
}

}  // namespace

StandIn& standIn() {
  static StandIn all;
  return all;
}

}  // namespace gxy::test

using gxy::test::standIn;

gxy_sim* gxy_open(const char* name, int rank, int ranks, const char* options) {
  gxy_sim& side = standIn().sides[rank];
  side = {};
  side.name = name;
  side.options = options;
  side.rank = rank;
  side.ranks = ranks;
  return &side;
}

int gxy_grid(gxy_sim* sim, const char*, int, int, const int64_t size[3], const int64_t first[3],
             const int64_t count[3], const double origin[3], const double spacing[3]) {
  for (size_t a = 0; a < 3; ++a) {
    sim->size[a] = size[a];
    sim->first[a] = first[a];
    sim->count[a] = count[a];
    sim->origin[a] = origin[a];
    sim->spacing[a] = spacing[a];
  }
  return standIn().gridResult;
}

int gxy_field(gxy_sim* sim, const char*, int, const char* field, int, gxy_array values) {
  sim->fields[field] = values;
  return GXY_TAKEN;
}

int gxy_publish(gxy_sim* sim, int64_t step, double time) {
  gxy_sim::Step taken{step, time, {}};
  for (const auto& [name, array] : sim->fields) taken.read[name] = gxy::test::valuesOf(array, sim->count);
  sim->steps.push_back(taken);
  return standIn().publishResult;
}

const char* gxy_message(gxy_sim* sim) { return sim->message.c_str(); }

void gxy_close(gxy_sim* sim, double seconds) {
  if (sim) sim->closed = seconds;
}
