// SPDX-License-Identifier: Apache-2.0
// gxydata: makes, converts, partitions and describes datasets.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <limits>
#include <optional>
#include <sstream>

#include "core/comm/error_text.h"
#include "core/io/volume_description.h"
#include "core/io/volume_file.h"
#include "core/scene/read_context.h"
#include "tools/gxydata/commands.h"
#include "tools/look_options.h"
#include "tools/version_option.h"

namespace {

using namespace gxy;
using namespace gxy::data_tool;

constexpr const char* kExamples = R"(Examples:
  gxydata radial -r 64 balls.vti                     five arrays: oneBall, eightBalls, x, y, z
  gxydata radial -r 64,32,16 --array x ramp.vol      one array; the samples go to ramp.raw
  gxydata turbulence -r 256 --seed 7 noise.vol
  gxydata turbulence -r 64 --cells tetrahedra --displacement 0.1 noise.vtu
  gxydata radial -t 10 balls.vti                     balls_0000.vti to balls_0009.vti
  gxydata particles -r 100000 halos.vtp
  gxydata convert carotid.vtk carotid.vti
  gxydata partition noise.vol -g 2,2,1 pieces.pvti
  gxydata info bunny.ply
  gxydata convert head.raw head.vti --dimensions 256,256,109 --type uint16 --spacing 1,1,1.5
  gxydata scene noise.vti halos.vtp > scene.json     as gxyrender shows them without a state file
  gxydata check-cinema image.cdb                     whether viewers of Cinema databases will read it
Exit status: 0 done, 1 failed, 2 wrong usage.)";

/// Parses "64" or "64,32,16": one or three numbers from 1 to `most`.
std::vector<int64_t> numbersIn(const std::string& text, const char* option, int64_t most) {
  std::vector<int64_t> numbers;
  std::stringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    size_t used = 0;
    long long n = 0;
    try {
      n = std::stoll(word, &used);
    } catch (const std::exception&) {
    }
    if (used == 0 || used != word.size() || n < 1 || n > most)
      throw CLI::ValidationError(
          option, "expected integers from 1 to " + std::to_string(most) + ", found '" + text + "'");
    numbers.push_back(n);
  }
  if (numbers.size() != 1 && numbers.size() != 3)
    throw CLI::ValidationError(option, "expected one or three integers, found '" + text + "'");
  return numbers;
}

template <class T>
std::array<T, 3> threeNumbers(const std::string& text, const char* option, bool oneIsEnough) {
  std::vector<int64_t> numbers = numbersIn(text, option, 1000000);
  if (oneIsEnough && numbers.size() == 1) numbers.assign(3, numbers[0]);
  if (numbers.size() != 3)
    throw CLI::ValidationError(option, "expected three integers, found '" + text + "'");
  return {T(numbers[0]), T(numbers[1]), T(numbers[2])};
}

glm::dvec3 threeReals(const std::string& text, const char* option) {
  glm::dvec3 values;
  char end = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &values.x, &values.y, &values.z, &end) != 3)
    throw CLI::ValidationError(option, "expected three numbers such as 1,1,2.5, found '" + text + "'");
  return values;
}

/// Adds the options for files that have samples only, or whose headers are incomplete.
void addRawOptions(CLI::App* command, RawOptions& raw) {
  command->add_option_function<std::string>(
      "--dimensions",
      [&raw](const std::string& v) { raw.dimensions = threeNumbers<int64_t>(v, "--dimensions", false); },
      "of raw samples: points per axis, X,Y,Z, x fastest");
  command->add_option_function<std::string>(
      "--type",
      [&raw](const std::string& v) {
        raw.type = scalarTypeOfWord(v);
        if (!raw.type)
          throw CLI::ValidationError(
              "--type", "expected float, double, uint8, int8, uint16 and the like, found '" + v + "'");
      },
      "of raw samples: float, double, int8, uint8, int16, uint16, int32, uint32, int64 or uint64");
  command->add_option("--components", raw.components, "of raw samples, of a point")
      ->check(CLI::Range(1, 1024));
  command->add_flag("--big-endian", raw.bigEndian, "of raw samples: the byte order");
  command->add_option("--skip", raw.skip, "of raw samples: bytes before the first")
      ->check(CLI::NonNegativeNumber);
  command->add_option_function<std::string>(
      "--spacing", [&raw](const std::string& v) { raw.spacing = threeReals(v, "--spacing"); },
      "of raw samples, and of files with a header of theirs and raw samples: X,Y,Z");
  command->add_option_function<std::string>(
      "--origin", [&raw](const std::string& v) { raw.origin = threeReals(v, "--origin"); },
      "the same: of the first point");
}

/// Parses a count: a number, or three numbers whose product it is.
int64_t countIn(const std::string& text, const char* option) {
  constexpr int64_t most = std::numeric_limits<uint32_t>::max() - 1;  // Points have 32-bit indices.
  int64_t count = 1;
  for (int64_t n : numbersIn(text, option, most)) {
    if (n > most / count)
      throw CLI::ValidationError(
          option, "expected at most " + std::to_string(most) + " in all, found '" + text + "'");
    count *= n;
  }
  return count;
}

CLI::App* kind(CLI::App& app, Options& options, const char* name, const char* description) {
  CLI::App* command = app.add_subcommand(name, description);
  command->add_option("out", options.out, "file to write")->required();
  command->add_option("-t,--steps", options.steps, "time steps; writes OUT_0000, OUT_0001, ...")
      ->check(CLI::Range(1, 10000));
  command->add_option("--seed", options.seed, "seed of what is random")->capture_default_str();
  return command;
}

void addResolution(CLI::App* command, Options& options, std::string& text, const char* standard) {
  command->add_option("-r,--resolution", text,
                      "points per axis: N or NX,NY,NZ (default " + std::string(standard) + ")");
  command->add_option("--array", options.array, "write this array only");
  command->add_option("--cells", options.cells, "of a .vtu: tetrahedra or hexahedra")
      ->check(CLI::IsMember({"tetrahedra", "hexahedra"}))
      ->capture_default_str();
  command
      ->add_option("--displacement", options.displacement,
                   "of a .vtu: how far points inside are moved, so that cells are bent")
      ->check(CLI::Range(0.0, 0.2))
      ->capture_default_str();
  command->callback([&options, &text, standard] {
    options.resolution = threeNumbers<int64_t>(text.empty() ? standard : text, "-r", true);
  });
}

void addVolumeKinds(CLI::App& app, Options& options, std::string& resolution) {
  addResolution(kind(app, options, "radial", "volume: distances from one and from eight points, and ramps"),
                options, resolution, "64");
  addResolution(kind(app, options, "marschner-lobb", "volume: the test signal of Marschner and Lobb"),
                options, resolution, "41");
  addResolution(kind(app, options, "turbulence", "volume: six octaves of value noise"), options, resolution,
                "64");
  addResolution(kind(app, options, "sparse", "volume: exact zeros but for a few structures"), options,
                resolution, "64");
}

void addGeometryKinds(CLI::App& app, Options& options, std::string& points) {
  CLI::App* particles = kind(app, options, "particles", "clustered points with values");
  particles->add_option("-r,--resolution", points,
                        "number of points: N, or NX,NY,NZ for as many as such a grid has (default 10000)");
  particles->callback(
      [&options, &points] { options.count = countIn(points.empty() ? "10000" : points, "-r"); });
  CLI::App* mesh =
      kind(app, options, "sphere-mesh", "a triangulated, optionally bumpy sphere with values and normals");
  mesh->add_option("-r,--resolution", options.count, "rows of the mesh: N only (default 64)")
      ->check(CLI::Range(3, 20000));
  mesh->add_option("--displacement", options.displacement, "height of the bumps, in radii (default 0)")
      ->check(CLI::Range(0.0, 0.9));
  CLI::App* helix = kind(app, options, "helix", "path lines: coils whose value is their speed");
  helix->add_option("-r,--resolution", options.count, "number of lines: N only (default 8)")
      ->check(CLI::PositiveNumber);
}

/// Returns the first word of the command line if it should be a command but is none.
std::optional<std::string> unknownCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || *argv[1] == '-') return std::nullopt;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return std::nullopt;
  return "unknown command " + inQuotes(argv[1]) + suggestion(argv[1], names) + "; gxydata --help lists them";
}

void run(const CLI::App& app, const Options& options, int parts, std::array<int, 3> lattice) {
  const std::string command = app.get_subcommands().front()->get_name();
  if (command == "radial") return makeVolume(radialFields(), options);
  if (command == "marschner-lobb") return makeVolume({marschnerLobb()}, options);
  if (command == "turbulence") return makeVolume({turbulence(options.seed)}, options);
  if (command == "sparse") return makeVolume({sparse(options.seed)}, options);
  if (command == "particles") return makeParticles(options);
  if (command == "sphere-mesh") return makeSphereMesh(options);
  if (command == "helix") return makeHelix(options);
  if (command == "scene") return printScene(options);
  if (command == "check-cinema") return checkCinemaDatabases(options.files);
  const bool volume = options.raw.dimensions || options.raw.type || isVolumeFile(options.in);
  if (command == "convert") return volume ? convertVolume(options) : convertGeometry(options);
  if (command == "info") return volume ? infoVolume(options) : infoGeometry(options);
  if (volume) return partitionVolume(options, parts, lattice);
  partitionGeometry(options, parts, lattice);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Makes, converts, partitions and describes datasets for Galaxy.", "gxydata");
  app.footer(kExamples);
  app.require_subcommand(1);
  Options options;
  std::string resolution, latticeText;
  int parts = 0;
  addVolumeKinds(app, options, resolution);
  addGeometryKinds(app, options, resolution);

  CLI::App* convert = app.add_subcommand(
      "convert",
      "from one format to another: all arrays as they are, where the other one has a place for them; says "
      "what is left out or rounded");
  CLI::App* partition = app.add_subcommand("partition", "cut into pieces: .pvti, .pvtu, .pvtp or .part");
  CLI::App* info = app.add_subcommand("info", "print what is in a file");
  for (CLI::App* command : {convert, partition, info}) {
    command->add_option("in", options.in, "file to read")->required();
    command->add_option("--array", options.array, "use this array only");
    addRawOptions(command, options.raw);
  }
  for (CLI::App* command : {convert, partition})
    command->add_option("out", options.out, "file to write")->required();
  CLI::App* scene = app.add_subcommand("scene", "print a state file that shows data files");
  scene->add_option("FILE", options.files, "files to show together; of a series as 'step_*.vti' the first")
      ->required();
  std::vector<std::string> isovalues;
  addLookOptions(*scene, isovalues, options.look, options.array);
  CLI::App* cinema = app.add_subcommand("check-cinema", "check Cinema databases (specification D)");
  cinema->add_option("FOLDER", options.files, "databases, NAME.cdb")->required();
  CLI::Option* number =
      partition->add_option("-n,--parts", parts, "number of pieces")->check(CLI::Range(1, 1000000));
  CLI::Option* lattice =
      partition->add_option("-g,--lattice", latticeText, "pieces per axis: I,J,K")->excludes(number);

  if (const auto unknown = unknownCommand(app, argc, argv)) {
    std::fprintf(stderr, "gxydata: %s\n", unknown->c_str());
    return 2;
  }
  std::array<int, 3> cuts{0, 0, 0};
  addVersion(app, "gxydata");
  try {
    app.parse(argc, argv);
    readIsovalues(isovalues, options.look);
    if (lattice->count()) cuts = threeNumbers<int>(latticeText, "-g", false);
    if (partition->parsed() && !lattice->count() && !number->count())
      throw CLI::RequiredError("partition: -n or -g");
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    run(app, options, parts, cuts);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gxydata: %s\n", textOf(e).c_str());
    return 1;
  }
  return 0;
}
