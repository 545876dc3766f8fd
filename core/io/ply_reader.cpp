// SPDX-License-Identifier: Apache-2.0
#include "core/io/ply_reader.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "core/io/color_arrays.h"
#include "core/io/text_scanner.h"

namespace gxy {
namespace {

enum class PlyEncoding { Ascii, LittleEndian, BigEndian };

struct PlyType {
  std::string_view name, otherName;
  size_t bytes;
  bool integer, isSigned;
};
constexpr PlyType kPlyTypes[] = {{"char", "int8", 1, true, true},      {"uchar", "uint8", 1, true, false},
                                 {"short", "int16", 2, true, true},    {"ushort", "uint16", 2, true, false},
                                 {"int", "int32", 4, true, true},      {"uint", "uint32", 4, true, false},
                                 {"float", "float32", 4, false, true}, {"double", "float64", 8, false, true}};

struct Property {
  std::string name;
  const PlyType* type = nullptr;
  const PlyType* count = nullptr;  ///< type of a list's length; null: this is no list
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;

  const Property* find(std::string_view wanted) const {
    for (const Property& p : properties)
      if (p.name == wanted) return &p;
    return nullptr;
  }
  bool hasScalar(std::string_view wanted) const {
    const Property* p = find(wanted);
    return p && !p->count;
  }
};

/// Reads the values of the body one after the other.
class Values {
 public:
  Values(TextScanner& scanner, PlyEncoding encoding) : scanner_(scanner), encoding_(encoding) {}

  double next(const PlyType& type) {
    if (encoding_ != PlyEncoding::Ascii) return binary(type, scanner_.take(type.bytes, "its last element"));
    const double value = scanner_.number<double>(type.integer ? "an integer" : "a number");
    if (type.integer) {
      const double half = std::ldexp(1., int(8 * type.bytes) - 1);
      const double low = type.isSigned ? -half : 0, high = type.isSigned ? half : 2 * half;
      if (!(value >= low && value < high) || value != std::floor(value))
        scanner_.fail("expected an integer of type " + std::string(type.name));
    }
    return value;
  }

  /// Throws Error if the rest of the file is too short for the element's count, given the least size of each.
  void checkCount(const Element& element) const {
    uint64_t least = 0;
    for (const Property& p : element.properties)
      least += encoding_ == PlyEncoding::Ascii ? 2 : p.count ? p.count->bytes : p.type->bytes;
    const uint64_t bytes =
        scanner_.left() + (encoding_ == PlyEncoding::Ascii ? 1 : 0);  // The last line may have no end.
    if (element.count > bytes / least)
      scanner_.fail("the file ends too early: it has " + std::to_string(scanner_.left()) +
                    " bytes left for " + std::to_string(element.count) + " elements '" + element.name +
                    "' of at least " + std::to_string(least) + " bytes each");
  }

  /// Reads the length of a list.
  uint64_t listLength(const Property& list, const Element& element, uint64_t i) {
    const double length = next(*list.count);
    if (!(length >= 0))
      fail(element, i, "list '" + list.name + "' has " + std::to_string(int64_t(length)) + " entries");
    const uint64_t bytes = uint64_t(length) * (encoding_ == PlyEncoding::Ascii ? 2 : list.type->bytes);
    if (bytes > scanner_.left() + 1)
      fail(element, i,
           "the file ends within list '" + list.name + "' of " + std::to_string(uint64_t(length)) +
               " entries");
    return uint64_t(length);
  }

  void skip(const Property& property, const Element& element, uint64_t i) {
    const uint64_t values = property.count ? listLength(property, element, i) : 1;
    for (uint64_t v = 0; v < values; ++v) next(*property.type);
  }

  [[noreturn]] void fail(const Element& element, uint64_t i, const std::string& what) const {
    const std::string text = element.name + " " + std::to_string(i) + ": " + what;
    if (encoding_ == PlyEncoding::Ascii) scanner_.fail(text);
    throw Error(scanner_.path() + ": " + text);
  }

 private:
  double binary(const PlyType& type, std::string_view bytes) const {
    char raw[8];
    std::memcpy(raw, bytes.data(), type.bytes);
    if ((encoding_ == PlyEncoding::BigEndian) != (std::endian::native == std::endian::big))
      std::reverse(raw, raw + type.bytes);
    const auto as = [&]<class T>(T value) {
      std::memcpy(&value, raw, sizeof value);
      return double(value);
    };
    switch (type.bytes) {
      case 1:
        return type.isSigned ? as(int8_t()) : as(uint8_t());
      case 2:
        return type.isSigned ? as(int16_t()) : as(uint16_t());
      case 4:
        return !type.integer ? as(float()) : type.isSigned ? as(int32_t()) : as(uint32_t());
      default:
        return as(double());
    }
  }

  TextScanner& scanner_;
  PlyEncoding encoding_;
};

const PlyType& typeNamed(std::string_view name, const TextScanner& header) {
  for (const PlyType& type : kPlyTypes)
    if (name == type.name || name == type.otherName) return type;
  header.fail("'" + std::string(name.substr(0, 40)) + "' is not a type of PLY");
}

PlyEncoding readFormat(TextScanner& header, TextScanner line) {
  const std::string_view encoding = line.word(), version = line.word();
  if (version == "1.0") {
    if (encoding == "ascii") return PlyEncoding::Ascii;
    if (encoding == "binary_little_endian") return PlyEncoding::LittleEndian;
    if (encoding == "binary_big_endian") return PlyEncoding::BigEndian;
  }
  header.fail("expected format ascii, binary_little_endian or binary_big_endian, version 1.0");
}

Property readProperty(TextScanner& header, TextScanner line) {
  Property property;
  std::string_view type = line.word();
  if (type == "list") {
    property.count = &typeNamed(line.word(), header);
    if (!property.count->integer) header.fail("a list is counted by a number that is not an integer");
    type = line.word();
  }
  property.type = &typeNamed(type, header);
  property.name = line.word();
  if (property.name.empty()) header.fail("a property has no name");
  return property;
}

struct Header {
  PlyEncoding encoding = PlyEncoding::Ascii;
  std::vector<Element> elements;

  const Element* find(std::string_view name) const {
    for (const Element& e : elements)
      if (e.name == name) return &e;
    return nullptr;
  }
};

Header readHeader(TextScanner& scanner, const std::string& path) {
  if (scanner.line() != "ply") scanner.fail("expected the line 'ply'");
  Header header;
  std::optional<PlyEncoding> encoding;
  while (true) {
    if (!scanner.left()) scanner.fail("the file ends within its header: expected 'end_header'");
    TextScanner line(scanner.line(), path);
    const std::string_view word = line.word();
    if (word == "end_header") break;
    if (word == "format") {
      encoding = readFormat(scanner, line);
    } else if (word == "element") {
      Element element;
      element.name = line.word();
      if (!TextScanner::parse(line.word(), element.count))
        scanner.fail("element '" + element.name + "' has no valid count: expected an integer from 0 on");
      if (header.find(element.name)) scanner.fail("a second element '" + element.name + "'");
      header.elements.push_back(std::move(element));
    } else if (word == "property") {
      if (header.elements.empty()) scanner.fail("a property that belongs to no element");
      Property property = readProperty(scanner, line);
      Element& element = header.elements.back();
      if (element.find(property.name)) scanner.fail("a second property '" + property.name + "'");
      element.properties.push_back(std::move(property));
    } else if (word != "comment" && word != "obj_info") {
      scanner.fail("expected format, element, property, comment or end_header, found '" +
                   std::string(word.substr(0, 40)) + "'");
    }
  }
  if (!encoding) scanner.fail("the header has no line 'format'");
  header.encoding = *encoding;
  return header;
}

/// Returns the properties of an element that are the components of its colours; none if it has no colours.
std::vector<const Property*> colorsOf(const Element& element) {
  constexpr std::array<const char*, 4> kNames[] = {
      {"red", "green", "blue", "alpha"},
      {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"},
      {"r", "g", "b", "a"}};
  for (const auto& names : kNames) {
    std::vector<const Property*> found;
    for (const char* name : names)
      if (const Property* p = element.find(name);
          p && !p->count && (found.empty() || p->type == found[0]->type))
        found.push_back(p);
    if (found.size() >= 3 && found[2]->name == names[2]) return found;
  }
  return {};
}

/// Returns the largest value of a component, for scaleColors().
double fullOf(const PlyType& type) {
  if (!type.integer) return 0;
  return type.bytes == 2 && !type.isSigned ? 65535 : 255;
}

/// The arrays that the properties of a vertex are stored in.
struct PointArrays {
  struct Target {
    vtkFloatArray* array = nullptr;  ///< null: a coordinate of the point if `component` >= 0, else unused
    int component = -1;
  };
  std::vector<Target> targets;            ///< one for each property
  vtkSmartPointer<vtkFloatArray> colors;  ///< null: there are none
  double full = 0;                        ///< largest value of their components, for scaleColors()

  PointArrays(const Element& vertex, vtkPointData* data)
      : targets(vertex.properties.size()), vertex_(vertex) {
    for (int axis = 0; axis < 3; ++axis) target(std::string(1, char('x' + axis))).component = axis;
    if (vtkFloatArray* normals = add(data, "Normals", {"nx", "ny", "nz"})) data->SetNormals(normals);
    for (const auto& names : {std::array{"u", "v"}, {"texture_u", "texture_v"}, {"s", "t"}})
      if (vtkFloatArray* coordinates = add(data, "TCoords", {names[0], names[1]})) {
        data->SetTCoords(coordinates);
        break;
      }
    const std::vector<const Property*> components = colorsOf(vertex);
    if (!components.empty()) {
      colors = makeColors(int(components.size()), vtkIdType(vertex.count));
      data->SetScalars(colors);
      for (size_t c = 0; c < components.size(); ++c) target(components[c]->name) = {colors, int(c)};
      full = fullOf(*components[0]->type);
    }
    for (size_t p = 0; p < targets.size(); ++p)
      if (targets[p].component < 0 && !vertex.properties[p].count &&
          !data->HasArray(vertex.properties[p].name.c_str()))
        add(data, vertex.properties[p].name, {vertex.properties[p].name});
  }

 private:
  Target& target(std::string_view name) {
    return targets[size_t(vertex_.find(name) - vertex_.properties.data())];
  }

  /// Adds an array of these properties; returns null, and adds none, unless all of them are scalars of the vertex.
  vtkFloatArray* add(vtkPointData* data, const std::string& name,
                     const std::vector<std::string>& properties) {
    for (const std::string& p : properties)
      if (!vertex_.hasScalar(p)) return nullptr;
    const auto array = vtkSmartPointer<vtkFloatArray>::New();
    array->SetName(name.c_str());
    array->SetNumberOfComponents(int(properties.size()));
    array->SetNumberOfTuples(vtkIdType(vertex_.count));
    data->AddArray(array);
    for (size_t c = 0; c < properties.size(); ++c) target(properties[c]) = {array, int(c)};
    return array;
  }

  const Element& vertex_;
};

void readVertices(Values& values, const Element& vertex, vtkPolyData* mesh) {
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(vtkIdType(vertex.count));
  const PointArrays arrays(vertex, mesh->GetPointData());
  for (uint64_t i = 0; i < vertex.count; ++i) {
    double point[3];
    for (size_t p = 0; p < vertex.properties.size(); ++p) {
      const auto [array, component] = arrays.targets[p];
      if (component < 0)
        values.skip(vertex.properties[p], vertex, i);
      else if (array)
        array->SetTypedComponent(vtkIdType(i), component, float(values.next(*vertex.properties[p].type)));
      else
        point[component] = values.next(*vertex.properties[p].type);
    }
    points->SetPoint(vtkIdType(i), point);
  }
  if (arrays.colors) scaleColors(arrays.colors, arrays.full);
  mesh->SetPoints(points);
}

/// Reads cells from lists of vertices. If these are strips, -1 ends a strip. `components` become the
/// components of `colors`.
vtkSmartPointer<vtkCellArray> readCells(Values& values, const Element& element, const Property* corners,
                                        uint64_t points, bool strips,
                                        const std::vector<const Property*>& components = {},
                                        vtkFloatArray* colors = nullptr) {
  const auto cells = vtkSmartPointer<vtkCellArray>::New();
  std::vector<vtkIdType> ids;
  const auto end = [&] {
    if (!strips || ids.size() > 2) cells->InsertNextCell(vtkIdType(ids.size()), ids.data());
    ids.clear();
  };
  for (uint64_t i = 0; i < element.count; ++i)
    for (const Property& property : element.properties) {
      if (&property != corners) {
        const auto component = std::find(components.begin(), components.end(), &property);
        if (component == components.end())
          values.skip(property, element, i);
        else
          colors->SetTypedComponent(vtkIdType(i), int(component - components.begin()),
                                    float(values.next(*property.type)));
        continue;
      }
      for (uint64_t left = values.listLength(property, element, i); left > 0; --left) {
        const auto id = vtkIdType(values.next(*property.type));
        if (strips && id == -1) {
          end();
          continue;
        }
        if (id < 0 || uint64_t(id) >= points)
          values.fail(element, i, "refers to vertex " + std::to_string(id) + " of " + std::to_string(points));
        ids.push_back(id);
      }
      end();
    }
  return cells;
}

void readPolygons(Values& values, const Element& face, const Property* corners, uint64_t points, bool strips,
                  vtkPolyData* mesh, Flaws& flaws) {
  std::vector<const Property*> components = colorsOf(face);
  if (strips && !components.empty()) {
    flaws.add("colours of faces are passed over beside strips, which have none", [] { return "header"; });
    components.clear();
  }
  if (components.empty()) return mesh->SetPolys(readCells(values, face, corners, points, false));
  const auto colors = makeColors(int(components.size()), vtkIdType(face.count));
  mesh->SetPolys(readCells(values, face, corners, points, false, components, colors));
  scaleColors(colors, fullOf(*components[0]->type));
  mesh->GetCellData()->SetScalars(colors);
}

/// Returns the property of an element that lists vertices; null if there is no such element.
const Property* cornersOf(const Element* element, const std::string& path) {
  if (!element) return nullptr;
  const Property* corners = element->find("vertex_indices");
  if (!corners) corners = element->find("vertex_index");
  if (!corners || !corners->count || !corners->type->integer)
    throw Error(path + ": element '" + element->name +
                "': expected a property list of integers 'vertex_indices'");
  return corners;
}

}  // namespace

vtkSmartPointer<vtkPolyData> readPly(std::string_view bytes, const std::string& path, Flaws& flaws) {
  TextScanner scanner(bytes, path);
  const Header header = readHeader(scanner, path);
  const Element* vertex = header.find("vertex");
  if (!vertex) throw Error(path + ": the header has no element 'vertex'");
  for (const char* axis : {"x", "y", "z"})
    if (!vertex->hasScalar(axis))
      throw Error(path + ": element 'vertex': expected a property '" + axis + "' that is a number" +
                  (vertex->find(axis) ? ", found a list" : ", found none"));
  const Element *face = header.find("face"), *strip = header.find("tristrips");
  const Property *corners = cornersOf(face, path), *stripCorners = cornersOf(strip, path);
  const auto mesh = vtkSmartPointer<vtkPolyData>::New();
  Values values(scanner, header.encoding);
  for (const Element& element : header.elements) {
    if (element.properties.empty() && element.count)
      throw Error(path + ": element '" + element.name + "' has no properties");
    if (element.count) values.checkCount(element);
    if (&element == vertex)
      readVertices(values, element, mesh);
    else if (&element == face)
      readPolygons(values, element, corners, vertex->count, strip != nullptr, mesh, flaws);
    else if (&element == strip)
      mesh->SetStrips(readCells(values, element, stripCorners, vertex->count, true));
    else
      for (uint64_t i = 0; i < element.count; ++i)
        for (const Property& property : element.properties) values.skip(property, element, i);
  }
  return mesh;
}

}  // namespace gxy
