// SPDX-License-Identifier: Apache-2.0
// MPI of this process, initialised by Galaxy or by the program it is part of.
#pragma once

namespace gxy {

/// Initialises MPI unless that has been done, and then also finalises it. Make one in main() before all else
/// that needs MPI; destroy it on the same thread.
///
/// Initialised here, MPI is asked for MPI_THREAD_SERIALIZED: during the life of an MpiTransport only its
/// progress thread calls MPI, before and after it the thread that makes and destroys it. A host program that
/// initialises MPI by itself and goes on calling it has to ask for MPI_THREAD_MULTIPLE; one that leaves MPI
/// alone meanwhile, for MPI_THREAD_SERIALIZED. Throws Error when the level is lower.
class MpiEnvironment {
 public:
  MpiEnvironment();
  ~MpiEnvironment();
  MpiEnvironment(const MpiEnvironment&) = delete;
  MpiEnvironment& operator=(const MpiEnvironment&) = delete;

 private:
  bool finalises_ = false;
};

}  // namespace gxy
