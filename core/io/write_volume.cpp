// SPDX-License-Identifier: Apache-2.0
#include "core/io/write_volume.h"

#include <bit>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "core/comm/error.h"
#include "core/io/volume_description.h"
#include "core/io/volume_formats.h"
#include "core/io/vtk_scalars.h"

namespace gxy {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string extentText(const Extent& extent) {
  std::string text;
  for (size_t a = 0; a < 3; ++a)
    text += (a ? " " : "") + std::to_string(extent.first[a]) + " " +
            std::to_string(extent.first[a] + extent.points[a] - 1);
  return text;
}

std::string arrayAttributes(const ArrayInfo& array) {
  std::string text = "type=\"" + std::string(xmlWord(array.type)) + "\" Name=\"" + escaped(array.name) +
                     "\" NumberOfComponents=\"" + std::to_string(array.components) + "\"";
  if (array.range)
    text += " RangeMin=\"" + number(array.range->min) + "\" RangeMax=\"" + number(array.range->max) + "\"";
  return text;
}

/// The origin in the file is that of index 0; ours is that of the first point.
std::string gridAttributes(const Grid& grid, const Extent& whole) {
  std::string origin, spacing;
  for (int a = 0; a < 3; ++a) {
    origin += (a ? " " : "") + number(grid.origin[a] - grid.spacing[a] * double(whole.first[size_t(a)]));
    spacing += (a ? " " : "") + number(grid.spacing[a]);
  }
  return "WholeExtent=\"" + extentText(whole) + "\" Origin=\"" + origin + "\" Spacing=\"" + spacing + "\"";
}

std::string fileElement(const char* type) {
  return std::string("<?xml version=\"1.0\"?>\n<VTKFile type=\"") + type +
         "\" version=\"1.0\" byte_order=\"" +
         (std::endian::native == std::endian::big ? "BigEndian" : "LittleEndian") +
         "\" header_type=\"UInt64\">\n";
}

}  // namespace

std::string rawFileOf(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension != ".vol" && extension != ".json") return {};
  return std::filesystem::path(path).replace_extension(".raw").string();
}

VolumeWriter::VolumeWriter(const std::string& path, const Grid& grid, std::vector<ArrayInfo> arrays,
                           Index3 first)
    : grid_(grid), arrays_(std::move(arrays)) {
  if (arrays_.empty()) throw Error(path + ": a volume needs at least one array");
  for (const ArrayInfo& array : arrays_) checkGrid(grid, array.type, array.components, path);
  const std::string extension = extensionOf(path);
  Grid stated = grid;
  if (grid.rim) {
    if (extension != ".vti") throw Error(path + ": samples of cells are written to a .vti only");
    stated = {grid.box().lo, grid.spacing, {}};
    for (size_t a = 0; a < 3; ++a) {
      grid_.points[a] -= 2;
      stated.points[a] = grid_.points[a] + 1;
    }
  }
  const int64_t points = wholeOf(grid_).count();
  if (const std::string raw = rawFileOf(path); !raw.empty()) {
    if (arrays_.size() != 1)
      throw Error(path + ": a " + extension + " file holds one array, not " + std::to_string(arrays_.size()));
    const VolumeDescription description{arrays_[0].type, grid, arrays_[0].components,
                                        std::filesystem::path(raw).filename().string(), false};
    writeText(path, extension == ".vol" ? formatVol(description) : formatVolumeJson(description));
    file_ = std::make_unique<File>(File::create(raw));
    places_ = {0};
    return;
  }
  if (extension != ".vti")
    throw Error(path + ": cannot write this kind of volume: expected .vti, .vol or .json");

  const Extent whole{first, stated.points};
  const std::string list = grid.rim ? "CellData" : "PointData";
  std::string header = fileElement("ImageData") + "  <ImageData " + gridAttributes(stated, whole) +
                       ">\n    <Piece Extent=\"" + extentText(whole) + "\">\n      <" + list + " Scalars=\"" +
                       escaped(arrays_[0].name) + "\">\n";
  int64_t offset = 0;
  std::vector<int64_t> sizes;
  for (const ArrayInfo& array : arrays_) {
    header += "        <DataArray " + arrayAttributes(array) + " format=\"appended\" offset=\"" +
              std::to_string(offset) + "\"/>\n";
    sizes.push_back(points * int64_t(bytesOf(array.type)) * array.components);
    places_.push_back(offset + int64_t(sizeof(uint64_t)));
    offset += int64_t(sizeof(uint64_t)) + sizes.back();
  }
  header += "      </" + list + ">\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n    _";
  file_ = std::make_unique<File>(File::create(path));
  file_->writeAt(0, std::as_bytes(std::span(header)));
  for (size_t i = 0; i < arrays_.size(); ++i) {
    places_[i] += int64_t(header.size());
    const uint64_t size = uint64_t(sizes[i]);
    file_->writeAt(places_[i] - int64_t(sizeof size), std::as_bytes(std::span(&size, 1)));
  }
  const std::string end = "\n  </AppendedData>\n</VTKFile>\n";
  file_->writeAt(int64_t(header.size()) + offset, std::as_bytes(std::span(end)));
}

void VolumeWriter::write(size_t index, int64_t slice, std::span<const std::byte> samples) const {
  const ArrayInfo& array = arrays_.at(index);
  const int64_t bytes = grid_.points[0] * grid_.points[1] * int64_t(bytesOf(array.type)) * array.components;
  if (int64_t(samples.size()) % bytes != 0 || slice < 0 ||
      slice + int64_t(samples.size()) / bytes > grid_.points[2])
    throw Error(file_->path() + ": whole slices inside the grid must be written");
  file_->writeAt(places_[index] + slice * bytes, samples);
}

void VolumeWriter::write(size_t index, const Extent& box, std::span<const std::byte> samples) const {
  const ArrayInfo& array = arrays_.at(index);
  const int64_t point = int64_t(bytesOf(array.type)) * array.components;
  if (!(intersection(box, wholeOf(grid_)) == box) || int64_t(samples.size()) != box.count() * point)
    throw Error(file_->path() + ": the samples of a box inside the grid must be written");
  const bool rows = box.points[0] == grid_.points[0], slices = rows && box.points[1] == grid_.points[1];
  const Index3& n = box.points;
  const int64_t together = slices ? box.count() : rows ? n[0] * n[1] : n[0];  // number of consecutive points
  for (int64_t at = 0; at < box.count(); at += together) {
    const int64_t y = box.first[1] + at % (n[0] * n[1]) / n[0], z = box.first[2] + at / (n[0] * n[1]);
    file_->writeAt(places_[index] + ((z * grid_.points[1] + y) * grid_.points[0] + box.first[0]) * point,
                   samples.subspan(size_t(at * point), size_t(together * point)));
  }
}

void writePvti(const std::string& path, const Grid& grid, const std::vector<ArrayInfo>& arrays,
               const std::vector<ImagePiece>& pieces) {
  std::string text = fileElement("PImageData") + "  <PImageData " + gridAttributes(grid, wholeOf(grid)) +
                     " GhostLevel=\"0\">\n    <PPointData Scalars=\"" + escaped(arrays.at(0).name) + "\">\n";
  for (const ArrayInfo& array : arrays) text += "      <PDataArray " + arrayAttributes(array) + "/>\n";
  text += "    </PPointData>\n";
  for (const ImagePiece& piece : pieces)
    text +=
        "    <Piece Extent=\"" + extentText(piece.extent) + "\" Source=\"" + escaped(piece.file) + "\"/>\n";
  writeText(path, text + "  </PImageData>\n</VTKFile>\n");
}

}  // namespace gxy
