// SPDX-License-Identifier: Apache-2.0
// Which rank of how many this process is.
//
// simsim does not use MPI: its ranks never speak to each other, so all that it would ask MPI for are two
// numbers, which every launcher leaves in the environment. So simsim starts without MPI, and a rank that ends
// early leaves no other waiting.
#pragma once
#include <functional>

namespace gxy::simsim {

struct Place {
  int rank = 0, ranks = 1;
};

/// Returns the place that a launcher (mpirun of Open MPI, mpiexec of MPICH and its kin, srun) has given to this
/// process: rank 0 of 1 without a launcher. `variable` returns the value of an environment variable, or null.
/// Throws Error for variables that do not make sense.
Place placeFrom(const std::function<const char*(const char* name)>& variable);

}  // namespace gxy::simsim
