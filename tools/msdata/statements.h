// SPDX-License-Identifier: Apache-2.0
// Where statements come from.
#pragma once
#include <functional>
#include <istream>
#include <string>
#include <vector>

#include "gxy/client/client.h"
#include "output.h"
#include "report.h"

namespace gxy {

/// Runs statements one after the other: each is answered, and the answer printed, before the next.
class Runner {
 public:
  Runner(Client& client, Report& report, Output& output)
      : client_(client), report_(report), output_(output) {}

  /// False when the session is to end: `exit`. Throws Error where the connection has ended before.
  bool run(const std::string& statement);
  /// Runs a script; statements end with `;`, a line that begins with # is a comment. A last one without `;` runs too.
  bool runAll(std::istream& script);

 private:
  Client& client_;
  Report& report_;
  Output& output_;
};

/// Reads statements from a terminal with editing, history and completion of verbs, which are `words` (`run` may change
/// them); `run` returns false to end, as this does then. What is to be printed while a line is edited is printed above it.
bool readTerminal(const std::vector<std::string>& words, Output& output,
                  const std::function<bool(const std::string&)>& run);

}  // namespace gxy
