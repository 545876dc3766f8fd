// SPDX-License-Identifier: Apache-2.0
#include "core/rays/path_points.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace gxy {

namespace {

template <class T>
void appendTo(std::vector<T>& to, std::vector<T>&& from) {
  if (to.empty())
    to = std::move(from);
  else
    to.insert(to.end(), from.begin(), from.end());
}

template <class T>
void reorder(std::vector<T>& v, const std::vector<size_t>& order) {
  std::vector<T> sorted;
  sorted.reserve(order.size());
  for (size_t i : order) sorted.push_back(v[i]);
  v = std::move(sorted);
}

template <class T>
int64_t bytesIn(const std::vector<T>& v) {
  return int64_t(v.capacity() * sizeof(T));
}

}  // namespace

int64_t PathPoints::bytes() const {
  int64_t n =
      bytesIn(line) + bytesIn(number) + bytesIn(position) + bytesIn(time) + bytesIn(length) + bytesIn(speed);
  for (const auto& v : values) n += bytesIn(v);
  return n;
}

void PathPoints::resize(size_t points, size_t components) {
  line.resize(points);
  number.resize(points);
  position.resize(points);
  time.resize(points);
  length.resize(points);
  speed.resize(points);
  values.resize(components);
  for (auto& v : values) v.resize(points);
}

void PathPoints::append(PathPoints&& other) {
  if (values.empty()) values.resize(other.values.size());
  appendTo(line, std::move(other.line));
  appendTo(number, std::move(other.number));
  appendTo(position, std::move(other.position));
  appendTo(time, std::move(other.time));
  appendTo(length, std::move(other.length));
  appendTo(speed, std::move(other.speed));
  for (size_t k = 0; k < values.size() && k < other.values.size(); k++)
    appendTo(values[k], std::move(other.values[k]));
}

void PathPoints::sort() {
  std::vector<size_t> order(size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return line[a] != line[b] ? line[a] < line[b] : number[a] < number[b];
  });
  reorder(line, order);
  reorder(number, order);
  reorder(position, order);
  reorder(time, order);
  reorder(length, order);
  reorder(speed, order);
  for (auto& v : values) reorder(v, order);
}

const char* nameOf(EndReason reason) {
  constexpr const char* kNames[kEndReasons] = {"left",    "time",      "length", "steps", "slow",
                                               "no data", "condition", "closed", "stuck", "outside"};
  return kNames[size_t(reason)];
}

}  // namespace gxy
