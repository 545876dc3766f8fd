// SPDX-License-Identifier: Apache-2.0
#include "core/io/import_geometry.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/parallel_for.h"
#include "core/comm/wire.h"
#include "core/data/distribute.h"
#include "core/data/joined.h"
#include "core/data/merge_ranges.h"
#include "core/io/point_spread.h"

namespace gxy {
namespace {

/// What has been read so far on this rank. An attribute that one non-empty piece lacks is lost for all.
struct Reading {
  GeometryBlock block;  ///< once join() has been called
  std::vector<GeometryBlock> parts;
  size_t points = 0, pointsOfColors = 0, pointsOfValues = 0;  ///< of all parts
  bool values = true, colors = true, normals = true;
  uint64_t unusedCells = 0;
  LeftOut leftOut;
  std::vector<std::string> warnings;
  std::string array;  ///< the first piece with points has its values of this array

  /// Of thousands of pieces with the same flaw some are told.
  void warn(const std::string& text) {
    constexpr size_t kMost = 20;
    if (warnings.size() < kMost)
      warnings.push_back(text);
    else if (warnings.size() == kMost)
      warnings.push_back("of more pieces the warnings are not shown");
  }

  void add(GeometryContent piece) {
    for (const std::string& text : piece.warnings) warn(text);
    GeometryBlock& from = piece.block;
    unusedCells += piece.unusedCells;
    leftOut += piece.leftOut;
    if (from.points.empty()) return;
    if (points + from.points.size() >= std::numeric_limits<uint32_t>::max())
      throw Error("one rank would hold more than 2^32 - 2 points; use more ranks");
    if (array.empty()) array = piece.array;
    values = values && !from.values.empty();
    colors = colors && !from.colors.empty();
    normals = normals && !from.normals.empty();
    if (!parts.empty() && !areAlike(parts[0].fields, from.fields))
      throw Error("arrays for `fields` have other numbers of components in other pieces, expected the same");
    points += from.points.size();
    pointsOfColors += from.colors.size();
    pointsOfValues += from.values.size();
    parts.push_back(std::move(from));
  }

  /// Makes one block of the pieces.
  void join(GeometryKind kind) {
    for (GeometryBlock& part : parts) {
      if (!values) part.values = {};
      if (!colors) part.colors = {};
      if (!normals) part.normals = {};
    }
    block = joined(kind, std::exchange(parts, {}));
  }
};

const char* plural(GeometryKind kind) {
  return kind == GeometryKind::Particles ? "points" : kind == GeometryKind::PathLines ? "lines" : "triangles";
}

/// Reads this rank's share of the pieces.
class PieceReader {
 public:
  PieceReader(const std::string& path, GeometryKind kind, const ValuesWanted& wanted, Collectives& ranks,
              const TakeMemory& toTake)
      : kind_(kind), ranks_(ranks), toTake_(toTake), wanted_(wanted) {
    agree(ranks, [&] {
      pieces_ = geometryPieces(path);
      if (pieces_.size() > 1) {
        next_ = pieces_.size() * size_t(ranks.rank()) / size_t(ranks.size());
        end_ = pieces_.size() * (size_t(ranks.rank()) + 1) / size_t(ranks.size());
        if (wanted.array.empty())
          if (const auto listed = valuesOfList(path)) choose(*listed);
      } else if (ranks.rank() == 0) {
        end_ = pieces_.size();
      }
      first_ = next_;
    });
  }

  bool isOneFile() const { return pieces_.size() == 1; }

  Reading run() {
    if (!isOneFile() && wanted_.array.empty()) chooseTogether();
    agree(ranks_, [&] {
      while (next_ < end_) add(read());
    });
    if (!wanted_.array.empty()) reading_.array = wanted_.array;
    if (isOneFile()) reading_.array = ofRoot(reading_.array);
    agree(ranks_, [&] { reading_.join(kind_); });
    return std::move(reading_);
  }

 private:
  void choose(const ValuesWanted& values) {
    wanted_.array = values.array;
    wanted_.ofCells = values.ofCells;
    wanted_.orNone = values.orNone;
  }

  GeometryContent read() {
    ranks_.check();
    GeometryContent content = readGeometry(pieces_[next_++], kind_, wanted_, toTake_);
    ranks_.done(double(next_ - first_) / double(end_ - first_));
    return content;
  }

  void add(GeometryContent content) {
    if (wanted_.orNone && content.array.empty() && !content.block.points.empty())
      reading_.warn(pieces_[next_ - 1] + ": no array " + inQuotes(wanted_.array) +
                    ", so values are not used");
    reading_.add(std::move(content));
  }

  /// All pieces have the array that is chosen of the first one with points, on whichever rank that is.
  void chooseTogether() {
    std::optional<GeometryContent> first;  // of this rank
    agree(ranks_, [&] {
      while (next_ < end_ && !first) {
        GeometryContent content = read();
        if (content.block.points.empty())
          reading_.add(std::move(content));
        else
          first = std::move(content);
      }
    });
    Writer writer;
    if (first) writer.write(uint8_t(first->ofCells)).write(first->array);
    std::optional<ValuesWanted> chosen;
    for (const Bytes& told : ranks_.allGather(writer.take())) {
      if (told.empty() || chosen) continue;
      Reader reader(told, "the choice of an array");
      const bool ofCells = reader.read<uint8_t>() != 0;
      chosen = ValuesWanted(reader.readString(), ofCells, true);
    }
    if (!first) {
      if (chosen) choose(*chosen);
      return;
    }
    const bool same =
        first->array == chosen->array && (first->array.empty() || first->ofCells == chosen->ofCells);
    choose(*chosen);
    if (same)
      add(std::move(*first));
    else
      --next_;  // to be read again
  }

  std::string ofRoot(const std::string& text) const {
    Writer writer;
    writer.write(text);
    const std::vector<Bytes> told = ranks_.allGather(writer.take());
    return Reader(told.at(0), "the name of an array").readString();
  }

  const GeometryKind kind_;
  Collectives& ranks_;
  const TakeMemory& toTake_;
  ValuesWanted wanted_;
  std::vector<std::string> pieces_;
  size_t next_ = 0, first_ = 0, end_ = 0;
  Reading reading_;
};

/// What all ranks have to say, on rank 0.
std::vector<std::string> gathered(Collectives& ranks, const std::vector<std::string>& mine) {
  Writer writer;
  for (const std::string& text : mine) writer.write(text);
  std::vector<std::string> all;
  for (const Bytes& told : ranks.allGather(writer.take())) {
    if (ranks.rank() != 0) continue;
    Reader reader(told, "warnings");
    while (!reader.rest().empty()) all.push_back(reader.readString());
  }
  return all;
}

/// What the values are called: as their array, unless that is a field, too, which has several components.
std::string nameOfValues(const std::string& array, const GeometryBlock& block) {
  const PointField* field = findField(block.fields, array);
  return field && field->components > 1 ? "mag(" + array + ")" : array;
}

std::vector<PointField> fieldsIn(const Bytes& message) {
  std::vector<PointField> fields;
  Reader in(message, "fields of points");
  while (!in.rest().empty()) {
    PointField& f = fields.emplace_back();
    f.name = in.readString();
    f.components = in.read<int32_t>();
  }
  return fields;
}

/// Collective. Ranks without points get the fields that those with points have. All ranks learn what fields there are.
void declareFields(OwnedGeometry& geometry, Collectives& ranks) {
  GeometryBlock& block = geometry.block;
  Writer mine;
  mine.write(uint8_t(!block.points.empty()));
  for (const PointField& f : block.fields) mine.write(f.name).write(int32_t(f.components));
  const std::vector<Bytes> told = ranks.allGather(mine.take());
  agree(ranks, [&] {
    std::optional<std::vector<PointField>> all;
    std::vector<PointField> ofNone;  // where no rank has points, the names that some rank knows
    for (const Bytes& message : told) {
      std::vector<PointField> fields = fieldsIn(Bytes(message.begin() + 1, message.end()));
      if (message.at(0) == std::byte(0)) {
        if (ofNone.empty()) ofNone = std::move(fields);
        continue;
      }
      if (all && !areAlike(*all, fields))
        throw Error(geometry.name +
                    ": ranks have different fields of points, expected the same names and components");
      all = std::move(fields);
    }
    if (block.points.empty()) block.fields = all ? *all : ofNone;
    geometry.fields.clear();
    for (const PointField& f : block.fields)
      geometry.fields.push_back({f.name, f.components, std::vector<Range>(partsOf(f.components))});
  });
}

/// What is measured of some primitives.
struct Measures {
  Box box;
  Range values, radii;
  std::vector<std::vector<Range>> fields;  ///< as in PointFieldInfo

  void extend(const Measures& other) {
    box.extend(other.box);
    values.extend(other.values);
    radii.extend(other.radii);
    for (size_t f = 0; f < fields.size(); ++f)
      for (size_t r = 0; r < fields[f].size(); ++r) fields[f][r].extend(other.fields[f][r]);
  }
};

/// Of primitives from number `first` on, before number `last`. Points that no primitive uses do not count.
Measures measuresOf(const GeometryBlock& block, GeometryKind kind, size_t first, size_t last) {
  Measures m;
  for (const PointField& f : block.fields) m.fields.emplace_back(partsOf(f.components));
  for (size_t p = first; p < last; ++p)
    for (const uint32_t point : primitivePoints(block, kind, p)) {
      m.box.extend(block.points[point]);
      if (!block.values.empty()) m.values.extend(double(block.values[point]));
      if (!block.radiusValues.empty()) m.radii.extend(double(block.radiusValues[point]));
      for (size_t f = 0; f < m.fields.size(); ++f) {
        const PointField& field = block.fields[f];
        for (int c = 0; c < field.components; ++c)
          m.fields[f][size_t(c)].extend(double(fieldValue(field, c, point)));
        if (field.components > 1) m.fields[f].back().extend(double(fieldValue(field, -1, point)));
      }
    }
  return m;
}

/// Of all primitives, on all cores. `check` is called now and then, on this thread.
Measures measuresOf(const GeometryBlock& block, GeometryKind kind, const std::function<void()>& check) {
  constexpr size_t kPart = size_t(1) << 16, kTogether = 64;
  const size_t parts = (block.ids.size() + kPart - 1) / kPart;
  Measures all = measuresOf(block, kind, 0, 0);
  for (size_t begin = 0; begin < parts; begin += kTogether) {
    check();
    std::vector<Measures> some(std::min(kTogether, parts - begin));
    parallelFor(size_t(0), some.size(), [&](size_t i) {
      const size_t first = (begin + i) * kPart;
      some[i] = measuresOf(block, kind, first, std::min(first + kPart, block.ids.size()));
    });
    for (const Measures& m : some) all.extend(m);
  }
  return all;
}

}  // namespace

LoadedGeometry loadGeometry(const std::string& path, GeometryKind kind, const ValuesWanted& wanted,
                            Collectives& ranks, const TakeMemory& toTake,
                            std::vector<std::string>* warnings) {
  LoadedGeometry loaded;
  OwnedGeometry& geometry = loaded.geometry;
  geometry.name = std::filesystem::path(path).stem().string();
  geometry.kind = kind;
  PieceReader reader(path, kind, wanted, ranks, toTake);
  loaded.onRoot = reader.isOneFile();
  const size_t rank = size_t(ranks.rank());
  Reading reading = reader.run();

  const bool values = sumOfCounts(ranks, !reading.values) == 0;
  const bool normals = sumOfCounts(ranks, !reading.normals) == 0;
  const bool colors = sumOfCounts(ranks, !reading.colors) == 0;
  const uint64_t pointsOfColors = sumOfCounts(ranks, reading.pointsOfColors);
  const uint64_t pointsOfValues = sumOfCounts(ranks, reading.pointsOfValues);
  if (!values) reading.block.values.clear();
  if (!colors) reading.block.colors.clear();
  geometry.colored = colors && pointsOfColors > 0;
  if (rank == 0 && pointsOfColors > 0 && pointsOfValues > 0)
    reading.warn(path + ": some pieces have colours where others have values, so neither are used");
  if (!normals) reading.block.normals.clear();
  if ((values && pointsOfValues > 0) || geometry.colored) geometry.array = reading.array;

  // Pieces are numbered one after the other, those of lower ranks first.
  const std::vector<uint64_t> counts = gatherCounts(ranks, reading.block.ids.size());
  const uint64_t before = std::accumulate(counts.begin(), counts.begin() + ranks.rank(), uint64_t(0));
  std::iota(reading.block.ids.begin(), reading.block.ids.end(), before);
  uint64_t dropped = 0;
  agree(ranks, [&] { dropped = uint64_t(dropUnusable(reading.block, kind)); });
  geometry.block = std::move(reading.block);
  loaded.leftOut = reading.leftOut;
  geometry.droppedPrimitives = sumOfCounts(ranks, dropped);
  const uint64_t read = std::accumulate(counts.begin(), counts.end(), uint64_t(0));
  geometry.primitives = read - geometry.droppedPrimitives;
  const uint64_t unused = sumOfCounts(ranks, reading.unusedCells);
  if (geometry.primitives + geometry.droppedPrimitives == 0 && unused > 0)
    throw Error(path + ": the file has no " + plural(kind) + ", only other kinds of cells");
  std::vector<std::string> told = reading.warnings;
  if (geometry.droppedPrimitives > 0 && rank == 0)
    told.push_back(path + ": " + std::to_string(geometry.droppedPrimitives) + " " + plural(kind) +
                   " dropped: not finite, without area, or repeated");
  for (std::string& warning : gathered(ranks, told)) {
    if (warnings)
      warnings->push_back(std::move(warning));
    else
      spdlog::warn("{}", warning);
  }

  if (!wanted.radii.empty()) geometry.radiusRange.emplace();
  measureGeometry(loaded, ranks);
  geometry.array = nameOfValues(geometry.array, geometry.block);
  return loaded;
}

void measureGeometry(LoadedGeometry& loaded, Collectives& ranks) {
  OwnedGeometry& geometry = loaded.geometry;
  declareFields(geometry, ranks);
  Range radii;
  agree(ranks, [&] {
    const Measures m = measuresOf(geometry.block, geometry.kind, [&] { ranks.check(); });
    geometry.box = m.box;
    geometry.range = m.values;
    radii = m.radii;
    for (size_t f = 0; f < geometry.fields.size(); ++f) geometry.fields[f].ranges = m.fields[f];
  });
  mergeBox(ranks, geometry.box);
  mergeRanges(ranks, std::span(&geometry.range, 1));
  mergeRanges(ranks, std::span(&radii, 1));
  for (PointFieldInfo& f : geometry.fields) mergeRanges(ranks, f.ranges);
  if (geometry.radiusRange) geometry.radiusRange = radii;
  const PointSpread spread = spreadOf(loaded, ranks);
  geometry.middle = geometry.kind == GeometryKind::Particles ? spread.middle : geometry.box;
  geometry.spacing = spread.spacing;
}

OwnedGeometry ownedGeometry(LoadedGeometry loaded, const Partitioning& partitioning, Collectives& ranks) {
  if (loaded.onRoot && ranks.size() > 1)
    loaded.geometry.block = keepHome(loaded.geometry.block, loaded.geometry.kind, partitioning, ranks);
  return std::move(loaded.geometry);
}

}  // namespace gxy
