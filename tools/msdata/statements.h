// SPDX-License-Identifier: Apache-2.0
// Where statements come from, and what becomes of their replies.
#pragma once
#include <functional>
#include <istream>
#include <string>
#include <vector>

#include "gxy/client/client.h"

namespace gxy {

/// Runs statements one after the other.
class Runner {
 public:
  /// `json`: a line of JSON for each statement instead of text for people.
  Runner(Client& client, bool json) : client_(client), json_(json) {}

  /// False when the session is to end: `exit`, or the connection has ended.
  bool run(const std::string& statement);
  /// Runs a script; statements end with `;`, a line that begins with # is a comment. A last one without `;` runs too.
  bool runAll(std::istream& script);

  bool failed() const { return failed_; }

 private:
  void show(const std::string& statement, const Reply& reply);

  Client& client_;
  const bool json_;
  bool failed_ = false;
};

/// Reads statements from a terminal with editing, history and completion of verbs; `run` returns false to end.
void readTerminal(const std::vector<std::string>& words, const std::function<bool(const std::string&)>& run);

}  // namespace gxy
