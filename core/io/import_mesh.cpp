// SPDX-License-Identifier: Apache-2.0
#include "core/io/import_mesh.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/wire.h"
#include "core/io/file.h"
#include "core/io/legacy_vtk.h"

namespace gxy {

namespace {

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

std::string ofPointsAndCells(const std::string& array) {
  return "array '" + array + "' is one of points in one piece and one of cells in another, expected the same";
}

/// What this rank has read so far, the points of one file after those of another.
struct MeshReading {
  MeshContent all;

  void add(MeshContent piece) {
    if (all.array.empty()) {
      all.array = piece.array;
      all.ofCells = piece.ofCells;
      all.components = piece.components;
      all.type = piece.type;
    } else if (!piece.array.empty()) {
      if (piece.ofCells != all.ofCells) throw Error(ofPointsAndCells(piece.array));
      if (piece.components != all.components)
        throw Error("array '" + piece.array + "' has " + std::to_string(piece.components) +
                    " components in one piece and " + std::to_string(all.components) +
                    " in another, expected the same");
      if (piece.type != all.type) all.type = ScalarType::Float64;
    }
    if (all.points.size() + piece.points.size() >= kMostMeshPoints)
      throw Error("one rank would hold a mesh of more than 2^30 points; use more ranks");
    const auto shift = uint32_t(all.points.size());
    for (uint64_t& number : piece.numbers) number += all.pointsOfFile;
    for (size_t type = 0; type < kCellTypes; type++) {
      for (const uint32_t point : piece.cells.points[type]) all.cells.points[type].push_back(point + shift);
      append(all.cellValues[type], piece.cellValues[type]);
      append(all.duplicates[type], piece.duplicates[type]);
    }
    append(all.points, piece.points);
    append(all.values, piece.values);
    append(all.numbers, piece.numbers);
    for (const auto& [type, count] : piece.kinds) all.kinds[type] += count;
    all.pointsOfFile += piece.pointsOfFile;
    all.flatCells += piece.flatCells;
    all.ghostCells += piece.ghostCells;
    all.unusableCells += piece.unusableCells;
    all.leftOut += piece.leftOut;
    append(all.warnings, piece.warnings);
  }
};

/// Reads this rank's share of the pieces, or of the cells of the only one.
class MeshPieces {
 public:
  MeshPieces(const std::string& path, const std::string& array, Collectives& ranks, const TakeMemory& toTake)
      : ranks_(ranks), toTake_(toTake) {
    wanted_.array = array;
    agree(ranks, [&] {
      pieces_ = geometryPieces(path);
      if (pieces_.empty()) throw Error(path + ": it lists no pieces, expected one or more");
      if (pieces_.size() > 1) {
        next_ = pieces_.size() * size_t(ranks.rank()) / size_t(ranks.size());
        end_ = pieces_.size() * (size_t(ranks.rank()) + 1) / size_t(ranks.size());
        if (array.empty())
          if (const auto listed = valuesOfList(path, {})) {
            wanted_.array = listed->array;
            wanted_.ofCells = listed->ofCells;
          }
      } else {
        end_ = 1;
        wanted_.part = ranks.rank();
        wanted_.of = ranks.size();
      }
      first_ = next_;
    });
  }

  bool isOneFile() const { return pieces_.size() == 1; }

  MeshContent read() {
    if (!isOneFile() && wanted_.array.empty()) chooseTogether();
    agree(ranks_, [&] {
      while (next_ < end_) reading_.add(readNext());
    });
    return std::move(reading_.all);
  }

 private:
  MeshContent readNext() {
    ranks_.check();
    MeshContent content = readMesh(pieces_[next_++], wanted_, toTake_);
    ranks_.done(double(next_ - first_) / double(end_ - first_));
    return content;
  }

  /// All pieces have the array that is chosen of the first one with points, on whichever rank that is.
  void chooseTogether() {
    std::optional<MeshContent> first;  // of this rank
    agree(ranks_, [&] {
      while (next_ < end_ && !first) {
        MeshContent content = readNext();
        if (content.array.empty())
          reading_.add(std::move(content));
        else
          first = std::move(content);
      }
    });
    Writer writer;
    writer.write(first ? first->array : std::string()).write(uint8_t(first && first->ofCells));
    for (const Bytes& told : ranks_.allGather(writer.take())) {
      Reader reader(told, "the choice of an array");
      if (!wanted_.array.empty()) continue;
      wanted_.array = reader.readString();
      wanted_.ofCells = reader.read<uint8_t>() != 0;
    }
    agree(ranks_, [&] {
      if (first && first->array == wanted_.array && first->ofCells == wanted_.ofCells)
        reading_.add(std::move(*first));
      else if (first)
        --next_;  // to be read again
    });
  }

  Collectives& ranks_;
  const TakeMemory& toTake_;
  MeshWanted wanted_;
  std::vector<std::string> pieces_;
  size_t next_ = 0, first_ = 0, end_ = 0;
  MeshReading reading_;
};

/// What ranks have to tell each other of what they have read.
struct ReadOnAll {
  std::string array;  // empty: no rank has points
  bool ofCells = false;
  int components = 1;
  ScalarType type = ScalarType::Float32;
  CellKinds kinds;
  std::vector<std::string> warnings;
  uint64_t pointsBefore = 0, flatCells = 0, ghostCells = 0, unusableCells = 0, cells = 0;
};

uint64_t cellsWithoutDuplicates(const MeshContent& content) {
  auto cells = int64_t(content.cells.size());
  for (const auto& ofType : content.duplicates) cells -= std::count(ofType.begin(), ofType.end(), uint8_t(1));
  return uint64_t(cells);
}

ReadOnAll gathered(const MeshContent& mine, const std::string& path, Collectives& ranks, bool isOneFile) {
  Writer writer;
  writer.write(mine.array).write(uint8_t(mine.ofCells)).write(int32_t(mine.components)).write(mine.type);
  writer.write(mine.pointsOfFile).write(mine.flatCells).write(mine.ghostCells).write(mine.unusableCells);
  writer.write(cellsWithoutDuplicates(mine)).write(uint64_t(mine.kinds.size()));
  for (const auto& [kind, count] : mine.kinds) writer.write(int32_t(kind)).write(count);
  for (const std::string& text : mine.warnings) writer.write(text);
  const std::vector<Bytes> told = ranks.allGather(writer.take());
  ReadOnAll all;
  agree(ranks, [&] {
    for (size_t rank = 0; rank < told.size(); rank++) {
      Reader reader(told[rank], "what has been read of a mesh");
      const std::string array = reader.readString();
      const bool ofCells = reader.read<uint8_t>() != 0;
      const auto components = reader.read<int32_t>();
      const auto type = reader.read<ScalarType>();
      if (!array.empty() && all.array.empty()) {
        all.array = array;
        all.ofCells = ofCells;
        all.components = components;
        all.type = type;
      } else if (!array.empty()) {
        if (ofCells != all.ofCells) throw Error(path + ": " + ofPointsAndCells(array));
        if (components != all.components)
          throw Error(path + ": array '" + array + "' has " + std::to_string(all.components) + " and " +
                      std::to_string(components) + " components in different pieces, expected the same");
        if (type != all.type) all.type = ScalarType::Float64;
      }
      const auto points = reader.read<uint64_t>();
      if (int(rank) < ranks.rank() && !isOneFile) all.pointsBefore += points;
      all.flatCells += reader.read<uint64_t>();
      all.ghostCells += reader.read<uint64_t>();
      all.unusableCells += reader.read<uint64_t>();
      all.cells += reader.read<uint64_t>();
      for (auto kinds = reader.read<uint64_t>(); kinds > 0; kinds--) {
        const auto kind = reader.read<int32_t>();
        const auto count = reader.read<uint64_t>();
        if (rank == 0 || !isOneFile) all.kinds[kind] += count;
      }
      while (!reader.rest().empty()) all.warnings.push_back(reader.readString());
    }
  });
  return all;
}

void checkHasCells(const ReadOnAll& read, const std::string& path) {
  if (read.cells > 0) return;
  for (const auto& [kind, count] : read.kinds)
    if (dimensionOf(kind).value_or(3) == 3)
      throw Error(path + ": none of its cells can be used: " + describe(read.kinds) +
                  "; expected cells of points whose coordinates are finite");
  if (read.ghostCells > 0)
    throw Error(path + ": all of its " + std::to_string(read.ghostCells) +
                " cells with a volume are duplicate, refined or hidden ones, expected others");
  throw Error(path + ": it has no cells with a volume, expected " + kMeshCellKinds +
              (read.kinds.empty() ? std::string()
                                  : "; it has " + describe(read.kinds) +
                                        ", which are imported as Triangles, PathLines or Particles"));
}

void tellWarnings(const std::vector<std::string>& texts, const Collectives& ranks,
                  std::vector<std::string>* warnings) {
  constexpr size_t kMost = 20;
  if (ranks.rank() != 0) return;
  for (size_t i = 0; i < std::min(texts.size(), kMost + 1); i++) {
    const std::string text = i < kMost ? texts[i] : "of more pieces the warnings are not shown";
    if (warnings)
      warnings->push_back(text);
    else
      spdlog::warn("{}", text);
  }
}

std::string plural(uint64_t count, const char* one, const char* several) {
  return std::to_string(count) + " " + (count == 1 ? one : several);
}

}  // namespace

bool isMeshFile(const std::string& path) {
  const std::string extension = extensionOf(path);
  constexpr std::array<std::string_view, 7> kEndings{".vtu",  ".vts",  ".vtr", ".pvtu",
                                                     ".pvts", ".pvtr", ".part"};
  if (extension != ".vtk") return std::find(kEndings.begin(), kEndings.end(), extension) != kEndings.end();
  const File file = File::open(path);
  std::string head(size_t(std::min(file.size(), int64_t(1024))), '\0');
  file.readAt(0, std::as_writable_bytes(std::span(head)));
  const std::string type = legacyDatasetType(head);
  return type == "UNSTRUCTURED_GRID" || type == "STRUCTURED_GRID" || type == "RECTILINEAR_GRID";
}

LoadedMesh loadMesh(const std::string& path, const std::string& array, Collectives& ranks,
                    const TakeMemory& toTake, std::vector<std::string>* warnings) {
  MeshPieces pieces(path, array, ranks, toTake);
  MeshContent content = pieces.read();
  const ReadOnAll all = gathered(content, path, ranks, pieces.isOneFile());
  checkHasCells(all, path);
  tellWarnings(all.warnings, ranks, warnings);

  LoadedMesh loaded;
  loaded.path = path;
  loaded.name = std::filesystem::path(path).stem().string() + ":" + all.array;
  loaded.leftOut = content.leftOut;
  loaded.report.flatCells = all.flatCells;
  loaded.report.ghostCells = all.ghostCells;
  loaded.report.unusableCells = all.unusableCells;
  MeshPiece piece;
  piece.components = all.components;
  piece.ofCells = all.ofCells;
  piece.duplicates = std::move(content.duplicates);
  piece.points = std::move(content.points);
  piece.numbers = std::move(content.numbers);
  piece.cells = std::move(content.cells);
  for (uint64_t& number : piece.numbers) number += all.pointsBefore;
  for (size_t type = 0; type < kCellTypes; type++) append(content.values, content.cellValues[type]);
  content.cellValues = {};
  static_cast<EncodedMesh&>(loaded) =
      encodedMesh(std::move(piece), all.type, std::move(content.values), ranks, toTake);
  return loaded;
}

std::shared_ptr<const Mesh> meshOf(LoadedMesh loaded, const Partitioning& partitioning, Collectives& ranks,
                                   const TakeMemory& toTake, std::vector<std::string>* warnings) {
  const std::string name = loaded.name, path = loaded.path;
  const MeshReport read = loaded.report;
  auto mesh =
      std::make_shared<Mesh>(completeMesh(static_cast<EncodedMesh&&>(loaded), partitioning, ranks, toTake));
  mesh->name = name;
  MeshReport& report = mesh->report;
  report.flatCells = read.flatCells;
  report.ghostCells = read.ghostCells;
  report.unusableCells = read.unusableCells;
  if (report.points == 0)
    throw Error(path + ": all of its " + std::to_string(report.degenerateCells) +
                " cells have a point twice, expected cells with a volume");
  tellWarnings(warningsOf(report, path), ranks, warnings);
  return mesh;
}

std::vector<std::string> warningsOf(const MeshReport& report, const std::string& path) {
  std::vector<std::string> texts;
  const auto add = [&](uint64_t count, const char* one, const char* several, const std::string& what) {
    if (count > 0) texts.push_back(path + ": " + plural(count, one, several) + what);
  };
  add(report.flatCells, "cell", "cells", " without a volume left out");
  add(report.ghostCells, "ghost cell", "ghost cells", " left out: duplicate, refined or hidden");
  add(report.unusableCells, "cell", "cells", " left out: a coordinate is not finite");
  add(report.repeatedCells, "cell", "cells", " left out: another cell has the same points");
  add(report.degenerateCells, "cell", "cells", " left out: a point is there twice");
  add(report.differingPoints, "point has", "points have",
      " another value than an earlier point at the same place, whose value is used");
  add(report.crowdedFaces, "face", "faces", " of three or more cells: the mesh overlaps itself there");
  add(report.foldedFaces, "face", "faces",
      " whose two cells are on the same side, or one of them is flat: where cells overlap, pixels depend on "
      "how the data are cut");
  add(report.hangingPoints, "point lies", "points lie",
      " in faces of cells that do not have them: values may differ on both sides of these faces");
  add(report.splitFaces, "triangle is half", "triangles are halves",
      " of faces of four points of other cells: values may differ on both sides of these faces");
  add(report.noDataPoints, "point has", "points have", " no finite value: cells there are transparent");
  add(report.noDataCells, "cell has", "cells have", " no finite value, and are transparent");
  add(report.differingCells, "cell has", "cells have",
      " another value than another cell with the same points; the lowest one is used");
  return texts;
}

}  // namespace gxy
