// SPDX-License-Identifier: Apache-2.0
// A backend with substitutes, so that a program goes on where a device fails.
#pragma once
#include <memory>
#include <vector>

#include "core/rays/backend.h"

namespace gxy {

/// Returns a backend that uses `first`, and where that fails the next of `others` that fits and can do the
/// work; others are made only when they are needed. Without others it returns `first` itself.
///
/// A backend is passed over if its device is lost or if it cannot be made. For one scene it is also passed
/// over if it has no room for the scene or has answered rays of it with an error. A frame stays on the
/// backend where it was made. A frame under way ends with the error, and frames that are made later go to the
/// substitute. The scene is then made there, while the caller of makeFrame() waits. What `advance` throws is
/// passed on. A warning is logged whenever something is passed over, but only one for a lost device. If no
/// substitute is left, the backend in use stays in use.
///
/// Fields are made on the first that can advance lines, and stay there. A sampling is made on the first that can
/// make it; its scene is made there, too, and stays there.
///
/// A scene's bytes() and sharedBytes() are those on the backend where it was made first; it holds them as
/// long as it lives. Memory on a substitute is entered in `ledger` for tenant "device". `ledger` may be null,
/// or must live as long as frames are made.
std::unique_ptr<Backend> withSubstitutes(std::unique_ptr<Backend> first,
                                         std::vector<BackendRegistry::Entry> others, Ledger* ledger);

}  // namespace gxy
