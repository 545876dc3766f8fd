// SPDX-License-Identifier: Apache-2.0
// The commands convert, partition and info for volumes. All work box by box, so a volume need not fit into memory.
#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <filesystem>

#include "core/comm/error.h"
#include "core/data/partitioning.h"
#include "core/io/write_volume.h"
#include "tools/gxydata/commands.h"

namespace gxy::data_tool {
namespace {

/// Returns each array of the file as a volume of its own, or only the array that was asked for. Without
/// `several`, which raw formats do not support, it returns one.
std::vector<VolumeFile> chosenArrays(const Options& options, bool several) {
  const VolumeFile first = openVolume(options.in, options.array, options.raw);
  if (!options.array.empty() || !several) return {first};
  std::vector<VolumeFile> files{first};
  for (const ArrayInfo& array : first.arrays)
    if (array.name != first.array.name) files.push_back(openVolume(options.in, array.name, options.raw));
  return files;
}

/// Removes the arrays whose samples are not on the grid of the first one, because a written file has samples
/// of points or of cells, but not of both.
std::vector<VolumeFile> onOneGrid(const Options& options, std::vector<VolumeFile> files) {
  const Grid grid = files[0].grid;
  std::erase_if(files, [&](const VolumeFile& file) {
    if (file.grid == grid) return false;
    tellLoss(options, "array '" + file.array.name + "' is left out: it is " +
                          (file.array.ofCells ? "of cells" : "of points"));
    return true;
  });
  return files;
}

/// Returns the extent of the samples that the file contains: all but a rim.
Extent samplesOf(const VolumeFile& file) {
  Extent own = wholeOf(file.grid);
  if (file.grid.rim)
    for (size_t a = 0; a < 3; ++a) {
      own.first[a] = 1;
      own.points[a] -= 2;
    }
  return own;
}

std::vector<ArrayInfo> infos(const std::vector<VolumeFile>& files) {
  std::vector<ArrayInfo> arrays;
  for (const VolumeFile& file : files) {
    arrays.push_back(file.array);
    if (arrays.back().name.empty()) arrays.back().name = std::filesystem::path(file.path).stem().string();
  }
  return arrays;
}

void copy(const std::vector<VolumeFile>& files, const Extent& extent, const VolumeWriter& writer,
          Progress& progress) {
  std::vector<std::byte> box;
  for (size_t i = 0; i < files.size(); ++i)
    files[i].source->read(std::span(&extent, 1), [&](const SamplesRead& some) {
      box.resize(size_t(some.points.count()) * files[i].bytesPerPoint());
      copyBox(some.points, some.samples, some.layout, box, some.points, files[i].bytesPerPoint());
      Extent there = some.points;
      for (size_t a = 0; a < 3; ++a) there.first[a] -= extent.first[a];
      if (!box.empty()) writer.write(i, there, box);
      progress.advance(int64_t(box.size()));
    });
}

int64_t bytesOfAll(const std::vector<VolumeFile>& files) {
  int64_t bytes = 0;
  for (const VolumeFile& file : files) bytes += samplesOf(file).count() * int64_t(file.bytesPerPoint());
  return bytes;
}

/// Returns the cell at which block i of n begins, where blocks of `cells` cells differ by one cell at most.
int64_t cut(int64_t cells, int n, int i) { return cells / n * i + std::min(int64_t(i), cells % n); }

void printArray(const VolumeFile& file) {
  FieldStatistics all;
  all.ranges.resize(size_t(file.array.components) + (file.array.components > 1));
  const Extent own = samplesOf(file);
  file.source->read(std::span(&own, 1), [&](const SamplesRead& some) {
    all.merge(statisticsOf(some.samples, file.array.type, file.array.components, some.layout, some.points));
  });
  std::printf("array       '%s': %s, %d component%s%s\n", file.array.name.c_str(), nameOf(file.array.type),
              file.array.components, file.array.components > 1 ? "s" : "",
              file.array.ofCells ? ", of cells" : "");
  for (size_t i = 0; i < all.ranges.size(); ++i) {
    const bool magnitude = i == size_t(file.array.components);
    const std::string label = magnitude ? "magnitude" : "component " + std::to_string(i);
    if (all.ranges[i].empty())
      std::printf("  %-11s no finite value\n", label.c_str());
    else
      std::printf("  %-11s %.9g to %.9g\n", label.c_str(), all.ranges[i].min, all.ranges[i].max);
  }
  std::printf("  not finite  %" PRId64 "\n", all.noDataSamples);
}

}  // namespace

void convertVolume(const Options& options) {
  const std::vector<VolumeFile> files =
      onOneGrid(options, chosenArrays(options, extensionOf(options.out) == ".vti"));
  keepInput(options.in, {options.out, rawFileOf(options.out)});
  if (options.array.empty() && files.size() == 1)
    for (const ArrayInfo& array : files[0].arrays)
      if (array.name != files[0].array.name) tellLoss(options, "array '" + array.name + "' is left out");
  const VolumeWriter writer(options.out, files[0].grid, infos(files));
  Progress progress("converting", bytesOfAll(files));
  copy(files, samplesOf(files[0]), writer, progress);
}

void partitionVolume(const Options& options, int parts, std::array<int, 3> lattice) {
  if (extensionOf(options.out) != ".pvti") throw Error(options.out + ": the pieces of a volume need a .pvti");
  const std::vector<VolumeFile> files = onOneGrid(options, chosenArrays(options, true));
  const Grid& grid = files[0].grid;
  if (grid.rim) throw Error(options.in + ": samples of cells are not cut into pieces");
  const Index3 cells = grid.cells();
  if (lattice[0] == 0) lattice = decompose(parts, cells);
  for (size_t a = 0; a < 3; ++a)
    if (lattice[a] > cells[a])
      throw Error(std::to_string(lattice[a]) + " pieces along " + "xyz"[a] + ", but the grid has only " +
                  std::to_string(cells[a]) + " cells");
  keepInput(options.in, filesOfPieces(options.out, lattice, ".vti"));
  std::vector<ImagePiece> pieces;
  Progress progress("partitioning", bytesOfAll(files));
  for (int k = 0; k < lattice[2]; ++k)
    for (int j = 0; j < lattice[1]; ++j)
      for (int i = 0; i < lattice[0]; ++i) {
        const std::array<int, 3> at{i, j, k};
        Extent extent;
        Grid piece = grid;
        for (size_t a = 0; a < 3; ++a) {
          extent.first[a] = cut(cells[a], lattice[a], at[a]);
          extent.points[a] = cut(cells[a], lattice[a], at[a] + 1) - extent.first[a] + 1;
          piece.origin[int(a)] = grid.origin[int(a)] + grid.spacing[int(a)] * double(extent.first[a]);
        }
        piece.points = extent.points;
        const std::string name = pieceName(options.out, int(pieces.size()), ".vti");
        copy(files, extent, VolumeWriter(name, piece, infos(files), extent.first), progress);
        pieces.push_back({extent, std::filesystem::path(name).filename().string()});
      }
  writePvti(options.out, grid, infos(files), pieces);
}

void infoVolume(const Options& options) {
  const std::vector<VolumeFile> files = chosenArrays(options, true);
  const Grid& g = files[0].grid;
  std::printf("file        %s: structured volume\n", options.in.c_str());
  const Index3 n = samplesOf(files[0]).points;
  const glm::dvec3 origin = g.box().lo;
  std::printf("%-11s %" PRId64 " x %" PRId64 " x %" PRId64 "\n", g.rim ? "cells" : "points", n[0], n[1],
              n[2]);
  std::printf("origin      %.17g %.17g %.17g\n", origin.x, origin.y, origin.z);
  std::printf("spacing     %.17g %.17g %.17g\n", g.spacing.x, g.spacing.y, g.spacing.z);
  for (const VolumeFile& file : files) printArray(file);
}

}  // namespace gxy::data_tool
