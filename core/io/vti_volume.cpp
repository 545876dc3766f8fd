// SPDX-License-Identifier: Apache-2.0
// Reads VTK XML image data (.vti) and its parallel form (.pvti). VTK parses the XML; arrays are read
// directly from the file.
#include <algorithm>
#include <atomic>
#include <cstring>

#include "core/comm/error.h"
#include "core/io/image_volume.h"
#include "core/io/raw_samples.h"
#include "core/io/streamed_samples.h"
#include "core/io/volume_formats.h"
#include "core/io/vtk_scalars.h"
#include "core/io/vtk_xml.h"
#include "core/io/vtk_xml_array.h"

namespace gxy {
namespace {

/// The header of a .vti or .pvti: the parsed XML, and the description of the image.
struct Header {
  std::string path;
  VtkXml xml;
  vtkXMLDataElement* element = xml.data();  ///< <ImageData> or <PImageData>
  Index3 start{0, 0, 0};                    ///< index of the image's first point in the file's own numbers
  ImageData image{};
};

/// Returns the extent in an attribute "i0 i1 j0 j1 k0 k1", relative to `base`.
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
  ImageData& image = header.image;
  image.path = path;
  const auto numbers = [&](const char* name, int count, double* value) {
    if (header.element->GetAttribute(name) && header.element->GetVectorAttribute(name, count, value) != count)
      throw Error(path + ": attribute " + name + ": expected " + std::to_string(count) + " numbers");
  };
  numbers("Origin", 3, &image.origin[0]);
  numbers("Spacing", 3, &image.spacing[0]);
  numbers("Direction", 9, image.direction.data());
  const Extent whole = extentAttribute(header, header.element, "WholeExtent", {0, 0, 0});
  header.start = whole.first;
  image.points = whole.points;
  image.origin = image.placeOf(glm::dvec3(whole.first[0], whole.first[1], whole.first[2]));
  return header;
}

const char* listOf(bool ofCells) { return ofCells ? "CellData" : "PointData"; }

/// Returns the numeric arrays that an element lists under <PointData> and <CellData>, or under <PPointData>
/// and <PCellData>.
std::vector<ArrayInfo> arraysOf(const Header& header, vtkXMLDataElement* element, const std::string& prefix) {
  std::vector<ArrayInfo> arrays;
  for (const bool ofCells : {false, true}) {
    vtkXMLDataElement* list = element->FindNestedElementWithName((prefix + listOf(ofCells)).c_str());
    for (int i = 0; list && i < list->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement* entry = list->GetNestedElement(i);
      const auto type = scalarOfXmlWord(attribute(entry, "type"));
      if (!type || attribute(entry, "Name").empty()) continue;
      ArrayInfo info{attribute(entry, "Name"), *type, 1, {}, ofCells};
      if (entry->GetAttribute("NumberOfComponents") &&
          (!entry->GetScalarAttribute("NumberOfComponents", info.components) || info.components < 1))
        throw Error(header.path + ": array '" + info.name +
                    "': NumberOfComponents must be a positive integer");
      Range range;
      if (info.components == 1 && entry->GetScalarAttribute("RangeMin", range.min) &&
          entry->GetScalarAttribute("RangeMax", range.max))
        info.range = range;
      arrays.push_back(info);
    }
  }
  return arrays;
}

void setArrays(Header& header, vtkXMLDataElement* element, const std::string& prefix) {
  header.image.arrays = arraysOf(header, element, prefix);
  for (const bool ofCells : {false, true})
    if (vtkXMLDataElement* list = element->FindNestedElementWithName((prefix + listOf(ofCells)).c_str()))
      (ofCells ? header.image.activeOfCells : header.image.active) = attribute(list, "Scalars");
}

/// Returns the extent of an array's samples in a piece with these points. For arrays of cells, they are the
/// cells between the points.
Extent extentOf(const Extent& points, bool ofCells) {
  Extent extent = points;
  if (ofCells)
    for (int64_t& n : extent.points) n = n > 1 ? n - 1 : n;  // An axis with one point has one cell.
  return extent;
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

/// Samples from several pieces, which may overlap and must cover the wanted boxes.
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
    std::vector<std::vector<Extent>> missing;  // by wanted box: the parts that have not been read
    for (const Extent& w : wanted) missing.push_back({w});
    for (size_t i = 0; i < pieces_.size(); ++i) {
      // Neighbouring pieces share a layer of points. A piece that adds no missing point is not opened.
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
  mutable std::vector<std::atomic<bool>> read_;  ///< by piece: a read has needed it
};

/// Returns the samples of one array of a piece, which have `bytes` bytes. If they are not encoded, they
/// are read directly.
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

/// Returns all arrays with that name in a piece, which may have several lists of arrays.
std::vector<vtkXMLDataElement*> entriesOf(vtkXMLDataElement* piece, const ArrayInfo& array) {
  std::vector<vtkXMLDataElement*> entries;
  for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* list = piece->GetNestedElement(i);
    if (std::strcmp(list->GetName(), listOf(array.ofCells)) != 0) continue;
    for (int k = 0; k < list->GetNumberOfNestedElements(); ++k)
      if (attribute(list->GetNestedElement(k), "Name") == array.name)
        entries.push_back(list->GetNestedElement(k));
  }
  return entries;
}

std::vector<vtkXMLDataElement*> piecesOf(const Header& header) {
  std::vector<vtkXMLDataElement*> pieces;
  for (int i = 0; i < header.element->GetNumberOfNestedElements(); ++i)
    if (std::strcmp(header.element->GetNestedElement(i)->GetName(), "Piece") == 0)
      pieces.push_back(header.element->GetNestedElement(i));
  if (pieces.empty()) throw Error(header.path + ": the image has no <Piece>");
  return pieces;
}

/// Returns an array of a .vti from its pieces, which all must have it. Indices are relative to `base`, which
/// is in the file's own numbers.
std::shared_ptr<const SampleSource> samplesOfVti(const Header& header, const ArrayInfo& array,
                                                 const Index3& base,
                                                 const std::shared_ptr<Decoded>& decoded) {
  std::vector<PieceSamples::Piece> pieces;
  for (vtkXMLDataElement* element : piecesOf(header)) {
    const Extent extent = extentOf(extentAttribute(header, element, "Extent", base), array.ofCells);
    const std::vector<ArrayInfo> arrays = arraysOf(header, element, "");
    const auto same = std::find_if(arrays.begin(), arrays.end(), [&](const ArrayInfo& a) {
      return a.name == array.name && a.ofCells == array.ofCells;
    });
    if (same == arrays.end()) throw Error(header.path + ": a piece has no array '" + array.name + "'");
    if (same->type != array.type || same->components != array.components)
      throw Error(header.path + ": array '" + array.name + "' differs in type between pieces");
    int64_t bytes = int64_t(bytesOf(array.type)) * array.components;
    for (size_t a = 0; a < 3; ++a)
      if (__builtin_mul_overflow(bytes, extent.points[a], &bytes))
        throw Error(header.path + ": a piece is too large");
    const auto entries = entriesOf(element, array);
    for (vtkXMLDataElement* entry : entries) header.xml.checkCompressed(entry, bytes);
    pieces.push_back(
        {extent, bytes > 0 ? samplesOf(header, entries.front(), array, extent, bytes, decoded) : nullptr});
  }
  return std::make_shared<PieceSamples>(header.path, std::move(pieces));
}

/// A piece of a .pvti. It is opened when it is first needed, so that a rank opens only the files with its own
/// points.
class PieceFile final : public SampleSource {
 public:
  PieceFile(std::string path, ArrayInfo array, Index3 base, std::shared_ptr<Decoded> decoded)
      : path_(std::move(path)), array_(std::move(array)), base_(base), decoded_(std::move(decoded)) {}
  void read(std::span<const Extent> wanted, const TakeSamples& take) const override {
    samplesOfVti(readHeader(path_, "ImageData"), array_, base_, decoded_)->read(wanted, take);
  }

 private:
  std::string path_;
  ArrayInfo array_;
  Index3 base_;
  std::shared_ptr<Decoded> decoded_;
};

}  // namespace

VolumeFile openVti(const std::string& path, const std::string& wanted) {
  Header header = readHeader(path, "ImageData");
  setArrays(header, piecesOf(header).front(), "");
  return volumeOf(header.image, wanted, [&](const ArrayInfo& array) {
    return samplesOfVti(header, array, header.start, header.image.decoded);
  });
}

VolumeFile openPvti(const std::string& path, const std::string& wanted) {
  Header header = readHeader(path, "PImageData");
  setArrays(header, header.element, "P");
  return volumeOf(header.image, wanted, [&](const ArrayInfo& array) {
    std::vector<PieceSamples::Piece> pieces;
    for (vtkXMLDataElement* piece : piecesOf(header)) {
      const std::string source = attribute(piece, "Source");
      if (source.empty()) throw Error(path + ": a <Piece> has no attribute Source");
      const Extent extent = extentAttribute(header, piece, "Extent", header.start);
      pieces.push_back(
          {extentOf(extent, array.ofCells),
           std::make_shared<PieceFile>(beside(path, source), array, header.start, header.image.decoded)});
    }
    return std::make_shared<PieceSamples>(path, std::move(pieces));
  });
}

}  // namespace gxy
