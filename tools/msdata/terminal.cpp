// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>  // readline.h needs FILE
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>

#include <readline/history.h>
#include <readline/readline.h>

#include "multiserver/protocol/statement.h"
#include "tools/msdata/statements.h"

namespace gxy {

namespace {

using Words = std::function<std::vector<std::string>(const std::string&)>;

// Global state, because neither readline's callbacks nor signal handlers take an argument for it.
const Words* wordsAfter = nullptr;
std::vector<std::string> completions;
const std::string* begunBefore = nullptr;  // the part of the statement in earlier lines
Output* printed = nullptr;
volatile std::sig_atomic_t interrupted = 0;

void interrupt(int) { interrupted = 1; }

char* nextCompletion(const char* begun, int state) {
  static size_t next = 0;
  if (state == 0) next = 0;
  while (next < completions.size()) {
    const std::string& word = completions[next++];
    if (word.compare(0, std::strlen(begun), begun) == 0) return strdup(word.c_str());
  }
  return nullptr;
}

char** complete(const char* begun, int start, int) {
  std::string statement;
  protocol::cutStatements(*begunBefore + std::string(rl_line_buffer, size_t(start)), statement);
  completions = (*wordsAfter)(statement);
  return rl_completion_matches(begun, nextCompletion);
}

// Called ten times a second while a line is edited. Prints output that has arrived above the line.
int showArrivals() {
  if (interrupted) {
    rl_crlf();
    rl_replace_line("", 0);
    rl_done = 1;
  } else if (printed->printHeld([] { rl_clear_visible_line(); })) {
    rl_on_new_line();
    rl_redisplay();
  }
  return 0;
}

/// The lines typed in this session and, if the user has a state folder, in earlier ones.
class History {
 public:
  History() {
    using_history();
    const char *state = std::getenv("XDG_STATE_HOME"), *home = std::getenv("HOME");
    if (!(state && *state) && !(home && *home)) return;
    const std::filesystem::path folder =
        (state && *state ? std::filesystem::path(state) : std::filesystem::path(home) / ".local/state") /
        "galaxy";
    std::error_code failed;  // If this fails, no history is kept.
    std::filesystem::create_directories(folder, failed);
    file_ = folder / "history";
    read_history(file_.c_str());
  }
  ~History() {
    if (file_.empty() || added_ == 0) return;
    if (append_history(added_, file_.c_str()) != 0) write_history(file_.c_str());  // creates the file
    history_truncate_file(file_.c_str(), kLines);
  }
  History(const History&) = delete;
  History& operator=(const History&) = delete;

  void add(const char* line) {
    add_history(line);
    added_++;
  }

 private:
  static constexpr int kLines = 1000;
  std::string file_;
  int added_ = 0;
};

}  // namespace

bool takeInterrupt() {
  const bool was = interrupted;
  interrupted = 0;
  return was;
}

bool readTerminal(const Words& words, Output& output, const std::function<bool(const std::string&)>& run) {
  wordsAfter = &words;
  printed = &output;
  rl_attempted_completion_function = complete;
  rl_event_hook = showArrivals;
  rl_catch_signals = 0;
  std::signal(SIGINT, interrupt);
  History history;
  std::string rest;
  begunBefore = &rest;
  for (;;) {
    output.hold();
    const std::unique_ptr<char, decltype(&std::free)> line(readline(rest.empty() ? "? " : "> "), &std::free);
    output.release();
    if (!line) break;
    if (takeInterrupt()) {
      rest.clear();
      continue;
    }
    if (*line) history.add(line.get());
    if (isComment(line.get())) continue;
    const std::string text = rest + line.get() + "\n";
    for (const std::string& statement : protocol::cutStatements(text, rest))
      if (!run(statement)) return false;
    if (rest.find_first_not_of(" \t\r\n") == std::string::npos) rest.clear();
  }
  std::printf("\n");
  return true;
}

}  // namespace gxy
