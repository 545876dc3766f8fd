// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/cell_arrays.h"

#include <algorithm>
#include <cstring>
#include <span>

#include "core/comm/error.h"
#include "core/data/scalar.h"
#include "insitu/plan/cells.h"

namespace gxy::insitu {

namespace {

// Calls use(i, value) for `count` integers of an array from `begin` on. Values beyond 64 bits with a sign are negative.
template <class Use>
void eachInteger(const gxy_array& array, int64_t begin, uint64_t count, const Use& use) {
  withType(ScalarType(array.type), [&](auto value) {
    const std::byte* at = static_cast<const std::byte*>(array.data) + begin * array.stride[0];
    for (uint64_t i = 0; i < count; i++, at += array.stride[0]) {
      std::memcpy(&value, at, sizeof value);
      use(i, int64_t(value));
    }
  });
}

template <class T>
void put(std::byte* to, uint64_t i, T value) {
  std::memcpy(to + i * sizeof value, &value, sizeof value);
}

uint32_t place(int64_t value) { return value < 0 || value >= int64_t(kNoPlace) ? kNoPlace : uint32_t(value); }

bool isInteger(const gxy_array& a, bool ofAnySize) {
  return a.components == 1 && a.type >= (ofAnySize ? GXY_INT8 : GXY_INT32) && a.type <= GXY_UINT64;
}

std::string found(const gxy_array& a) {
  return "type " + std::to_string(a.type) + " and " + std::to_string(a.components) + " components";
}

void checkIntegers(const std::string& what, const gxy_array& a, uint64_t count, const std::string& first) {
  if (a.memory != 0)
    throw Error(what + ": memory " + std::to_string(a.memory) + ", expected 0, the memory of the host");
  if (count > 0 && !a.data) throw Error(what + ": there are no data, expected a pointer to " + first);
  if (count > 1 && a.stride[0] == 0)
    throw Error(what + ": stride[0] is 0, expected the bytes from one to the next");
}

}  // namespace

void CellArrays::describe(const std::string& what) {
  if (!isInteger(types, true))
    throw Error(what + ", types: " + found(types) +
                ", expected one integer for each cell, or one for all with a stride of 0");
  const bool isOne = types.stride[0] == 0;
  checkIntegers(what + ", types", types, isOne ? std::min<uint64_t>(count, 1) : count,
                "the type of the first cell");
  allOf = 0;
  if (isOne && types.data) {
    eachInteger(types, 0, 1, [&](uint64_t, int64_t type) {
      allOf = type < 0 || type > 255 ? 255 : int(type);
      shapeOf(allOf, what);
    });
  }
  const bool hasOffsets = offsets.components != 0;
  if (hasOffsets && !isInteger(offsets, false))
    throw Error(what + ", offsets: " + found(offsets) +
                ", expected one integer of 32 or 64 bits, or 0 components for none");
  if (!hasOffsets && count > 0 && (allOf == 0 || pointsOfEach(allOf) == 0))
    throw Error(what +
                ", offsets: there are none, expected cells + 1 of them unless all cells are said to be of "
                "one type with a "
                "fixed number of points: lines (3), triangles (5), pixels, quads (8, 9), or cells with a "
                "volume (10 to 14)");
  if (hasOffsets)
    checkIntegers(what + ", offsets", offsets, count > 0 ? count + 1 : 0, "that of the first cell");
  if (!isInteger(connectivity, false))
    throw Error(what + ", connectivity: " + found(connectivity) +
                ", expected one integer of 32 or 64 bits for each point of each cell");
  if (!hasOffsets && count > 0 && count * pointsOfEach(allOf) > kMostParticles)
    throw Error(what +
                ": the cells of this rank have more than 2^32 - 2 points together, expected at most as many");
  checkIntegers(what + ", connectivity", connectivity, count > 0 ? 2 : 0,
                "the first point of the first cell");
}

Mesh::Shape CellArrays::shape() const {
  if (allOf == 0) return Mesh::Shape::Unknown;
  return shapeOf(allOf, "cells");  // It was checked when they were described.
}

uint64_t CellArrays::corners() const {
  if (count == 0) return 0;
  if (offsets.components == 0) return count * pointsOfEach(allOf);
  int64_t begin = 0, end = 0;
  bool isRight = true;
  eachInteger(offsets, 0, count + 1, [&](uint64_t i, int64_t offset) {
    if (i == 0) begin = end = offset;
    isRight = isRight && begin >= 0 && offset >= end && place(offset - begin) != kNoPlace;
    end = offset;
  });
  return isRight ? uint64_t(end - begin) : 0;
}

void CellArrays::copyTypes(std::byte* to) const {
  if (allOf != 0) {
    std::fill_n(to, count, std::byte(allOf));
    return;
  }
  // A type beyond 8 bits is none that is taken.
  eachInteger(types, 0, count, [&](uint64_t i, int64_t type) {
    put(to, i, type < 0 || type > 255 ? uint8_t(255) : uint8_t(type));
  });
}

void CellArrays::copyEnds(std::byte* to) const {
  if (count == 0) return;
  if (offsets.components == 0) {
    const size_t each = pointsOfEach(allOf);
    for (uint64_t c = 0; c < count; c++) put(to, c, uint32_t((c + 1) * each));
    return;
  }
  int64_t begin = 0, before = 0;
  eachInteger(offsets, 0, count + 1, [&](uint64_t i, int64_t offset) {
    if (i == 0)
      begin = before = offset;
    else
      put(to, i - 1, begin < 0 || offset < before ? kNoPlace : place(offset - begin));
    before = offset;
  });
}

void CellArrays::copyConnectivity(uint64_t corners, std::byte* to) const {
  if (corners == 0) return;
  int64_t begin = 0;
  if (offsets.components != 0) eachInteger(offsets, 0, 1, [&](uint64_t, int64_t offset) { begin = offset; });
  eachInteger(connectivity, begin, corners, [&](uint64_t i, int64_t point) { put(to, i, place(point)); });
}

Mesh::Shape CellArrays::checked(const std::string& what, uint64_t points,
                                const std::function<glm::dvec3(size_t point)>& position) const {
  std::vector<uint8_t> types(count);
  std::vector<uint32_t> ends(count), connectivity(corners());
  copyTypes(std::as_writable_bytes(std::span(types)).data());
  copyEnds(std::as_writable_bytes(std::span(ends)).data());
  copyConnectivity(connectivity.size(), std::as_writable_bytes(std::span(connectivity)).data());
  return check({points, types, ends, connectivity}, shape(), what, position);
}

void CellArrays::keep(std::vector<std::vector<std::byte>>& memory) {
  if (count == 0) return;
  const uint64_t kept = corners();
  const auto make = [&](size_t bytes) {
    memory.emplace_back(bytes);
    return memory.back().data();
  };
  // As they are sent: the types, the begin of the first cell and the ends of all, and the corners.
  std::byte *const newTypes = make(count), *const newOffsets = make((count + 1) * sizeof(uint32_t)),
                   *const newConnectivity = make(kept * sizeof(uint32_t));
  copyTypes(newTypes);
  put(newOffsets, 0, uint32_t(0));
  copyEnds(newOffsets + sizeof(uint32_t));
  copyConnectivity(kept, newConnectivity);
  allOf = 0;
  types = {newTypes, GXY_UINT8, 1, {1, 0, 0}, 0, 0};
  offsets = {newOffsets, GXY_UINT32, 1, {sizeof(uint32_t), 0, 0}, 0, 0};
  connectivity = {newConnectivity, GXY_UINT32, 1, {sizeof(uint32_t), 0, 0}, 0, 0};
}

void copyIds(const gxy_array& ids, uint64_t count, std::byte* to) {
  eachInteger(ids, 0, count, [&](uint64_t i, int64_t id) { put(to, i, uint64_t(id)); });
}

}  // namespace gxy::insitu
