// SPDX-License-Identifier: Apache-2.0
#include "tools/msdata/statements.h"

#include <chrono>
#include <future>
#include <memory>
#include <sstream>
#include <utility>

#include "core/comm/error.h"
#include "multiserver/protocol/statement.h"

namespace gxy {

namespace {

constexpr const char* kBlanks = " \t\r\n";

/// Whether the statement is `show ...` or `help show`.
bool isAboutShow(const std::string& statement) {
  std::istringstream words(statement);
  std::string first, second;
  words >> first >> second;
  return first == "show" || (first == "help" && second == "show");
}

}  // namespace

bool Runner::run(const std::string& statement) {
  if (statement == "exit") return false;
  if (isAboutShow(statement))
    client_.request("load viewer");  // It has this verb. If loading fails, the reply to `show` says so.
  // The reading thread shows the reply, so that replies and events are in the order in which they came.
  const auto shown = std::make_shared<std::promise<void>>();
  const uint32_t id = client_.send(statement, [&report = report_, statement, shown](const Reply& reply) {
    report.reply(statement, reply);
    shown->set_value();
  });
  const std::future<void> answered = shown->get_future();
  for (bool cancelled = false;
       answered.wait_for(std::chrono::milliseconds(50)) == std::future_status::timeout;) {
    if (!takeInterrupt()) continue;
    if (std::exchange(cancelled, true)) throw Error("interrupted, before the server has answered");
    client_.send("cancel " + std::to_string(id), [](const Reply&) {});
  }
  output_.flush();
  return true;
}

bool Runner::runAll(std::istream& script, const std::string& name) {
  std::string rest, line;
  while (std::getline(script, line)) {
    if (isComment(line)) continue;
    std::string text = rest + line + "\n";
    for (const std::string& statement : protocol::cutStatements(text, rest))
      if (!run(statement)) return false;
  }
  if (script.bad()) throw Error(name + ": cannot be read to its end");
  const auto blank = rest.find_first_not_of(kBlanks);
  return blank == std::string::npos || run(rest.substr(blank, rest.find_last_not_of(kBlanks) - blank + 1));
}

bool isComment(const std::string& line) {
  const auto first = line.find_first_not_of(kBlanks);
  return first != std::string::npos && line[first] == '#';
}

}  // namespace gxy
