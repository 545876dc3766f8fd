// SPDX-License-Identifier: Apache-2.0
// msdata and msclient: statements to a multiserver, typed or from scripts.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "gxy/comm/error.h"
#include "gxy/protocol/json.h"
#include "statements.h"

using namespace gxy;

namespace {

struct Options {
  Client::Options client;
  std::vector<std::string> modules, statements, scripts;
  bool json = false;
};

std::vector<std::string> verbsOf(Client& client) {
  std::vector<std::string> words{"exit"};
  const nlohmann::json help = client.expect("help");
  for (const auto& verb : help.at("verbs")) words.push_back(verb.at("verb"));
  return words;
}

int run(const Options& options) {
  Client client(options.client);
  for (const std::string& module : options.modules) client.expect("load " + module);
  Runner runner(client, options.json);
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
      readTerminal(verbsOf(client), [&](const std::string& statement) { return runner.run(statement); });
    else
      runner.runAll(std::cin);
  }
  return runner.failed() ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
#ifdef MSCLIENT_MODULE
  const std::string name = "msdata";
  CLI::App app(
      "Works with the data of a multiserver: statements end with `;`, `help;` lists them, `exit;` leaves.",
      name);
#else
  const std::string name = "msclient";
  CLI::App app(
      "Says statements to modules of a multiserver: they end with `;`, `help;` lists them, `exit;` leaves.",
      name);
#endif
  Options options;
  options.client.name = name;
  app.add_option("-H,--host", options.client.host, "where the server runs")->capture_default_str();
  app.add_option("-P,--port", options.client.port, "its port")->capture_default_str();
  app.add_option("--token-file", options.client.tokenFile,
                 "file with the server's token (default: that of the server on this machine)");
  app.add_option("-m,--module", options.modules, "a module to load; may be repeated")
      ->allow_extra_args(false);
  app.add_flag("--json", options.json, "print a line of JSON for each statement");
  app.add_option("-c,--command", options.statements, "a statement to run, before scripts; may be repeated")
      ->allow_extra_args(false);
  app.add_option(
      "file", options.scripts,
      "scripts; - is standard input; `stat` first, where no file is called so, is the statement. No "
      "script and no -c: statements are read from the terminal");
  CLI11_PARSE(app, argc, argv);
#ifdef MSCLIENT_MODULE
  options.modules.insert(options.modules.begin(), MSCLIENT_MODULE);
#endif
  try {
    return run(options);
  } catch (const std::exception& e) {
    std::cerr << name << ": error: " << e.what() << '\n';
    return 2;
  }
}
