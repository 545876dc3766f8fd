// SPDX-License-Identifier: Apache-2.0
#include "statements.h"

#include <future>
#include <memory>

#include "gxy/protocol/statement.h"

namespace gxy {

bool Runner::run(const std::string& statement) {
  if (statement == "exit") return false;
  // Shown by the thread that reads, so that replies and events are in the order in which they came.
  const auto shown = std::make_shared<std::promise<void>>();
  client_.send(statement, [this, statement, shown](const Reply& reply) {
    report_.reply(statement, reply);
    shown->set_value();
  });
  shown->get_future().wait();
  output_.flush();
  return true;
}

bool Runner::runAll(std::istream& script) {
  std::string rest, line;
  while (std::getline(script, line)) {
    if (line.starts_with("#")) continue;
    std::string text = rest + line + "\n";
    for (const std::string& statement : protocol::cutStatements(text, rest))
      if (!run(statement)) return false;
  }
  const auto blank = rest.find_first_not_of(" \t\r\n");
  return blank == std::string::npos || run(rest.substr(blank, rest.find_last_not_of(" \t\r\n") - blank + 1));
}

}  // namespace gxy
