// SPDX-License-Identifier: Apache-2.0
// VTK XML image data (.vti) and its parallel form (.pvti). VTK parses the XML; the arrays are read from the file itself.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "gxy/comm/error.h"
#include "gxy/io/raw_samples.h"
#include "gxy/io/streamed_samples.h"
#include "gxy/io/volume_description.h"
#include "gxy/io/volume_formats.h"
#include "gxy/io/vtk_scalars.h"
#include "gxy/io/vtk_xml.h"
#include "gxy/io/vtk_xml_array.h"

namespace gxy {
namespace {

/// The header of a .vti or .pvti: the parsed XML, and what it says about the grid.
struct Header {
  std::string path;
  VtkXml xml;
  vtkXMLDataElement* image = xml.data();  ///< <ImageData> or <PImageData>
  Index3 start{0, 0, 0};                  ///< index of the grid's first point in the file's own numbers
  Grid grid = {};
};

/// The extent "i0 i1 j0 j1 k0 k1" relative to `base`.
Extent extentAttribute(const Header& header, vtkXMLDataElement* element, const char* name,
                       const Index3& base) {
  int e[6];
  if (element->GetVectorAttribute(name, 6, e) != 6)
    throw Error(header.path + ": <" + element->GetName() + "> needs an attribute " + name +
                " of six integers");
  Extent extent;
  for (size_t a = 0; a < 3; ++a) {
    extent.first[a] = int64_t(e[2 * a]) - base[a];
    extent.points[a] = std::max(int64_t(0), int64_t(e[2 * a + 1]) - e[2 * a] + 1);
  }
  return extent;
}

Header readHeader(const std::string& path, const char* type) {
  Header header{path, VtkXml(path, type)};
  const Extent whole = extentAttribute(header, header.image, "WholeExtent", {0, 0, 0});
  double origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1}, direction[9];
  const auto vector = [&](const char* name, double* value) {
    if (header.image->GetAttribute(name) && header.image->GetVectorAttribute(name, 3, value) != 3)
      throw Error(path + ": attribute " + name + ": expected three numbers");
  };
  vector("Origin", origin);
  vector("Spacing", spacing);
  if (header.image->GetVectorAttribute("Direction", 9, direction) == 9)
    for (int i = 0; i < 9; ++i)
      if (direction[i] != (i % 4 == 0))
        throw Error(path +
                    ": the image is rotated (attribute Direction); only axis-parallel grids are supported");
  header.start = whole.first;
  header.grid.points = whole.points;
  for (int a = 0; a < 3; ++a) {
    header.grid.spacing[a] = spacing[a];
    header.grid.origin[a] = origin[a] + spacing[a] * double(whole.first[size_t(a)]);
  }
  return header;
}

/// The numeric arrays listed under a <PointData> or <PPointData>, the chosen one among them.
ArrayInfo chooseListed(const Header& header, vtkXMLDataElement* list, const std::string& wanted,
                       std::vector<ArrayInfo>& arrays) {
  for (int i = 0; list && i < list->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* entry = list->GetNestedElement(i);
    const auto type = scalarOfXmlWord(attribute(entry, "type"));
    if (!type || attribute(entry, "Name").empty()) continue;
    ArrayInfo info{attribute(entry, "Name"), *type, 1, {}};
    if (entry->GetAttribute("NumberOfComponents") &&
        (!entry->GetScalarAttribute("NumberOfComponents", info.components) || info.components < 1))
      throw Error(header.path + ": array '" + info.name + "': NumberOfComponents must be a positive integer");
    Range range;
    if (info.components == 1 && entry->GetScalarAttribute("RangeMin", range.min) &&
        entry->GetScalarAttribute("RangeMax", range.max))
      info.range = range;
    arrays.push_back(info);
  }
  const ArrayInfo chosen = chooseArray(arrays, wanted, list ? attribute(list, "Scalars") : "", header.path);
  checkGrid(header.grid, chosen.type, chosen.components, header.path);
  return chosen;
}

/// Removes `hole` from a set of disjoint boxes.
void subtract(std::vector<Extent>& boxes, const Extent& hole) {
  std::vector<Extent> rest;
  for (Extent box : boxes) {
    const Extent cut = intersection(box, hole);
    if (cut.count() == 0) {
      rest.push_back(box);
      continue;
    }
    for (size_t a = 0; a < 3; ++a) {
      Extent below = box, above = box;
      below.points[a] = cut.first[a] - box.first[a];
      above.first[a] = cut.first[a] + cut.points[a];
      above.points[a] = box.first[a] + box.points[a] - above.first[a];
      if (below.points[a] > 0) rest.push_back(below);
      if (above.points[a] > 0) rest.push_back(above);
      box.first[a] = cut.first[a];
      box.points[a] = cut.points[a];
    }
  }
  boxes = std::move(rest);
}

/// Samples put together from pieces, which may overlap and must cover what is asked for.
class PieceSamples final : public SampleSource {
 public:
  struct Piece {
    Extent extent;
    std::shared_ptr<const SampleSource> source;
  };
  PieceSamples(std::string path, std::vector<Piece> pieces)
      : path_(std::move(path)), pieces_(std::move(pieces)), read_(pieces_.size()) {}

  uint64_t piecesNotRead() const override { return uint64_t(std::count(read_.begin(), read_.end(), false)); }

  void read(std::span<const Extent> wanted, const TakeSamples& take) const override {
    std::vector<std::vector<Extent>> missing;  // of each box that is wanted
    for (const Extent& w : wanted) missing.push_back({w});
    for (size_t i = 0; i < pieces_.size(); ++i) {
      // Neighbours share a layer of points: a piece that adds none is not opened.
      std::vector<Extent> here;
      std::vector<size_t> of;
      for (size_t w = 0; w < missing.size(); ++w) {
        for (const Extent& box : missing[w])
          if (const Extent both = intersection(box, pieces_[i].extent); both.count() > 0) {
            here.push_back(both);
            of.push_back(w);
          }
        subtract(missing[w], pieces_[i].extent);
      }
      if (here.empty()) continue;
      read_[i] = true;
      pieces_[i].source->read(here, [&](const SamplesRead& some) {
        take({of[some.wanted], some.points, some.layout, some.samples});
      });
    }
    for (const auto& boxes : missing)
      for (const Extent& box : boxes)
        if (box.count() > 0)
          throw Error(path_ + ": no piece holds point (" + std::to_string(box.first[0]) + ", " +
                      std::to_string(box.first[1]) + ", " + std::to_string(box.first[2]) + ")");
  }

 private:
  std::string path_;
  std::vector<Piece> pieces_;
  mutable std::vector<std::atomic<bool>> read_;  ///< by piece
};

/// The samples of one array of a piece, which takes `bytes` bytes. What is not encoded is read from its place.
std::shared_ptr<const SampleSource> samplesOf(const Header& header, vtkXMLDataElement* entry,
                                              const ArrayInfo& array, const Extent& extent, int64_t bytes,
                                              const std::shared_ptr<Decoded>& decoded) {
  auto data = xmlArrayBytes(header.xml, entry, array.type, bytes);
  const XmlPlace place = header.xml.placeOf(entry);
  const bool swap = header.xml.swapsBytes();
  if (place.form == XmlPlace::Form::Raw && !header.xml.compressed())
    return std::make_shared<RawSamples>(header.xml.file(), place.position + header.xml.headerWordBytes(),
                                        extent, array.type, array.components, swap, false);
  return std::make_shared<StreamedSamples>(std::move(data), extent, array.type, array.components,
                                           swap && place.form != XmlPlace::Form::Text,
                                           header.path + ": array '" + array.name + "'", decoded);
}

/// Every array of that name in a piece: of two lists of arrays VTK's reader may take the other.
void checkCompressed(const Header& header, vtkXMLDataElement* piece, const std::string& name, int64_t bytes) {
  for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* list = piece->GetNestedElement(i);
    if (std::strcmp(list->GetName(), "PointData") != 0) continue;
    for (int k = 0; k < list->GetNumberOfNestedElements(); ++k)
      if (attribute(list->GetNestedElement(k), "Name") == name)
        header.xml.checkCompressed(list->GetNestedElement(k), bytes);
  }
}

/// Opens a .vti; the indices that its source takes are relative to `base`, in the file's own numbers.
VolumeFile openVtiRelative(const std::string& path, const std::string& wanted, const Index3* base,
                           const std::shared_ptr<Decoded>& decoded) {
  const Header header = readHeader(path, "ImageData");
  const Index3 origin = base ? *base : header.start;
  VolumeFile file;
  file.path = path;
  file.decoded = decoded;
  file.grid = header.grid;
  std::vector<PieceSamples::Piece> pieces;
  for (int i = 0; i < header.image->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* piece = header.image->GetNestedElement(i);
    if (std::strcmp(piece->GetName(), "Piece") != 0) continue;
    vtkXMLDataElement* data = piece->FindNestedElementWithName("PointData");
    std::vector<ArrayInfo> arrays;
    const ArrayInfo array = chooseListed(header, data, wanted.empty() ? file.array.name : wanted, arrays);
    if (pieces.empty()) {
      file.arrays = arrays;
      file.array = array;
    } else if (array.type != file.array.type || array.components != file.array.components) {
      throw Error(path + ": array '" + array.name + "' differs in type between pieces");
    } else if (file.array.range && array.range) {
      file.array.range->extend(*array.range);
    }
    const Extent extent = extentAttribute(header, piece, "Extent", origin);
    checkGrid({header.grid.origin, header.grid.spacing, {2, 2, 2}}, array.type, array.components, path);
    int64_t bytes = int64_t(file.bytesPerPoint());
    for (size_t a = 0; a < 3; ++a)
      if (__builtin_mul_overflow(bytes, extent.points[a], &bytes))
        throw Error(path + ": a piece is too large");
    checkCompressed(header, piece, array.name, bytes);
    pieces.push_back({extent, nullptr});
    for (int k = 0; bytes > 0 && !pieces.back().source && k < data->GetNumberOfNestedElements(); ++k)
      if (attribute(data->GetNestedElement(k), "Name") == array.name)
        pieces.back().source = samplesOf(header, data->GetNestedElement(k), array, extent, bytes, decoded);
  }
  if (pieces.empty()) throw Error(path + ": the image has no <Piece>");
  file.source = std::make_shared<PieceSamples>(path, std::move(pieces));
  return file;
}

/// A piece of a .pvti, opened when it is first needed: a rank touches the files of its own points only.
class PieceFile final : public SampleSource {
 public:
  PieceFile(std::string path, ArrayInfo array, Index3 base, std::shared_ptr<Decoded> decoded)
      : path_(std::move(path)), array_(std::move(array)), base_(base), decoded_(std::move(decoded)) {}
  void read(std::span<const Extent> wanted, const TakeSamples& take) const override {
    const VolumeFile piece = openVtiRelative(path_, array_.name, &base_, decoded_);
    if (piece.array.type != array_.type || piece.array.components != array_.components)
      throw Error(path_ + ": array '" + array_.name + "' is not of the type that the .pvti states");
    piece.source->read(wanted, take);
  }

 private:
  std::string path_;
  ArrayInfo array_;
  Index3 base_;
  std::shared_ptr<Decoded> decoded_;
};

}  // namespace

VolumeFile openVti(const std::string& path, const std::string& array) {
  return openVtiRelative(path, array, nullptr, std::make_shared<Decoded>());
}

VolumeFile openPvti(const std::string& path, const std::string& wanted) {
  const Header header = readHeader(path, "PImageData");
  VolumeFile file;
  file.path = path;
  file.grid = header.grid;
  file.array =
      chooseListed(header, header.image->FindNestedElementWithName("PPointData"), wanted, file.arrays);
  std::vector<PieceSamples::Piece> pieces;
  for (int i = 0; i < header.image->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* piece = header.image->GetNestedElement(i);
    if (std::strcmp(piece->GetName(), "Piece") != 0) continue;
    const std::string source = attribute(piece, "Source");
    if (source.empty()) throw Error(path + ": a <Piece> has no attribute Source");
    pieces.push_back(
        {extentAttribute(header, piece, "Extent", header.start),
         std::make_shared<PieceFile>(beside(path, source), file.array, header.start, file.decoded)});
  }
  if (pieces.empty()) throw Error(path + ": the image has no <Piece>");
  file.source = std::make_shared<PieceSamples>(path, std::move(pieces));
  return file;
}

}  // namespace gxy
