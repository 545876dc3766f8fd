// SPDX-License-Identifier: Apache-2.0
// main() of the tests that run on several ranks: MPI lives from before the first test until after the last.
#include <gtest/gtest.h>

#include "gxy/comm/mpi_environment.h"

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const gxy::MpiEnvironment environment;
  const int result = RUN_ALL_TESTS();
#ifdef __SANITIZE_ADDRESS__
  // Looked for while the plug-ins of Open MPI are loaded: later the names that lsan.supp knows them by are
  // gone.
  if (result == 0) __lsan_do_leak_check();
#endif
  return result;
}
