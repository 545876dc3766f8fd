// SPDX-License-Identifier: Apache-2.0
// VTK XML image data (.vti) and its parallel form (.pvti). The XML is read here, so that uncompressed
// appended arrays are read by block from their place in the file; other encodings go through VTK's reader, by
// extent.
#include <vtkDataArray.h>
#include <vtkDataArraySelection.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkXMLImageDataReader.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "gxy/comm/error.h"
#include "gxy/io/raw_samples.h"
#include "gxy/io/volume_description.h"
#include "gxy/io/volume_formats.h"
#include "gxy/io/vtk_messages.h"
#include "gxy/io/vtk_scalars.h"
#include "gxy/io/vtk_xml.h"

namespace gxy {
namespace {

/// The header of a .vti or .pvti: the parsed XML, and what it says about the grid.
struct Header {
  std::string path;
  VtkXml xml;
  vtkXMLDataElement* image = xml.data();  ///< <ImageData> or <PImageData>
  Index3 start{0, 0, 0};                  ///< index of the grid's first point in the file's own numbers
  Grid grid = {};
  bool swap = false, wideSizes = false;
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
  vtkXMLDataElement* root = header.xml.root();
  header.swap = (attribute(root, "byte_order") == "BigEndian") != (std::endian::native == std::endian::big);
  header.wideSizes = attribute(root, "header_type") == "UInt64";

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
  PieceSamples(std::string path, std::vector<Piece> pieces, size_t bytesPerPoint)
      : path_(std::move(path)),
        pieces_(std::move(pieces)),
        bytesPerPoint_(bytesPerPoint),
        read_(pieces_.size()) {}

  uint64_t piecesNotRead() const override { return uint64_t(std::count(read_.begin(), read_.end(), false)); }

  bool readsPartsAlone() const override {
    return std::all_of(pieces_.begin(), pieces_.end(),
                       [](const Piece& piece) { return piece.source->readsPartsAlone(); });
  }

  void read(const Extent& extent, std::span<std::byte> out) const override {
    std::vector<Extent> missing{extent};
    std::vector<std::byte> part;
    for (size_t i = 0; i < pieces_.size(); ++i) {
      const Piece& piece = pieces_[i];
      const Extent shared = intersection(extent, piece.extent);
      // Neighbours share a layer of points: a piece that adds none is not opened.
      const bool adds = std::any_of(missing.begin(), missing.end(),
                                    [&](const Extent& box) { return intersection(box, shared).count() > 0; });
      if (!adds) continue;
      read_[i] = true;
      subtract(missing, shared);
      if (shared == extent) {
        piece.source->read(extent, out);
        continue;
      }
      part.resize(size_t(shared.count()) * bytesPerPoint_);
      piece.source->read(shared, part);
      copyExtent(part, shared, out, extent, bytesPerPoint_);
    }
    if (missing.empty()) return;
    const Index3& p = missing.front().first;
    throw Error(path_ + ": no piece holds point (" + std::to_string(p[0]) + ", " + std::to_string(p[1]) +
                ", " + std::to_string(p[2]) + ")");
  }

 private:
  std::string path_;
  std::vector<Piece> pieces_;
  size_t bytesPerPoint_;
  mutable std::vector<std::atomic<bool>> read_;  ///< by piece
};

/// One array of a .vti in any encoding, through VTK. Indices are relative to `base`, in the file's own
/// numbers.
class VtkSamples final : public SampleSource {
 public:
  VtkSamples(std::shared_ptr<const File> file, ArrayInfo array, Index3 base)
      : file_(std::move(file)), path_(file_->path()), array_(std::move(array)), base_(base) {}

  void read(const Extent& extent, std::span<std::byte> out) const override {
    VtkMessages messages;
    const auto reader = vtkSmartPointer<WithoutFieldData<vtkXMLImageDataReader>>::New();
    reader->SetFileName(file_->opened().c_str());
    reader->UpdateInformation();
    reader->GetPointDataArraySelection()->DisableAllArrays();
    reader->GetPointDataArraySelection()->EnableArray(array_.name.c_str());
    reader->GetCellDataArraySelection()->DisableAllArrays();
    int wanted[6];
    for (size_t a = 0; a < 3; ++a) {
      wanted[2 * a] = int(extent.first[a] + base_[a]);
      wanted[2 * a + 1] = wanted[2 * a] + int(extent.points[a]) - 1;
    }
    reader->vtkAlgorithm::UpdateExtent(wanted);
    messages.check(path_);
    vtkImageData* image = reader->GetOutput();
    vtkDataArray* data = image->GetPointData()->GetArray(array_.name.c_str());
    Extent got;
    for (size_t a = 0; a < 3; ++a) {
      got.first[a] = image->GetExtent()[2 * a] - base_[a];
      got.points[a] = image->GetExtent()[2 * a + 1] - image->GetExtent()[2 * a] + 1;
    }
    if (!data || data->GetNumberOfTuples() != got.count() || !(intersection(got, extent) == extent) ||
        data->GetNumberOfComponents() != array_.components || scalarOfVtk(data->GetDataType()) != array_.type)
      throw Error(path_ + ": array '" + array_.name + "' is not what the header says");
    const size_t point = bytesOf(array_.type) * size_t(array_.components);
    copyExtent({static_cast<const std::byte*>(data->GetVoidPointer(0)), size_t(got.count()) * point}, got,
               out, extent, point);
  }

 private:
  std::shared_ptr<const File> file_;  ///< whose headers were checked
  std::string path_;
  ArrayInfo array_;
  Index3 base_;
};

/// Where the samples of an uncompressed appended array begin; -1 for other encodings.
int64_t appendedPlace(const Header& header, vtkXMLDataElement* entry, int64_t expectedBytes) {
  if (attribute(entry, "format") != "appended" || header.xml.compressed()) return -1;
  vtkXMLDataElement* root = header.xml.root();
  vtkXMLDataElement* appended = root->FindNestedElementWithName("AppendedData");
  if (!appended || attribute(appended, "encoding") != "raw") return -1;
  int64_t place = 0;
  const std::string offset = attribute(entry, "offset");
  if (std::from_chars(offset.data(), offset.data() + offset.size(), place).ec != std::errc() || place < 0 ||
      place > (int64_t(1) << 61))
    throw Error(header.path + ": array '" + attribute(entry, "Name") + "': the offset is not a position");
  place += header.xml.parser()->GetAppendedDataPosition();

  std::byte size[8] = {};
  const size_t width = header.wideSizes ? 8 : 4;
  const std::span<std::byte> bytes(size, width);
  File::open(header.path).readAt(place, bytes);
  if (header.swap) swapBytes(bytes, width);
  uint64_t stated = 0;
  if (header.wideSizes) {
    std::memcpy(&stated, size, 8);
  } else {
    uint32_t narrow = 0;
    std::memcpy(&narrow, size, 4);
    // Writers let the 32-bit size wrap above 4 GiB.
    stated = narrow == uint32_t(expectedBytes) ? uint64_t(expectedBytes) : narrow;
  }
  if (stated != uint64_t(expectedBytes))
    throw Error(header.path + ": array '" + attribute(entry, "Name") + "' has " + std::to_string(stated) +
                " bytes, expected " + std::to_string(expectedBytes));
  return place + int64_t(width);
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
VolumeFile openVtiRelative(const std::string& path, const std::string& wanted, const Index3* base) {
  const Header header = readHeader(path, "ImageData");
  const Index3 origin = base ? *base : header.start;
  VolumeFile file;
  file.path = path;
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
    int64_t place = -1;
    for (int k = 0; k < data->GetNumberOfNestedElements(); ++k)
      if (attribute(data->GetNestedElement(k), "Name") == array.name)
        place = appendedPlace(header, data->GetNestedElement(k), bytes);
    checkCompressed(header, piece, array.name, bytes);
    std::shared_ptr<const SampleSource> source;
    if (place >= 0)
      source =
          std::make_shared<RawSamples>(path, place, extent, array.type, array.components, header.swap, false);
    else
      source = std::make_shared<VtkSamples>(header.xml.file(), array, origin);
    pieces.push_back({extent, std::move(source)});
  }
  if (pieces.empty()) throw Error(path + ": the image has no <Piece>");
  file.source = std::make_shared<PieceSamples>(path, std::move(pieces), file.bytesPerPoint());
  return file;
}

/// A piece of a .pvti, opened when it is first needed: a rank touches the files of its own points only.
class PieceFile final : public SampleSource {
 public:
  PieceFile(std::string path, ArrayInfo array, Index3 base)
      : path_(std::move(path)), array_(std::move(array)), base_(base) {}
  void read(const Extent& extent, std::span<std::byte> out) const override {
    const VolumeFile piece = openVtiRelative(path_, array_.name, &base_);
    if (piece.array.type != array_.type || piece.array.components != array_.components)
      throw Error(path_ + ": array '" + array_.name + "' is not of the type that the .pvti states");
    piece.source->read(extent, out);
  }

 private:
  std::string path_;
  ArrayInfo array_;
  Index3 base_;
};

}  // namespace

VolumeFile openVti(const std::string& path, const std::string& array) {
  return openVtiRelative(path, array, nullptr);
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
    pieces.push_back({extentAttribute(header, piece, "Extent", header.start),
                      std::make_shared<PieceFile>(beside(path, source), file.array, header.start)});
  }
  if (pieces.empty()) throw Error(path + ": the image has no <Piece>");
  file.source = std::make_shared<PieceSamples>(path, std::move(pieces), file.bytesPerPoint());
  return file;
}

}  // namespace gxy
