// SPDX-License-Identifier: Apache-2.0
// Initialises MPI for this process, unless the host program has done so.
#pragma once

namespace gxy {

/// Initialises MPI if nobody has done so yet, and then also finalises it. Make one in main() before anything
/// else that needs MPI, and destroy it on the same thread.
///
/// It asks MPI for MPI_THREAD_SERIALIZED, unless `beside`. While an MpiTransport lives, only its progress thread calls MPI;
/// before and after that, the thread that makes and destroys the MpiTransport does. A host program that
/// initialises MPI itself needs MPI_THREAD_MULTIPLE if it calls MPI while an MpiTransport lives, and
/// MPI_THREAD_SERIALIZED otherwise. The constructor throws Error if the level is lower than
/// that which is needed.
class MpiEnvironment {
 public:
  /// `beside`: the program itself calls MPI while an MpiTransport lives, so that the level is MPI_THREAD_MULTIPLE.
  explicit MpiEnvironment(bool beside = false);
  ~MpiEnvironment();
  MpiEnvironment(const MpiEnvironment&) = delete;
  MpiEnvironment& operator=(const MpiEnvironment&) = delete;

 private:
  bool finalises_ = false;
};

}  // namespace gxy
