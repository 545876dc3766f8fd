// SPDX-License-Identifier: Apache-2.0
#include "tools/msdata/options.h"

#include <CLI/CLI.hpp>

#include "tools/version_option.h"

namespace gxy {

std::optional<int> parseOptions(int argc, char** argv, SayOptions& o) {
#ifdef MSCLIENT_MODULE
  o.client.name = "msdata";
  o.modules = {MSCLIENT_MODULE};
  const std::string purpose = "Works with the data of a multiserver: statements";
#else
  o.client.name = "msclient";
  const std::string purpose = "Says statements to modules of a multiserver: they";
#endif
  CLI::App app(
      purpose +
          " end with `;`, `help;` lists them, `exit;` leaves. Events that were asked for (`observe;`) are "
          "printed as they come. Pictures that come (`batch` of module viewer, to the client) are written "
          "to the current folder, under their names without folders, and replace what has these names.",
      o.client.name);
  std::vector<std::string> more;
  app.add_option("-H,--host", o.client.host, "where the server runs")->capture_default_str();
  app.add_option("-P,--port", o.client.port, "its port")->capture_default_str();
  app.add_option("--token-file", o.client.tokenFile, kTokenFileHelp);
  app.add_option("-m,--module", more, "a module to load; may be repeated")->allow_extra_args(false);
  app.add_flag(
      "--json", o.json,
      "print a line of JSON for each statement (it has `statement`), event (`event`) and picture that "
      "was written (`file`)");
  app.add_option("-c,--command", o.statements, "a statement to run, before scripts; may be repeated")
      ->allow_extra_args(false);
  app.add_flag("-f,--follow", o.follow, "after the last statement, go on and print events, until Ctrl-C");
  app.add_option(
      "file", o.scripts,
      "scripts; - is standard input; `stat` first, where no file is called so, is the statement. No "
      "script and no -c: statements are read from the terminal");
  app.footer(
      "Exit status: 0 done, 1 a statement failed or a picture could not be written, 2 wrong usage, no "
      "server, or its connection ended before all statements were sent.");
  addVersion(app, o.client.name);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  o.modules.insert(o.modules.end(), more.begin(), more.end());
  return std::nullopt;
}

}  // namespace gxy
