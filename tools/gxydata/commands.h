// SPDX-License-Identifier: Apache-2.0
// The commands of gxydata, one function for each kind of work. All throw gxy::Error.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "core/data/geometry.h"
#include "core/io/volume_file.h"
#include "core/scene/first_look.h"
#include "tools/gxydata/fields.h"

namespace gxy::data_tool {

struct Options {
  std::array<int64_t, 3> resolution{64, 64, 64};
  int steps = 0;  ///< number of time steps, in files NAME_0000 and so on; 0: one file
  uint64_t seed = 1;
  std::string array;  ///< array to write or read; empty: the first, or the active one
  int64_t count = 0;  ///< number of particles or path lines, or rows of a mesh; 0: a default
  double displacement = 0;
  std::string cells = "hexahedra";  ///< of a mesh of cells; or "tetrahedra"
  std::string in, out;
  RawOptions raw;                  ///< facts about `in`
  std::vector<std::string> files;  ///< files of a scene
  LookOptions look;                ///< options of the first look at them
};

/// Samples fields on [-1, 1]^3: all of them into a .vti, one into a .vol or .json, or into a .vtu as makeCells() does.
void makeVolume(const std::vector<Field>& fields, const Options& options);

/// Samples a field at the points of a mesh of cells that fills [-1, 1]^3, and writes it into a .vtu. `displacement`: how far points inside are
/// moved at most, so that faces are bent.
void makeCells(const Field& field, const Options& options);

/// Raise this when one of the generators of geometry below makes other data from the same options: it is part
/// of the names under which gxybench keeps files.
constexpr int kGeometryVersion = 1;

void makeParticles(const Options& options);
void makeSphereMesh(const Options& options);
void makeHelix(const Options& options);

/// Convert from any format that can be read to any that can be written. Coordinates and the samples of a
/// volume keep their values (.stl: float coordinates). Of a geometry, one array in float or its magnitude,
/// and the normals, are kept. Losses are reported (tellLoss()).
void convertVolume(const Options& options);
void convertGeometry(const Options& options);

/// Cut a dataset into i x j x k pieces, or into `parts` pieces by automatic decomposition if the lattice is
/// zero. Neighbouring pieces of a volume share the points on their common face. A primitive of a geometry
/// goes to the piece that contains its middle.
void partitionVolume(const Options& options, int parts, std::array<int, 3> lattice);
void partitionGeometry(const Options& options, int parts, std::array<int, 3> lattice);

/// Prints a state file that shows data files in the same way as gxyrender does without a state file
/// (core/scene/first_look.h).
void printScene(const Options& options);

/// Checks the Cinema databases in these folders (core/scene/check_cinema.h), and prints what each has to standard output, and each
/// problem to standard error. Throws Error if there was any problem.
void checkCinemaDatabases(const std::vector<std::string>& folders);

/// Print a description of a file's content to standard output.
void infoVolume(const Options& options);
void infoGeometry(const Options& options);

/// Returns the path of a piece: NAME_0.EXT, NAME_1.EXT, ... beside `out`.
std::string pieceName(const std::string& out, int piece, const char* extension);

/// Returns `out` and the paths of all pieces of a lattice.
std::vector<std::string> filesOfPieces(const std::string& out, std::array<int, 3> lattice,
                                       const char* extension);

/// Throws Error if one of the files to be written is a file that reading `in` opens. It is called before
/// anything is written.
void keepInput(const std::string& in, const std::vector<std::string>& written);

/// Reports on standard error a part of the input that is rounded or left out.
void tellLoss(const Options& options, const std::string& what);

/// Returns the path of a time step: OUT with _0000 before its extension, or OUT itself if there is no time series.
std::string stepName(const Options& options, int step);

/// Shows a percentage on standard error, if that is a terminal. Any thread may call advance().
class Progress {
 public:
  Progress(std::string what, int64_t total);
  ~Progress();
  void advance(int64_t done = 1);

 private:
  std::string what_;
  int64_t total_;
  std::atomic<int64_t> done_{0};
  bool terminal_;
};

}  // namespace gxy::data_tool
