// SPDX-License-Identifier: Apache-2.0
// main() of the tests that run on several ranks: MPI lives from before the first test until after the last.
#include <gtest/gtest.h>

#include <memory>

#include "core/comm/mpi_environment.h"

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace {

/// MPI_Init loads plug-ins of which it unloads most, with what they leak: that cannot be told by name, and is
/// ignored.
std::unique_ptr<gxy::MpiEnvironment> initialised() {
#ifdef __SANITIZE_ADDRESS__
  const __lsan::ScopedDisabler disabled;
#endif
  return std::make_unique<gxy::MpiEnvironment>();
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const auto environment = initialised();
  const int result = RUN_ALL_TESTS();
#ifdef __SANITIZE_ADDRESS__
  // Looked for while the plug-ins of Open MPI are loaded: later the names that lsan.supp knows them by are
  // gone.
  if (result == 0) __lsan_do_leak_check();
#endif
  return result;
}
