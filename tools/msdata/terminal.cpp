// SPDX-License-Identifier: Apache-2.0
#include <cstdio>  // readline.h needs FILE
#include <cstdlib>
#include <cstring>
#include <memory>

#include <readline/history.h>
#include <readline/readline.h>

#include "gxy/protocol/statement.h"
#include "statements.h"

namespace gxy {

namespace {

// Readline's callbacks carry nothing with them.
const std::vector<std::string>* completions = nullptr;
const std::string* begunBefore = nullptr;  // of the statement, in earlier lines
Output* printed = nullptr;

char* nextCompletion(const char* begun, int state) {
  static size_t next = 0;
  if (state == 0) next = 0;
  while (next < completions->size()) {
    const std::string& word = (*completions)[next++];
    if (word.compare(0, std::strlen(begun), begun) == 0) return strdup(word.c_str());
  }
  return nullptr;
}

// Verbs where a statement begins, file names elsewhere.
char** complete(const char* begun, int start, int) {
  std::string statement;
  protocol::cutStatements(*begunBefore + std::string(rl_line_buffer, size_t(start)), statement);
  const bool verb = statement.find_first_not_of(" \t\r\n") == std::string::npos;
  return verb ? rl_completion_matches(begun, nextCompletion) : nullptr;
}

// Ten times a second while a line is edited: what has come meanwhile goes above it.
int showArrivals() {
  if (printed->printHeld([] { rl_clear_visible_line(); })) {
    rl_on_new_line();
    rl_redisplay();
  }
  return 0;
}

}  // namespace

bool readTerminal(const std::vector<std::string>& words, Output& output,
                  const std::function<bool(const std::string&)>& run) {
  completions = &words;
  printed = &output;
  rl_attempted_completion_function = complete;
  rl_event_hook = showArrivals;
  using_history();
  std::string rest;
  begunBefore = &rest;
  for (;;) {
    output.hold();
    const std::unique_ptr<char, decltype(&std::free)> line(readline(rest.empty() ? "? " : "> "), &std::free);
    output.release();
    if (!line) break;
    if (*line) add_history(line.get());
    const std::string text = rest + line.get() + "\n";
    for (const std::string& statement : protocol::cutStatements(text, rest))
      if (!run(statement)) return false;
    if (rest.find_first_not_of(" \t\r\n") == std::string::npos) rest.clear();
  }
  std::printf("\n");
  return true;
}

}  // namespace gxy
