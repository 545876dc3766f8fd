// SPDX-License-Identifier: Apache-2.0
#include "core/io/stl_reader.h"

#include <vtkCellArray.h>
#include <vtkPoints.h>

#include <bit>
#include <cctype>
#include <cstring>
#include <optional>

#include "core/io/text_scanner.h"

namespace gxy {
namespace {

constexpr size_t kHeader = 84, kFacet = 50;

/// Returns the little-endian value of 4 bytes at `offset`.
template <class T>
T valueAt(std::string_view bytes, size_t offset) {
  char raw[sizeof(T)];
  std::memcpy(raw, bytes.data() + offset, sizeof raw);
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw, raw + sizeof raw);
  return std::bit_cast<T>(raw);
}

std::string lower(std::string_view word) {
  std::string text(word.substr(0, 40));
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Returns the number of facets of a binary file: the stated one, or, if that is 0, as many as the file has
/// room for. Returns nothing if it is not a binary file.
std::optional<size_t> facetsOfBinary(std::string_view bytes, Flaws& flaws) {
  if (bytes.size() < kHeader) return {};
  const size_t room = (bytes.size() - kHeader) / kFacet, rest = (bytes.size() - kHeader) % kFacet;
  const uint32_t stated = valueAt<uint32_t>(bytes, kHeader - 4);
  if (stated == room && rest == 0) return room;
  // In an ascii file there is text at the place of the number, whose last byte is 0 in a binary file with
  // fewer than 2^24 facets.
  if (stated > room || bytes[kHeader - 1] != 0) return {};
  const size_t facets = stated == 0 ? room : stated;
  const auto place = [&] { return "byte " + std::to_string(kHeader + kFacet * facets); };
  if (stated == 0 && room > 0)
    flaws.add("it states no facets, and is read to its end", [] { return "header"; });
  if (facets < room || rest > 0) flaws.add("what is after the last facet is passed over", place);
  return facets;
}

/// A facet is its normal, three corners, and two bytes of attributes.
void readBinary(std::string_view bytes, size_t facets, vtkPoints* points) {
  points->SetNumberOfPoints(vtkIdType(3 * facets));
  for (size_t i = 0; i < 3 * facets; ++i) {
    const size_t at = kHeader + i / 3 * kFacet + 12 * (1 + i % 3);
    points->SetPoint(vtkIdType(i), valueAt<float>(bytes, at), valueAt<float>(bytes, at + 4),
                     valueAt<float>(bytes, at + 8));
  }
}

/// The file has one or several solids: solid NAME, facets, endsolid NAME. A facet is: facet normal X Y Z,
/// outer loop, 3 times vertex X Y Z, endloop, endfacet.
void readAscii(std::string_view bytes, const std::string& path, vtkPoints* points, Flaws& flaws) {
  TextScanner scanner(bytes, path);
  scanner.passByteOrderMark();
  const auto keyword = [&] { return lower(scanner.word()); };
  const auto expect = [&](std::initializer_list<std::string_view> words) {
    for (std::string_view word : words)
      if (keyword() != word) scanner.fail("expected '" + std::string(word) + "'");
  };
  for (std::string word = keyword(); !word.empty(); word = keyword()) {
    if (word != "solid") scanner.fail("expected 'solid'");
    scanner.lineOfAnyEnd();
    for (word = keyword(); word == "facet"; word = keyword()) {
      expect({"normal"});
      for (int axis = 0; axis < 3; ++axis) {
        double unused = 0;
        if (!TextScanner::parse(scanner.word(), unused))
          flaws.add("a normal that is no number is not used", [&] { return scanner.place(); });
      }
      expect({"outer", "loop"});
      for (int corner = 0; corner < 3; ++corner) {
        expect({"vertex"});
        double p[3];
        for (double& value : p) value = scanner.number<double>("a number");
        points->InsertNextPoint(p);
      }
      expect({"endloop", "endfacet"});
    }
    if (word.empty())
      flaws.add("the file ends without 'endsolid'", [&] { return scanner.place(); });
    else if (word != "endsolid")
      scanner.fail("expected 'facet' or 'endsolid'");
    scanner.lineOfAnyEnd();
  }
}

}  // namespace

vtkSmartPointer<vtkPolyData> readStl(std::string_view bytes, const std::string& path, Flaws& flaws) {
  const auto points = vtkSmartPointer<vtkPoints>::New();
  TextScanner text(bytes, path);
  text.passByteOrderMark();
  if (const auto facets = facetsOfBinary(bytes, flaws)) {
    readBinary(bytes, *facets, points);
  } else if (lower(text.word()) == "solid") {
    readAscii(bytes, path, points, flaws);
  } else {
    const uint64_t stated = bytes.size() < kHeader ? 0 : valueAt<uint32_t>(bytes, kHeader - 4);
    throw Error(path + ": " + std::to_string(bytes.size()) + " bytes for " + std::to_string(stated) +
                " facets: expected a binary STL file of " + std::to_string(kHeader + kFacet * stated) +
                " bytes, or an ascii one that begins with 'solid'");
  }
  const auto triangles = vtkSmartPointer<vtkCellArray>::New();
  for (vtkIdType i = 0; i < points->GetNumberOfPoints(); i += 3) triangles->InsertNextCell({i, i + 1, i + 2});
  const auto mesh = vtkSmartPointer<vtkPolyData>::New();
  mesh->SetPoints(points);
  mesh->SetPolys(triangles);
  return mesh;
}

}  // namespace gxy
