// SPDX-License-Identifier: Apache-2.0
// An array that copies share.
#pragma once
#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace gxy {

/// Its elements never change, so that copies have the same ones in memory, however many there are. Any thread may read it.
template <class T>
class SharedVector {
 public:
  using value_type = T;

  SharedVector() = default;
  SharedVector(std::vector<T> values)
      : values_(std::make_shared<const std::vector<T>>(std::move(values))), all_(*values_) {}

  size_t size() const { return all_.size(); }
  bool empty() const { return all_.empty(); }
  const T* data() const { return all_.data(); }
  const T* begin() const { return all_.data(); }
  const T* end() const { return all_.data() + all_.size(); }
  const T& operator[](size_t i) const { return all_[i]; }
  const T& front() const { return all_.front(); }
  const T& back() const { return all_.back(); }

  /// Whether both have the same elements in memory, not just equal ones.
  bool sharesWith(const SharedVector& other) const {
    return data() == other.data() && size() == other.size();
  }
  bool operator==(const SharedVector& other) const {
    return sharesWith(other) || std::equal(begin(), end(), other.begin(), other.end());
  }

 private:
  std::shared_ptr<const std::vector<T>> values_;
  std::span<const T> all_;
};

}  // namespace gxy
