// SPDX-License-Identifier: Apache-2.0
// What gxydata does, one function per kind of work. All throw gxy::Error.
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
  int steps = 0;  ///< 0: one file; else files NAME_0000 on
  uint64_t seed = 1;
  std::string array;  ///< to write or read; empty: the first, or the active one
  int64_t count = 0;  ///< of particles or path lines
  double displacement = 0;
  std::string in, out;
  RawOptions raw;                  ///< of `in`
  std::vector<std::string> files;  ///< of a scene
  LookOptions look;                ///< at them
};

/// Samples fields on [-1, 1]^3: all of them into a .vti, one into a .vol or .json.
void makeVolume(const std::vector<Field>& fields, const Options& options);

/// Raised when one of the generators of geometry below makes other data of the same options: gxybench keeps files by it.
constexpr int kGeometryVersion = 1;

void makeParticles(const Options& options);
void makeSphereMesh(const Options& options);
void makeHelix(const Options& options);

/// From any format that is read to any that is written. Coordinates and the samples of a volume stay what they
/// are (.stl: float coordinates); of a geometry one array is kept, in float, or its magnitude, with the normals.
/// What is lost is told.
void convertVolume(const Options& options);
void convertGeometry(const Options& options);

/// Cuts a dataset into i x j x k pieces, or into `parts` by automatic decomposition if the lattice is zero.
/// Neighbouring pieces of a volume share the points on their common face; a primitive of a geometry goes
/// where its middle is.
void partitionVolume(const Options& options, int parts, std::array<int, 3> lattice);
void partitionGeometry(const Options& options, int parts, std::array<int, 3> lattice);

/// Prints the state file that shows data files as gxyrender shows them without one (core/look/first_look.h).
void printScene(const Options& options);

/// Prints what is in a file to standard output.
void infoVolume(const Options& options);
void infoGeometry(const Options& options);

/// NAME_0.EXT, NAME_1.EXT, ... beside `out`.
std::string pieceName(const std::string& out, int piece, const char* extension);

/// OUT and all pieces of a lattice.
std::vector<std::string> filesOfPieces(const std::string& out, std::array<int, 3> lattice,
                                       const char* extension);

/// Throws Error if one of the files to be written is one that reading `in` opens; called before any is.
void keepInput(const std::string& in, const std::vector<std::string>& written);

/// Tells on standard error what of the input is rounded or left out.
void tellLoss(const Options& options, const std::string& what);

/// OUT itself, or OUT with _0000 before its extension for a time series.
std::string stepName(const Options& options, int step);

/// A percentage on standard error, if that is a terminal. advance() may be called from any thread.
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
