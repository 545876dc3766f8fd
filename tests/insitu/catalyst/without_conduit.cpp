// SPDX-License-Identifier: Apache-2.0
// without_conduit LIBRARY [CATALYST]: a program that has no Conduit, or one whose symbols nobody else sees, opens libcatalyst-galaxy.so.
#include <dlfcn.h>

#include <cstdio>

#ifdef OTHER_CONDUIT  // a program with a Conduit of its own, which does not know the nodes of Catalyst
#include <cstdlib>
#define OTHER(name) \
  extern "C" void conduit_##name() { std::abort(); }
OTHER(node_has_path)
OTHER(node_fetch_existing)
OTHER(node_number_of_children)
OTHER(node_child)
OTHER(node_name)
OTHER(node_dtype)
OTHER(node_element_ptr)
OTHER(node_set_path_char8_str)
OTHER(datatype_id)
OTHER(datatype_number_of_elements)
OTHER(datatype_stride)
OTHER(datatype_endianness_matches_machine)
#endif

int main(int argc, char** argv) {
  void* node = nullptr;
  if (argc > 2) {
    void* catalyst = dlopen(argv[2], RTLD_NOW | RTLD_LOCAL);
    if (!catalyst) return std::printf("%s\n", dlerror()), 2;
    node = reinterpret_cast<void* (*)()>(dlsym(catalyst, "catalyst_conduit_node_create"))();
  }
  struct Implementation {
    int version;
    int (*initialize)(const void*);
  };
  void* library = dlopen(argv[1], RTLD_LAZY | RTLD_GLOBAL);
  const auto* galaxy =
      library ? static_cast<const Implementation*>(dlsym(library, "catalyst_api_impl")) : nullptr;
  if (!galaxy) return std::printf("%s\n", dlerror()), 2;
  std::printf("status %d\n", galaxy->initialize(node));
}
