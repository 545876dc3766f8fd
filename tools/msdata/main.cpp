// SPDX-License-Identifier: Apache-2.0
// msdata and msclient: send statements to a multiserver, typed or from scripts.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>

#include "core/comm/error.h"
#include "multiserver/protocol/json.h"
#include "tools/msdata/options.h"
#include "tools/msdata/output.h"
#include "tools/msdata/report.h"
#include "tools/msdata/statements.h"

using namespace gxy;
using nlohmann::json;

namespace {

/// The words that may be typed next.
class Words {
 public:
  explicit Words(Client& client) : client_(client) { update(); }

  /// Called after modules were loaded.
  void update() {
    std::set<std::string> words{"exit"};
    const json help = client_.expect("help"), modules = client_.expect("modules");
    for (const auto& verb : help.at("verbs")) words.insert(verb.at("verb").get<std::string>());
    for (const auto& loaded : modules.at("loaded")) {
      const std::string module = loaded;
      const json again = client_.expect("load " + module);  // lists the verbs; changes nothing
      for (const auto& verb : again.at("verbs")) words.insert(module + "." + verb.get<std::string>());
    }
    verbs_ = {words.begin(), words.end()};
  }

  std::vector<std::string> after(const std::string& before) const {
    std::string verb;
    std::istringstream(before) >> verb;
    if (verb.empty() || verb == "help") return verbs_;
    return verb == "load" ? names("modules", "available") : names("list", "datasets");
  }

 private:
  // Runs a statement and returns the names in a list of its reply; none if it fails.
  std::vector<std::string> names(const std::string& statement, const char* list) const {
    std::vector<std::string> found;
    const Reply reply = client_.request(statement);
    if (!reply.ok || !reply.value.is_object()) return found;
    const json entries = reply.value.value(list, json::array());
    for (const json& entry : entries) {
      if (entry.is_string()) found.push_back(entry);
      if (entry.is_object()) found.push_back(entry.value("name", std::string()));
    }
    return found;
  }

  Client& client_;
  std::vector<std::string> verbs_;
};

// Returns false after `exit`, or when the connection has ended, which the user has been told.
bool readAtTerminal(Client& client, Runner& runner, Output& output) {
  Words words(client);
  return readTerminal([&](const std::string& before) { return words.after(before); }, output,
                      [&](const std::string& statement) {
                        if (!runner.run(statement) || !client.connected()) return false;
                        if (statement.starts_with("load")) words.update();
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
    on = runner.runAll(script, "statements");
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
      on = runner.runAll(std::cin, "standard input");
    } else {
      std::ifstream file(script);
      if (!file) throw Error(script + ": cannot read the script");
      on = runner.runAll(file, script);
    }
  }
  if (options.scripts.empty() && options.statements.empty()) {
    if (isatty(STDIN_FILENO))
      on = readAtTerminal(client, runner, output);
    else
      on = runner.runAll(std::cin, "standard input");
  }
  if (on && options.follow) throw Error("the connection has ended: " + report.waitForEnd());
  output.flush();
  if (!std::cout) throw Error("standard output: cannot be written");
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
