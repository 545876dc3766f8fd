// SPDX-License-Identifier: Apache-2.0
// An object that says what is done with a finished picture. It comes with the request of the frame.
#pragma once
#include <functional>
#include <memory>

#include "core/comm/wire.h"
#include "core/render/framebuffer.h"

namespace gxy {

/// An operation on the picture of one frame. Rank 0 makes it together with the request, and the rank that owns the picture runs
/// it. If that is another rank, it runs a copy: write() writes the copy's bytes, and the reader that was given to
/// Renderer::onOperation() makes the copy from them. Operations are immutable.
class PictureOperation {
 public:
  virtual ~PictureOperation() = default;
  /// Writes the bytes of a copy. Called on rank 0, from any thread.
  virtual void write(Writer& writer) const = 0;
  /// Called once, as a task, on the rank that owns the picture. Not called if the frame ends without a picture. An exception
  /// that it throws becomes the frame's error.
  virtual void run(Picture picture) const = 0;
};
using PictureOperationPtr = std::shared_ptr<const PictureOperation>;

/// Makes an operation from the bytes that rank 0 has written. Throws Error for malformed bytes.
using PictureOperationReader = std::function<PictureOperationPtr(Reader& reader)>;

}  // namespace gxy
