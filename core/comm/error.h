// SPDX-License-Identifier: Apache-2.0
// The one exception type of Galaxy.
#pragma once
#include <stdexcept>
#include <string>

namespace gxy {

/// An error whose message is meant for the user: what is wrong, where (file, line and column, key, rank), and
/// what was expected. The code that handles a request catches it and sends the message to the client that
/// made the request.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace gxy
