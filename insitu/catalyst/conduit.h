// SPDX-License-Identifier: Apache-2.0
// Reads the nodes of Conduit that a simulation hands to Catalyst. Nothing of Conduit is needed to build this: nodes are opaque,
// they belong to the Conduit that the simulation uses, and its C functions, a promised binary interface, are found in the
// process at run time.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

struct conduit_node_impl;  // Conduit's own names; nobody else knows what is in them
struct conduit_datatype_impl;

namespace gxy::catalyst {

/// The functions of Conduit that are used.
struct Conduit {
  int (*nodeHasPath)(const conduit_node_impl*, const char*);
  conduit_node_impl* (*nodeFetchExisting)(conduit_node_impl*,
                                          const char*);  // an error where there is no such path
  int64_t (*nodeNumberOfChildren)(conduit_node_impl*);
  conduit_node_impl* (*nodeChild)(conduit_node_impl*, int64_t);
  char* (*nodeName)(const conduit_node_impl*);  // the caller frees it
  const conduit_datatype_impl* (*nodeDtype)(const conduit_node_impl*);
  void* (*nodeElementPtr)(conduit_node_impl*, int64_t);
  void (*nodeSetPathChar8Str)(conduit_node_impl*, const char*, const char*);
  int64_t (*typeId)(const conduit_datatype_impl*);
  int64_t (*typeNumberOfElements)(const conduit_datatype_impl*);
  int64_t (*typeStride)(const conduit_datatype_impl*);  // in bytes
  int (*typeEndiannessMatchesMachine)(const conduit_datatype_impl*);
};

/// The functions, looked for in the process and in libcatalyst.so.3 where that is loaded. Throws std::runtime_error.
const Conduit& conduit();

/// The numbers of a node, in the memory of the simulation.
struct Array {
  const std::byte* data = nullptr;  ///< the first one; may be null where there are none
  int type = 0;                     ///< gxy_type
  int64_t count = 0;
  int64_t stride = 0;  ///< bytes from one to the next
};
size_t bytesOf(int type);

/// A node and its path, for messages. Functions that expect something throw std::runtime_error with the path.
class Node {
 public:
  Node(conduit_node_impl* node, std::string path) : node_(node), path_(std::move(path)) {}
  const std::string& path() const { return path_; }

  std::optional<Node> find(const std::string& path) const;
  Node at(const std::string& path) const;
  std::vector<Node> children() const;
  /// The last name of the path.
  std::string name() const { return path_.substr(path_.rfind('/') + 1); }

  bool isText() const;
  bool isNumbers() const;
  std::string text() const;
  Array array() const;
  double number() const;
  int64_t integer() const;
  /// So many numbers: those of an array, or one of each child.
  std::vector<double> numbers(size_t count) const;

  /// The integer or number at a path, or what holds without it.
  int64_t integerOr(const std::string& path, int64_t otherwise) const;
  double numberOr(const std::string& path, double otherwise) const;

 private:
  [[noreturn]] void expected(const std::string& what) const;
  int64_t typeId() const;

  conduit_node_impl* node_;
  std::string path_;
};

}  // namespace gxy::catalyst
