// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/mesh_heads.h"

#include <cmath>
#include <cstring>

namespace gxy {

namespace {

/// A number whose halves are elements of two arrays.
template <class Whole, class Low, class High>
Whole joinedHalves(const Low* low, const High* high, int i) {
  Whole whole;
  std::memcpy(&whole, low + i, 4);
  std::memcpy(reinterpret_cast<char*>(&whole) + 4, high + i, 4);
  return whole;
}

template <class Whole, class Low, class High>
void writeHalves(Whole whole, Low* low, High* high, int i) {
  std::memcpy(low + i, &whole, 4);
  std::memcpy(high + i, reinterpret_cast<const char*>(&whole) + 4, 4);
}

}  // namespace

MeshHead MeshHead::of(const HeadList& heads, int i) {
  const HeadView& h = heads.view();
  MeshHead head;
  head.key = joinedHalves<uint64_t>(h.cellX, h.cellY, i);
  head.cell = h.cellZ[i];
  head.unplaced = (h.info[i] & HEAD_UNPLACED) != 0;
  head.leaving = int((h.info[i] & HEAD_FACES) >> 12) - 1;
  head.place = {joinedHalves<double>(h.fx, h.gx, i), joinedHalves<double>(h.fy, h.gy, i),
                joinedHalves<double>(h.fz, h.gz, i)};
  head.near = {h.nearX[i], h.nearY[i], h.nearZ[i]};
  head.time = joinedHalves<double>(h.time, h.timeRest, i);
  head.length = joinedHalves<double>(h.length, h.lengthRest, i);
  head.step = h.step[i];
  head.steps = h.steps[i], head.points = h.points[i], head.stalled = h.stalled[i];
  head.way = h.way[i];
  head.fresh = h.fresh[i] != 0;
  return head;
}

void MeshHead::writeTo(const HeadList& heads, int i) const {
  const HeadView& h = heads.view();
  writeHalves(key, h.cellX, h.cellY, i);
  h.cellZ[i] = cell;
  h.info[i] &= HEAD_LINE_HIGH | HEAD_BACKWARD;
  if (unplaced) h.info[i] |= HEAD_UNPLACED;
  if (leaving >= 0) h.info[i] |= HEAD_FACE(uint32_t(leaving));
  writeHalves(place.x, h.fx, h.gx, i);
  writeHalves(place.y, h.fy, h.gy, i);
  writeHalves(place.z, h.fz, h.gz, i);
  h.nearX[i] = near.x, h.nearY[i] = near.y, h.nearZ[i] = near.z;
  writeHalves(time, h.time, h.timeRest, i);
  writeHalves(length, h.length, h.lengthRest, i);
  h.step[i] = step;
  h.steps[i] = steps, h.points[i] = points, h.stalled[i] = stalled;
  h.way[i] = way;
  h.fresh[i] = fresh ? 1 : 0;
}

const char* wrongInMesh(const HeadList& heads) {
  for (int i = 0; i < heads.size(); i++) {
    if (heads.view().info[i] & ~(HEAD_LINE_HIGH | HEAD_BACKWARD | HEAD_UNPLACED | HEAD_FACES))
      return "a head of a line has unknown flags";
    const MeshHead h = MeshHead::of(heads, i);
    if (h.cell != -1) return "a head of a line says where its cell is, which only this rank knows";
    if (h.unplaced == (h.leaving >= 0)) return "a head of a line is neither a seed nor does it leave a cell";
    for (int a = 0; a < 3; a++) {
      if (!std::isfinite(h.place[a]) || !std::isfinite(h.near[a])) return "a head of a line is nowhere";
      if (!h.unplaced && !(h.place[a] >= 0 && h.place[a] <= 1)) return "a head of a line is outside its cell";
    }
    for (const double x : {h.time, h.length, double(h.way)})
      if (!(x >= 0 && std::isfinite(x))) return "a head of a line has a time or a length below 0";
    if (!(h.step > 0 && h.step <= 1)) return "a head of a line has a step that is not in (0, 1]";
    if (const char* wrong = wrongCountsOf(heads, i)) return wrong;
  }
  return nullptr;
}

}  // namespace gxy
