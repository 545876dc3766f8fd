// SPDX-License-Identifier: Apache-2.0
#include "insitu/catalyst/conduit.h"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "insitu/api/galaxy_insitu.h"

namespace gxy::catalyst {

namespace {

// The ids of Conduit's types.
constexpr int64_t kInt8 = 3, kInt64 = 6, kUint8 = 7, kUint64 = 10, kFloat32 = 11, kFloat64 = 12, kText = 13;

// The gxy_type of a type of Conduit, or -1 where it is not one of numbers.
int typeOf(int64_t id) {
  if (id >= kInt8 && id <= kInt64) return GXY_INT8 + 2 * int(id - kInt8);
  if (id >= kUint8 && id <= kUint64) return GXY_UINT8 + 2 * int(id - kUint8);
  return id == kFloat32 ? GXY_FLOAT32 : id == kFloat64 ? GXY_FLOAT64 : -1;
}

// All functions with one prefix, so that they are of one Conduit.
bool lookUp(void* where, const std::string& prefix, Conduit& c) {
  const auto look = [&](auto& function, const char* name) {
    function =
        reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(where, (prefix + name).c_str()));
    return function != nullptr;
  };
  return look(c.nodeHasPath, "node_has_path") && look(c.nodeFetchExisting, "node_fetch_existing") &&
         look(c.nodeNumberOfChildren, "node_number_of_children") && look(c.nodeChild, "node_child") &&
         look(c.nodeName, "node_name") && look(c.nodeDtype, "node_dtype") &&
         look(c.nodeElementPtr, "node_element_ptr") &&
         look(c.nodeSetPathChar8Str, "node_set_path_char8_str") && look(c.typeId, "datatype_id") &&
         look(c.typeNumberOfElements, "datatype_number_of_elements") &&
         look(c.typeStride, "datatype_stride") &&
         look(c.typeEndiannessMatchesMachine, "datatype_endianness_matches_machine");
}

Conduit found() {
  Conduit functions;
  // A program may have loaded it so that others do not see its symbols. Where it is not loaded, null stands for the process again.
  void* loaded = dlopen("libcatalyst.so.3", RTLD_LAZY | RTLD_NOLOAD);
  // The process may have another Conduit, too.
  for (const char* prefix : {"catalyst_conduit_", "conduit_"})
    for (void* where : {loaded, static_cast<void*>(RTLD_DEFAULT)})
      if (lookUp(where, prefix, functions)) return functions;
  throw std::runtime_error(
      "the functions of Conduit were not found in this process, neither as "
      "catalyst_conduit_node_fetch_existing "
      "nor as conduit_node_fetch_existing and so on, expected a program that uses the shared library "
      "libcatalyst.so.3 "
      "of Catalyst 2");
}

double numberAt(const std::byte* at, int type) {
  const auto as = [at]<class T>(T value) {
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

}  // namespace

const Conduit& conduit() {
  static const Conduit functions = found();  // after a failure, the next call looks again
  return functions;
}

size_t bytesOf(int type) { return type <= GXY_UINT64 ? size_t(1) << type / 2 : type == GXY_FLOAT32 ? 4 : 8; }

void Node::expected(const std::string& what) const { throw std::runtime_error(path_ + ": expected " + what); }

int64_t Node::typeId() const { return conduit().typeId(conduit().nodeDtype(node_)); }

std::optional<Node> Node::find(const std::string& path) const {
  if (!conduit().nodeHasPath(node_, path.c_str())) return {};
  return Node(conduit().nodeFetchExisting(node_, path.c_str()), path_.empty() ? path : path_ + "/" + path);
}

Node Node::at(const std::string& path) const {
  const auto node = find(path);
  if (!node) throw std::runtime_error((path_.empty() ? "" : path_ + ": ") + "there is no " + path);
  return *node;
}

std::vector<Node> Node::children() const {
  std::vector<Node> all;
  const int64_t count = conduit().nodeNumberOfChildren(node_);
  for (int64_t i = 0; i < count; i++) {
    conduit_node_impl* child = conduit().nodeChild(node_, i);
    const std::unique_ptr<char, decltype(&std::free)> name(conduit().nodeName(child), &std::free);
    const bool named = name && *name.get();  // those of lists have no names
    all.emplace_back(child, path_ + "/" + (named ? name.get() : std::to_string(i)));
  }
  return all;
}

bool Node::isText() const { return typeId() == kText; }
bool Node::isNumbers() const { return typeOf(typeId()) >= 0; }

std::string Node::text() const {
  const auto* at = isText() ? static_cast<const char*>(conduit().nodeElementPtr(node_, 0)) : nullptr;
  if (!at) expected("a text");
  return {at, strnlen(at, size_t(conduit().typeNumberOfElements(conduit().nodeDtype(node_))))};
}

Array Node::array() const {
  const conduit_datatype_impl* type = conduit().nodeDtype(node_);
  const int64_t count = conduit().typeNumberOfElements(type);
  Array array{nullptr, typeOf(conduit().typeId(type)), count, conduit().typeStride(type)};
  if (array.type < 0) expected("numbers");
  if (count <= 0) return {nullptr, array.type, 0, array.stride};
  int64_t bytes;
  if (__builtin_mul_overflow(count, array.stride, &bytes)) expected("numbers with another stride");
  if (!conduit().typeEndiannessMatchesMachine(type)) expected("numbers in the byte order of this machine");
  array.data = static_cast<const std::byte*>(conduit().nodeElementPtr(node_, 0));
  if (!array.data) expected("numbers in memory");
  return array;
}

double Node::number() const { return numbers(1)[0]; }

int64_t Node::integer() const {
  const double value = number();
  if (!(std::abs(value) <= 0x1p53) || value != std::floor(value)) expected("an integer");
  return int64_t(value);
}

std::vector<double> Node::numbers(size_t count) const {
  std::vector<double> all;
  const std::string what = count == 1 ? "a number" : std::to_string(count) + " numbers";
  if (isNumbers()) {
    const Array values = array();
    if (values.count != int64_t(count)) expected(what);
    for (size_t i = 0; i < count; i++)
      all.push_back(numberAt(values.data + int64_t(i) * values.stride, values.type));
  } else if (count > 1) {
    for (const Node& child : children()) all.push_back(child.number());
  }
  if (all.size() != count) expected(what);
  return all;
}

int64_t Node::integerOr(const std::string& path, int64_t otherwise) const {
  const auto node = find(path);
  return node ? node->integer() : otherwise;
}

double Node::numberOr(const std::string& path, double otherwise) const {
  const auto node = find(path);
  return node ? node->number() : otherwise;
}

}  // namespace gxy::catalyst
