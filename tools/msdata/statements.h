// SPDX-License-Identifier: Apache-2.0
// Where statements come from.
#pragma once
#include <functional>
#include <istream>
#include <string>
#include <vector>

#include "multiserver/client/client.h"
#include "tools/msdata/output.h"
#include "tools/msdata/report.h"

namespace gxy {

/// Runs statements one after the other: each is answered, and the answer printed, before the next.
class Runner {
 public:
  Runner(Client& client, Report& report, Output& output)
      : client_(client), report_(report), output_(output) {}

  /// False when the session is to end: `exit`. Ctrl-C at a terminal (takeInterrupt()) cancels the statement. Throws Error
  /// where the connection has ended before, or at a second Ctrl-C.
  bool run(const std::string& statement);
  /// Runs a script, of which messages speak as `name`; statements end with `;`, what isComment() is left out. A last one
  /// without `;` runs too. Throws Error where it cannot be read.
  bool runAll(std::istream& script, const std::string& name);

 private:
  Client& client_;
  Report& report_;
  Output& output_;
};

/// Whether the first of a line that is no blank is #.
bool isComment(const std::string& line);

/// Reads statements from a terminal with editing, history (kept from session to session in galaxy/history of the user's
/// state folder) and completion: `words` gives those that may follow what of the statement stands before; where it has none,
/// names of files are offered. Ctrl-C forgets what was typed. `run` returns false to end, as this does then. What is to be
/// printed while a line is edited is printed above it.
bool readTerminal(const std::function<std::vector<std::string>(const std::string& before)>& words,
                  Output& output, const std::function<bool(const std::string&)>& run);

/// Whether Ctrl-C has been pressed since this was asked last; for programs in which readTerminal() runs.
bool takeInterrupt();

}  // namespace gxy
