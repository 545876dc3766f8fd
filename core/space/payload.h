// SPDX-License-Identifier: Apache-2.0
// The value of an object in the data space: immutable, shared, and of any type.
#pragma once
#include <memory>
#include <typeinfo>

namespace gxy {

/// A shared pointer to an immutable value that remembers its type. Copies share the value.
class Payload {
 public:
  Payload() = default;
  template <typename T>
  explicit Payload(std::shared_ptr<const T> value) : value_(std::move(value)), type_(&typeid(T)) {}

  bool empty() const { return value_ == nullptr; }

  /// Returns the value. Throws Error with both types if the value has another type or there is none.
  template <typename T>
  std::shared_ptr<const T> get() const {
    if (empty() || *type_ != typeid(T)) failType(typeid(T));
    return std::static_pointer_cast<const T>(value_);
  }

 private:
  [[noreturn]] void failType(const std::type_info& expected) const;

  std::shared_ptr<const void> value_;
  const std::type_info* type_ = &typeid(void);
};

template <typename T, typename... Arguments>
Payload makePayload(Arguments&&... arguments) {
  return Payload(std::shared_ptr<const T>(std::make_shared<const T>(std::forward<Arguments>(arguments)...)));
}

}  // namespace gxy
