// SPDX-License-Identifier: Apache-2.0
// Runs statements from the command line, from scripts and from a terminal.
#pragma once
#include <functional>
#include <istream>
#include <string>
#include <vector>

#include "multiserver/client/client.h"
#include "tools/msdata/output.h"
#include "tools/msdata/report.h"

namespace gxy {

/// Runs statements one after the other. The answer to each is printed before the next one is sent.
class Runner {
 public:
  Runner(Client& client, Report& report, Output& output)
      : client_(client), report_(report), output_(output) {}

  /// Runs a statement. Returns false if it is `exit`. Ctrl-C at a terminal (takeInterrupt()) cancels the
  /// statement. Throws Error if the connection has ended before, or at a second Ctrl-C.
  bool run(const std::string& statement);
  /// Runs a script, which messages call `name`. Statements end with `;`; a last one without `;` runs too.
  /// Lines for which isComment() is true are left out. Returns false after `exit`. Throws Error if the
  /// script cannot be read.
  bool runAll(std::istream& script, const std::string& name);

 private:
  Client& client_;
  Report& report_;
  Output& output_;
};

/// Whether the first character of a line that is not a blank is #.
bool isComment(const std::string& line);

/// Reads statements from a terminal and calls `run` for each, until `run` returns false or the input ends.
/// Returns false in the former case. Lines can be edited, have a history (kept in galaxy/history in the
/// user's state folder) and are completed: `words` returns the words that may follow the beginning `before`
/// of a statement; if there are none, file names are offered. Ctrl-C discards the statement that is being
/// typed. Output that arrives while a line is edited is printed above it.
bool readTerminal(const std::function<std::vector<std::string>(const std::string& before)>& words,
                  Output& output, const std::function<bool(const std::string&)>& run);

/// Whether Ctrl-C has been pressed since the last call. Works while readTerminal() runs.
bool takeInterrupt();

}  // namespace gxy
