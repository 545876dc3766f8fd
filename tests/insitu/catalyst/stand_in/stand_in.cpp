// SPDX-License-Identifier: Apache-2.0
// The library of stand_in/catalyst.h: a tree of nodes, and the loader of implementations. Where Conduit would call its handler of
// errors, which by default throws, this ends the program, so that a test shows it.
#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <catalyst.h>

struct conduit_datatype_impl;
struct conduit_node_impl {
  std::string name;
  conduit_index_t type = 0;  // 0: empty, 1: an object, 3 to 12: numbers, 13: a text
  std::vector<std::unique_ptr<conduit_node_impl>> children;
  std::string own;  // the memory of texts and single numbers
  char* data = nullptr;
  conduit_index_t count = 0, offset = 0, stride = 0, endianness = 0;
};

namespace {

using Node = conduit_node_impl;

[[noreturn]] void error(const char* what, const char* path = "") {
  std::fprintf(stderr, "the stand-in for Conduit: %s %s\n", what, path);
  std::abort();
}

Node* childOf(const Node* node, const std::string& name) {
  for (const auto& child : node->children)
    if (child->name == name) return child.get();
  return nullptr;
}

Node* find(Node* node, const std::string& path) {
  const size_t slash = path.find('/');
  Node* child = childOf(node, path.substr(0, slash));
  return !child || slash == std::string::npos ? child : find(child, path.substr(slash + 1));
}

Node* fetch(Node* node, const std::string& path) {
  if (node->type != 1) *node = {node->name, 1, {}, {}, nullptr, 0, 0, 0, 0};
  const size_t slash = path.find('/');
  Node* child = childOf(node, path.substr(0, slash));
  if (!child) {
    child = node->children.emplace_back(std::make_unique<Node>()).get();
    child->name = path.substr(0, slash);
  }
  return slash == std::string::npos ? child : fetch(child, path.substr(slash + 1));
}

void set(Node* node, const char* path, conduit_index_t type, const void* value, size_t bytes,
         conduit_index_t count) {
  Node* to = fetch(node, path);
  *to = {to->name, type, {}, std::string(static_cast<const char*>(value), bytes), nullptr, count, 0, 0, 0};
  to->data = to->own.data();
  to->stride = conduit_index_t(bytes) / count;
}

// A node stands for the type of its values, too.
const Node* dtype(const conduit_datatype_impl* type) { return reinterpret_cast<const Node*>(type); }

struct Implementation {
  int version;
  enum catalyst_status (*initialize)(const conduit_node*);
  enum catalyst_status (*execute)(const conduit_node*);
  enum catalyst_status (*finalize)(const conduit_node*);
  enum catalyst_status (*about)(conduit_node*);
  enum catalyst_status (*results)(conduit_node*);
};
const Implementation* loaded = nullptr;

enum catalyst_status load() {
  const char *name = std::getenv("CATALYST_IMPLEMENTATION_NAME"),
             *paths = std::getenv("CATALYST_IMPLEMENTATION_PATHS");
  if (!name || !paths) return catalyst_status_error_not_found;
  void* library =
      dlopen((std::string(paths) + "/libcatalyst-" + name + ".so").c_str(), RTLD_LAZY | RTLD_GLOBAL);
  if (!library) return std::printf("%s\n", dlerror()), catalyst_status_error_not_found;
  const auto* found = static_cast<const Implementation*>(dlsym(library, "catalyst_api_impl"));
  if (!found) return catalyst_status_error_not_catalyst;
  if (found->version != 1) return catalyst_status_error_unsupported_version;
  if (!found->initialize || !found->execute || !found->finalize || !found->about || !found->results)
    return catalyst_status_error_incomplete;
  loaded = found;
  return catalyst_status_ok;
}

}  // namespace

enum catalyst_status catalyst_initialize(const conduit_node* params) {
  const enum catalyst_status status = loaded ? catalyst_status_ok : load();
  return status == catalyst_status_ok ? loaded->initialize(params) : status;
}
enum catalyst_status catalyst_execute(const conduit_node* params) { return loaded->execute(params); }
enum catalyst_status catalyst_finalize(const conduit_node* params) { return loaded->finalize(params); }
enum catalyst_status catalyst_about(conduit_node* params) { return loaded->about(params); }
enum catalyst_status catalyst_results(conduit_node* params) { return loaded->results(params); }

conduit_node* catalyst_conduit_node_create() { return std::make_unique<Node>().release(); }
void catalyst_conduit_node_destroy(conduit_node* node) { std::unique_ptr<Node>(node).reset(); }
void catalyst_conduit_node_set_path_char8_str(conduit_node* node, const char* path, const char* value) {
  set(node, path, 13, value, std::strlen(value) + 1, conduit_index_t(std::strlen(value)) + 1);
}
void catalyst_conduit_node_set_path_int64(conduit_node* node, const char* path, int64_t value) {
  set(node, path, 6, &value, 8, 1);
}
void catalyst_conduit_node_set_path_float64(conduit_node* node, const char* path, double value) {
  set(node, path, 12, &value, 8, 1);
}
void stand_in_set_external(conduit_node* node, const char* path, conduit_index_t type, void* data,
                           conduit_index_t count, conduit_index_t offset, conduit_index_t stride,
                           conduit_index_t endianness) {
  Node* to = fetch(node, path);
  *to = {to->name, type, {}, {}, static_cast<char*>(data), count, offset, stride, endianness};
}
void catalyst_conduit_node_set_path_external_int32_ptr_detailed(conduit_node* node, const char* path,
                                                                int32_t* data, conduit_index_t count,
                                                                conduit_index_t offset,
                                                                conduit_index_t stride, conduit_index_t,
                                                                conduit_index_t endianness) {
  stand_in_set_external(node, path, 5, data, count, offset, stride, endianness);
}
void catalyst_conduit_node_set_path_external_float64_ptr_detailed(conduit_node* node, const char* path,
                                                                  double* data, conduit_index_t count,
                                                                  conduit_index_t offset,
                                                                  conduit_index_t stride, conduit_index_t,
                                                                  conduit_index_t endianness) {
  stand_in_set_external(node, path, 12, data, count, offset, stride, endianness);
}
void stand_in_remove(conduit_node* node, const char* path) {
  const std::string all = path, name = all.substr(all.rfind('/') + 1);
  Node* parent = all == name ? node : find(node, all.substr(0, all.rfind('/')));
  std::erase_if(parent->children, [&](const auto& child) { return child->name == name; });
}
const char* stand_in_text(conduit_node* node, const char* path) {
  const Node* at = find(node, path);
  return at && at->type == 13 ? at->data : nullptr;
}

// What implementations use.
extern "C" {
int catalyst_conduit_node_has_path(const conduit_node* node, const char* path) {
  return find(const_cast<conduit_node*>(node), path) != nullptr;
}
conduit_node* catalyst_conduit_node_fetch_existing(conduit_node* node, const char* path) {
  conduit_node* found = find(node, path);
  return found ? found : (error("there is no", path), nullptr);
}
conduit_index_t catalyst_conduit_node_number_of_children(conduit_node* node) {
  return conduit_index_t(node->children.size());
}
conduit_node* catalyst_conduit_node_child(conduit_node* node, conduit_index_t index) {
  if (index < 0 || index >= conduit_index_t(node->children.size())) error("there is no such child");
  return node->children[size_t(index)].get();
}
char* catalyst_conduit_node_name(const conduit_node* node) { return strdup(node->name.c_str()); }
const conduit_datatype_impl* catalyst_conduit_node_dtype(const conduit_node* node) {
  return reinterpret_cast<const conduit_datatype_impl*>(node);
}
void* catalyst_conduit_node_element_ptr(conduit_node* node, conduit_index_t index) {
  return node->data ? node->data + node->offset + index * node->stride : nullptr;
}
conduit_index_t catalyst_conduit_datatype_id(const conduit_datatype_impl* type) { return dtype(type)->type; }
conduit_index_t catalyst_conduit_datatype_number_of_elements(const conduit_datatype_impl* type) {
  return dtype(type)->count;
}
conduit_index_t catalyst_conduit_datatype_stride(const conduit_datatype_impl* type) {
  return dtype(type)->stride;
}
int catalyst_conduit_datatype_endianness_matches_machine(const conduit_datatype_impl* type) {
  return dtype(type)->endianness == 0;
}
}
