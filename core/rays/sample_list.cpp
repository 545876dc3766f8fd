// SPDX-License-Identifier: Apache-2.0
#include "core/rays/sample_list.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

#include "core/comm/error_text.h"

namespace gxy {

namespace {

template <class T>
void appendTo(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

template <class T>
void selectFrom(std::vector<T>& all, const std::vector<uint32_t>& which) {
  if (all.empty()) return;
  std::vector<T> kept;
  kept.reserve(which.size());
  for (const uint32_t i : which) kept.push_back(all[i]);
  all = std::move(kept);
}

}  // namespace

int64_t SampleList::bytesPerSample(int fields, bool gradient) {
  return int64_t(sizeof(uint64_t) + 3 * sizeof(uint32_t) + sizeof(float) + sizeof(glm::dvec3)) +
         fields * int64_t(sizeof(float)) + (gradient ? int64_t(sizeof(glm::vec3)) : 0);
}

void SampleList::append(SampleList&& other) {
  if (other.empty()) return;
  if (empty()) {
    *this = std::move(other);
    return;
  }
  appendTo(ray, other.ray);
  appendTo(hit, other.hit);
  appendTo(depth, other.depth);
  appendTo(surface, other.surface);
  appendTo(t, other.t);
  appendTo(position, other.position);
  for (size_t f = 0; f < values.size(); f++) appendTo(values[f], other.values[f]);
  appendTo(gradient, other.gradient);
  appendTo(met, other.met);
}

void SampleList::select(const std::vector<uint32_t>& which) {
  selectFrom(ray, which);
  selectFrom(hit, which);
  selectFrom(depth, which);
  selectFrom(surface, which);
  selectFrom(t, which);
  selectFrom(position, which);
  for (auto& one : values) selectFrom(one, which);
  selectFrom(gradient, which);
  selectFrom(met, which);
}

void TakenSamples::append(TakenSamples&& other) {
  list.append(std::move(other.list));
  std::move(other.memory.begin(), other.memory.end(), std::back_inserter(memory));
  if (refused.empty()) refused = std::move(other.refused);
}

bool TakenSamples::enter(const EnterMemory& enter, bool whole) {
  const int64_t steps = (list.bytes() + (whole ? kStep - 1 : 0)) / kStep;
  try {
    while (refused.empty() && int64_t(memory.size()) < steps) memory.push_back(enter("samples", kStep));
  } catch (const std::exception& e) {
    refused = textOf(e);
  }
  return refused.empty();
}

}  // namespace gxy
