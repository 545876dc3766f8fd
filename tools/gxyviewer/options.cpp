// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/options.h"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "tools/gxyviewer/keys.h"
#include "tools/look_options.h"
#include "tools/version_option.h"

namespace gxy {

std::optional<int> parseOptions(int argc, char** argv, ViewOptions& o) {
  CLI::App app(
      "Shows what a state file says, or data files as they are, rendered by a Galaxy server, in a window to "
      "turn it in.",
      "gxyviewer");
  std::string size;
  o.client.name = "gxyviewer";
  app.add_option("file", o.files,
                 "STATE.json, whose names of data files are as the server has them; or data files, or "
                 "datasets of the "
                 "server, shown together as their content suggests")
      ->required();
  std::vector<std::string> isovalues;
  addLookOptions(app, isovalues, o.look, o.array);
  app.add_option("-H,--host", o.client.host, "the server's machine")->capture_default_str();
  app.add_option("-P,--port", o.client.port, "the server's port")->capture_default_str();
  app.add_option("--token-file", o.client.tokenFile, kTokenFileHelp);
  app.add_option("--snapshot", o.snapshot, "F.png: write one picture and end; needs no display")
      ->check(CLI::Validator(
          [](const std::string& path) {
            return path.ends_with(".png") || path.ends_with(".PNG")
                       ? std::string()
                       : "expected a name that ends with .png, found " + path;
          },
          ""));
  app.add_option("--size", size, "WIDTHxHEIGHT of the window (default: the camera's dimensions)");
  app.add_option("--passes", o.passes,
                 "rays per pixel of a picture at rest, added one by one (default: the state's `rays per "
                 "pixel`, but at least 16 in "
                 "the window)")
      ->check(CLI::Range(1, 4096));
  app.add_flag_callback(
      "--plain", [&] { o.annotated = false; }, "begin without legend, axes and the data's box (key a)");
  app.add_option("--output", o.output,
                 "PREFIX of what is saved: PREFIX.json, PREFIX_00000.png, ... (default: STATE-view)");
  app.footer("In the window:\n" + std::string(kKeyHelp) +
             "\nExit status: 0 done, 1 no server, no display, or it failed; 2 wrong usage.");
  addVersion(app, "gxyviewer");
  try {
    app.parse(argc, argv);
    readIsovalues(isovalues, o.look);
    if (!size.empty()) {
      int width = 0, height = 0, used = 0;
      if (std::sscanf(size.c_str(), "%5dx%5d%n", &width, &height, &used) != 2 ||
          size_t(used) != size.size() || width < 1 || height < 1)
        throw CLI::ValidationError("--size", "expected WIDTHxHEIGHT, as 1280x720, found " + size);
      o.size = glm::ivec2(width, height);
    }
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  if (o.output.empty()) {
    const std::filesystem::path first(o.files[0]);
    const bool state = first.extension() == ".json";  // A folder of data may be read-only.
    o.output = ((state ? first.parent_path() : "") / (first.stem().string() + "-view")).string();
  }
  return std::nullopt;
}

}  // namespace gxy
