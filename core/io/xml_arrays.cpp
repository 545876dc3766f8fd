// SPDX-License-Identifier: Apache-2.0
#include "core/io/xml_arrays.h"

#include <vtkDataSetAttributes.h>

#include <array>
#include <cstring>
#include <sstream>

#include "core/comm/error.h"
#include "core/io/vtk_scalars.h"

namespace gxy {
namespace {

constexpr const char* kCellGroups[] = {"Verts", "Lines", "Strips", "Polys"};

bool isNamed(vtkXMLDataElement* element, std::string_view name) { return element->GetName() == name; }

std::vector<vtkXMLDataElement*> elementsNamed(vtkXMLDataElement* parent, std::string_view name) {
  std::vector<vtkXMLDataElement*> found;
  for (int i = 0; i < parent->GetNumberOfNestedElements(); ++i)
    if (isNamed(parent->GetNestedElement(i), name)) found.push_back(parent->GetNestedElement(i));
  return found;
}

bool holdsNumbers(const VtkXml& xml, vtkXMLDataElement* array) { return xml.statedBytes(array, 1) != 0; }

/// Adds the arrays that the elements with this name list. The active arrays are those of the first element
/// that names some.
void addListed(const VtkXml& xml, vtkXMLDataElement* parent, const char* name, ListedArrays& list) {
  const auto take = [](std::string& active, const std::string& named) {
    if (active.empty()) active = named;
  };
  for (vtkXMLDataElement* group : elementsNamed(parent, name)) {
    take(list.scalars, attribute(group, "Scalars"));
    take(list.normals, attribute(group, "Normals"));
    take(list.textures, attribute(group, "TCoords"));
    for (int i = 0; i < group->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement* array = group->GetNestedElement(i);
      const std::string arrayName = attribute(array, "Name");
      if (arrayName.empty() || !holdsNumbers(xml, array) || list.has(arrayName)) continue;
      int components = 1;
      array->GetScalarAttribute("NumberOfComponents", components);
      const auto type = scalarOfXmlWord(attribute(array, "type"));
      list.arrays.push_back({arrayName, components, type && isColors(arrayName, *type, components)});
    }
  }
}

/// Returns the number of points on each axis of an extent attribute.
std::array<int64_t, 3> pointsOf(vtkXMLDataElement* element, const char* name, const std::string& path) {
  std::istringstream text(attribute(element, name));
  std::array<int64_t, 3> points;
  for (int64_t& n : points) {
    int32_t first = 0, last = 0;
    text >> first >> last;
    n = int64_t(last) - first + 1;
    if (!text || n < 1)
      throw Error(path + ": attribute " + name + ": found '" + attribute(element, name).substr(0, 80) +
                  "', expected the first and the last point of each axis");
  }
  return points;
}

}  // namespace

XmlArrays::XmlArrays(const VtkXml& xml, const std::optional<ArraysNeeded>& needed)
    : xml_(xml), all_(!needed) {
  const std::vector<vtkXMLDataElement*> pieces = elementsNamed(xml.data(), "Piece");
  several_ = pieces.size() > 1;
  if (needed) choose(pieces, *needed);
  const bool lattice = isNamed(xml.data(), "StructuredGrid") || isNamed(xml.data(), "RectilinearGrid");
  if (lattice &&
      (pieces.size() != 1 || attribute(pieces[0], "Extent") != attribute(xml.data(), "WholeExtent")))
    throw Error(xml.path() + ": it has " + std::to_string(pieces.size()) +
                " pieces, expected one whose Extent is the WholeExtent");
  for (vtkXMLDataElement* piece : pieces) lattice ? addLattice(piece) : addPiece(piece);
}

// Chooses the arrays that geometry is made of, as readGeometry() does when all arrays have been read.
void XmlArrays::choose(const std::vector<vtkXMLDataElement*>& pieces, const ArraysNeeded& needed) {
  ListedArrays points, cells;
  for (vtkXMLDataElement* piece : pieces) {
    addListed(xml_, piece, "PointData", points);
    addListed(xml_, piece, "CellData", cells);
  }
  for (const auto& array : points.arrays)
    if (needed.normals && (isNameOfNormals(array.name) || array.name == points.normals))
      chosen_.insert(array.name);
  if (!needed.values.radii.empty()) chosen_.insert(needed.values.radii);
  chosen_.insert(needed.values.fields.begin(), needed.values.fields.end());
  if (const auto values = chooseValues(points, cells, needed.values))
    (values->ofCells ? chosenOfCells_ : chosen_).insert(values->name);
  else
    // The error lists them.
    all_ = (!needed.values.array.empty() || needed.values.ofCells) && !needed.values.orNone;
  all_ = all_ || (!needed.values.radii.empty() && !points.has(needed.values.radii));
  for (const std::string& field : needed.values.fields) all_ = all_ || !points.has(field);
}

bool XmlArrays::isPassedOver(vtkXMLDataElement* array, bool ofCells) const {
  const std::string name = attribute(array, "Name");
  if (!holdsNumbers(xml_, array)) return true;
  return !all_ && name != vtkDataSetAttributes::GhostArrayName() &&
         !(ofCells ? chosenOfCells_ : chosen_).count(name);
}

int64_t XmlArrays::count(vtkXMLDataElement* piece, const char* attribute) const {
  long long n = 0;
  if (piece->GetAttribute(attribute) && (!piece->GetScalarAttribute(attribute, n) || n < 0))
    throw Error(xml_.path() + ": attribute " + attribute + " of a <Piece>: expected a number, 0 or more");
  return n;
}

void XmlArrays::addPiece(vtkXMLDataElement* piece) {
  const int64_t points = count(piece, "NumberOfPoints"), gridCells = count(piece, "NumberOfCells");
  int64_t cells = gridCells;
  for (const char* kind : kCellGroups) {
    const int64_t some = count(piece, (std::string("NumberOf") + kind).c_str());
    cells = sum(cells, some);
    add(some, sizeof(int64_t));  // vtkPolyData's table of cells
    for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i)
      if (isNamed(piece->GetNestedElement(i), kind)) addCells(piece->GetNestedElement(i), some);
  }
  for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* group = piece->GetNestedElement(i);
    if (isNamed(group, "Points") || isNamed(group, "PointData")) addArrays(group, points);
    if (isNamed(group, "CellData")) addArrays(group, cells);
    if (isNamed(group, "Cells")) addCells(group, gridCells);
  }
}

void XmlArrays::addLattice(vtkXMLDataElement* piece) {
  const std::array<int64_t, 3> n = pointsOf(piece, "Extent", xml_.path());
  int64_t points = 1, cells = 1;
  for (int64_t each : n) {
    if (__builtin_mul_overflow(points, each, &points)) tooLarge();
    cells *= std::max<int64_t>(each - 1, 1);
  }
  for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* group = piece->GetNestedElement(i);
    if (isNamed(group, "Points") || isNamed(group, "PointData")) addArrays(group, points);
    if (isNamed(group, "CellData")) addArrays(group, cells);
    if (!isNamed(group, "Coordinates")) continue;
    for (int a = 0; a < group->GetNumberOfNestedElements(); ++a) {
      vtkXMLDataElement* array = group->GetNestedElement(a);
      const int64_t bytes = xml_.statedBytes(array, n[size_t(std::min(a, 2))]);
      xml_.checkFileHolds(array, bytes);
      xml_.checkCompressed(array, bytes);
      add(bytes, 1);
    }
  }
}

void XmlArrays::addArrays(vtkXMLDataElement* group, int64_t tuples) {
  std::set<std::string> names;
  for (int i = 0; i < group->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* array = group->GetNestedElement(i);
    const std::string name = attribute(array, "Name");
    // VTK's readers count all arrays but merge arrays with one name, and then miss others of cells.
    if (isNamed(group, "CellData") && array->GetAttribute("Name") && !names.insert(name).second)
      throw Error(xml_.path() + ": array '" + name + "' is there twice in one list");
    const bool ofCells = isNamed(group, "CellData");
    if (isNamed(group, "Points") ? !holdsNumbers(xml_, array) : isPassedOver(array, ofCells)) {
      (ofCells ? cells_ : points_).insert(name);
      leftOut_ += {.arrays = 1, .bytes = uint64_t(xml_.statedBytes(array, tuples))};
      continue;
    }
    const int64_t bytes = xml_.statedBytes(array, tuples);
    xml_.checkFileHolds(array, bytes);
    xml_.checkCompressed(array, bytes);
    add(bytes, 1);
  }
}

void XmlArrays::addCells(vtkXMLDataElement* group, int64_t cells) {
  for (int i = 0; i < group->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* array = group->GetNestedElement(i);
    const std::string name = attribute(array, "Name");
    if (cells == 0 && name != "types") continue;  // VTK's readers skip these.
    int64_t bytes = 0;
    if (name == "offsets" || name == "types" || name == "faceoffsets") {
      bytes = xml_.statedBytes(array, cells);
      xml_.checkFileHolds(array, bytes);
      xml_.checkCompressed(array, bytes);
    } else if (name == "connectivity" || name == "faces") {
      bytes = xml_.dataBytes(array);  // Its length is the last offset, which is not known yet.
    }
    add(bytes, 1);
    const int64_t each = xml_.statedBytes(array, 1);
    if (each == 0 || name == "types") continue;
    // It is copied to the type of vtkCellArray, and also when the cells of further pieces are appended.
    if (attribute(array, "type") != "Int64" || several_) add(bytes / each, sizeof(int64_t));
  }
}

int64_t XmlArrays::sum(int64_t a, int64_t b) const {
  if (__builtin_add_overflow(a, b, &a)) tooLarge();
  return a;
}

void XmlArrays::add(int64_t n, int64_t each) {
  if (__builtin_mul_overflow(n, each, &n)) tooLarge();
  bytes_ = sum(bytes_, n);
}

void XmlArrays::tooLarge() const { throw Error(xml_.path() + ": its arrays have more than 2^63 bytes"); }

std::vector<std::string> xmlPieces(const std::string& path, const char* type) {
  const VtkXml xml(path, type);
  std::vector<std::string> files;
  // Lists of volumes say more about each piece, and have an element for it.
  for (vtkXMLDataElement* piece : elementsNamed(xml.data(), "Piece"))
    files.push_back(attribute(piece, "Source"));
  files.insert(files.end(), xml.listedPieces().begin(), xml.listedPieces().end());
  for (std::string& file : files) {
    if (file.empty()) throw Error(path + ": a <Piece> has no attribute Source");
    file = beside(path, file);
  }
  return files;
}

std::pair<ListedArrays, ListedArrays> arraysOfXmlList(const std::string& path, const char* type) {
  const VtkXml xml(path, type);
  std::pair<ListedArrays, ListedArrays> lists;
  addListed(xml, xml.data(), "PPointData", lists.first);
  addListed(xml, xml.data(), "PCellData", lists.second);
  return lists;
}

}  // namespace gxy
