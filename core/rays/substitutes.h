// SPDX-License-Identifier: Apache-2.0
// A backend for which others stand in, so that a program goes on where a device fails.
#pragma once
#include <memory>
#include <vector>

#include "core/rays/backend.h"

namespace gxy {

/// `first`, and where it fails the next of `others` that fits and can do it, made then. Without others it is `first` itself.
///
/// Those that can do nothing are passed over: a backend whose device is lost, one that cannot be made, and, by a scene, one
/// that has no room for it or that has answered rays of it with an error. A frame stays where it was made: one under way
/// ends with that error, and those that are made after it go to the substitute, where the scene is then made anew, while
/// whoever makes the frame waits. What `advance` throws is passed on. Each time that something is passed over a warning is
/// logged, of a lost device one in all. Where none is left, what there was is used as if it were alone.
///
/// A scene's bytes() and sharedBytes() are of where it was made at first, which it holds as long as it lives; what a
/// substitute takes is entered in `ledger` for tenant "device". That is null, or there as long as frames are made.
std::unique_ptr<Backend> withSubstitutes(std::unique_ptr<Backend> first,
                                         std::vector<BackendRegistry::Entry> others, Ledger* ledger);

}  // namespace gxy
