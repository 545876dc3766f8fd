// SPDX-License-Identifier: Apache-2.0
#include "statements.h"

#include <iostream>

#include "gxy/protocol/json.h"
#include "gxy/protocol/statement.h"

namespace gxy {

namespace {

std::string indented(const std::string& text) {
  std::string out = "  ";
  for (const char c : text) {
    out += c;
    if (c == '\n') out += "  ";
  }
  return out;
}

}  // namespace

bool Runner::run(const std::string& statement) {
  if (statement == "exit") return false;
  show(statement, client_.request(statement));
  return client_.connected();
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

void Runner::show(const std::string& statement, const Reply& reply) {
  failed_ = failed_ || !reply.ok;
  if (json_) {
    nlohmann::json line{{"statement", statement}, {"ok", reply.ok}};
    if (reply.ok)
      line["reply"] = reply.value;
    else
      line["error"] = reply.error;
    std::cout << protocol::dump(line) << std::endl;
    return;
  }
  if (!reply.ok) {
    std::cout << std::flush;
    std::cerr << "error: " << reply.error << std::endl;
  } else if (const auto text = reply.value.find("text"); text != reply.value.end() && text->is_string()) {
    if (!text->get_ref<const std::string&>().empty())
      std::cout << indented(text->get<std::string>()) << std::endl;
  } else if (!reply.value.is_null() && !reply.value.empty()) {
    std::cout << indented(reply.value.dump(2)) << std::endl;
  }
}

}  // namespace gxy
