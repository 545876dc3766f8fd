// SPDX-License-Identifier: Apache-2.0
// msdata and msclient: statements to a multiserver, typed or from scripts.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>

#include "gxy/comm/error.h"
#include "gxy/protocol/json.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "statements.h"

using namespace gxy;

namespace {

// What a statement may begin with, with and without its module.
std::vector<std::string> verbsOf(Client& client) {
  std::set<std::string> words{"exit"};
  const nlohmann::json help = client.expect("help"), modules = client.expect("modules");
  for (const auto& verb : help.at("verbs")) words.insert(verb.at("verb").get<std::string>());
  for (const auto& loaded : modules.at("loaded")) {
    const std::string module = loaded;
    const nlohmann::json again = client.expect("load " + module);  // it changes nothing and lists
    for (const auto& verb : again.at("verbs")) words.insert(module + "." + verb.get<std::string>());
  }
  return {words.begin(), words.end()};
}

// False: `exit`, or the connection has ended, which a user who types sees.
bool readAtTerminal(Client& client, Runner& runner, Output& output) {
  std::vector<std::string> words = verbsOf(client);
  return readTerminal(words, output, [&](const std::string& statement) {
    if (!runner.run(statement) || !client.connected()) return false;
    if (statement.starts_with("load")) words = verbsOf(client);
    return true;
  });
}

int run(SayOptions options) {
  Output output;
  Report report(output, options.json);
  report.listenTo(options.client);
  Client client(options.client);
  for (const std::string& module : options.modules) client.expect("load " + module);
  Runner runner(client, report, output);
  bool on = true;
  const auto runText = [&](const std::string& text) {
    std::istringstream script(text);
    on = runner.runAll(script);
  };
  for (const std::string& statement : options.statements)
    if (on) runText(statement);
  for (const std::string& script : options.scripts) {
    if (!on) break;
    std::error_code failed;
    const bool first = &script == &options.scripts.front();
    if (first && script == "stat" && !std::filesystem::exists(script, failed)) {
      runText("stat;");
      continue;
    }
    if (script == "-") {
      on = runner.runAll(std::cin);
    } else {
      std::ifstream file(script);
      if (!file) throw Error(script + ": cannot read the script");
      on = runner.runAll(file);
    }
  }
  if (options.scripts.empty() && options.statements.empty()) {
    if (isatty(STDIN_FILENO))
      on = readAtTerminal(client, runner, output);
    else
      on = runner.runAll(std::cin);
  }
  if (on && options.follow) throw Error("the connection has ended: " + report.waitForEnd());
  return report.failed() ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  SayOptions options;
  if (const auto code = parseOptions(argc, argv, options)) return *code;
  try {
    return run(options);
  } catch (const std::exception& e) {
    std::cerr << options.client.name << ": error: " << protocol::printable(e.what()) << '\n';
    return 2;
  }
}
