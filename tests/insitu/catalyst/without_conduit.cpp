// SPDX-License-Identifier: Apache-2.0
// without_conduit LIBRARY [CATALYST]: a program that has no Conduit, or one whose symbols nobody else sees, opens libcatalyst-galaxy.so.
#include <dlfcn.h>

#include <cstdio>

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
