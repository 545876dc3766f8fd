// SPDX-License-Identifier: Apache-2.0
#include "core/space/payload.h"

#include <cxxabi.h>

#include <cstdlib>
#include <string>

#include "core/comm/error.h"

namespace gxy {
namespace {

std::string readable(const std::type_info& type) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(type.name(), nullptr, nullptr, &status), &std::free);
  return status == 0 ? name.get() : type.name();
}

}  // namespace

void Payload::failType(const std::type_info& expected) const {
  throw Error("object: it holds " + (empty() ? "nothing" : "a " + readable(*type_)) + ", expected a " +
              readable(expected));
}

}  // namespace gxy
