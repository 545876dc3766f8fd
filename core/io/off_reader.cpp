// SPDX-License-Identifier: Apache-2.0
#include "core/io/off_reader.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <array>
#include <vector>

#include "core/io/color_arrays.h"
#include "core/io/text_scanner.h"

namespace gxy {
namespace {

/// The lines of a file that are not empty, without comments.
class OffLines {
 public:
  OffLines(std::string_view bytes, const std::string& path) : file_(bytes, path) {
    file_.passByteOrderMark();
  }

  /// Returns the next line. `what` says in errors what was expected there.
  TextScanner next(const std::string& what) {
    while (file_.left()) {
      std::string_view text = file_.lineOfAnyEnd();
      text = text.substr(0, text.find('#'));
      if (text.find_first_not_of(" \t") != std::string_view::npos) return {text, file_.path()};
    }
    file_.fail("the file ends, expected " + what);
  }
  /// Reads the next word of a line as a number.
  template <class T>
  T number(TextScanner& line, const char* what) {
    const std::string_view word = line.word();
    T value{};
    if (!TextScanner::parse(word, value))
      file_.fail((word.empty() ? "the line ends" : "found '" + std::string(word.substr(0, 40)) + "'") +
                 ", expected " + what);
    return value;
  }
  const TextScanner& file() const { return file_; }

 private:
  TextScanner file_;
};

struct OffHeader {
  bool textures = false, colors = false, normals = false;
  size_t vertices = 0, faces = 0;
};

void readCounts(OffLines& lines, TextScanner line, size_t bytes, OffHeader& header) {
  header.vertices = lines.number<size_t>(line, "the number of vertices");
  header.faces = lines.number<size_t>(line, "the number of faces");
  // The shortest lines of a vertex and a face are "0 0 0" and "1 0", each with an end of line.
  if (header.vertices > bytes / 6 + 1 || header.faces > bytes / 4 + 1)
    lines.file().fail(std::to_string(header.vertices) + " vertices and " + std::to_string(header.faces) +
                      " faces are more than the file's " + std::to_string(bytes) + " bytes can hold");
}

OffHeader readHeader(OffLines& lines, size_t bytes) {
  OffHeader header;
  const TextScanner first = lines.next("OFF");
  TextScanner afterKeyword = first;
  std::string_view marks = afterKeyword.word();
  if (!marks.ends_with("OFF")) {
    readCounts(lines, first, bytes, header);
    return header;
  }
  const std::string keyword(marks);
  marks.remove_suffix(3);
  const auto has = [&marks](std::string_view mark) {
    const bool there = marks.starts_with(mark);
    if (there) marks.remove_prefix(mark.size());
    return there;
  };
  header.textures = has("ST");
  header.colors = has("C");
  header.normals = has("N");
  TextScanner rest = afterKeyword;
  const std::string_view next = rest.word();
  if (!marks.empty() || next == "BINARY")
    lines.file().fail("found '" + keyword + (next == "BINARY" ? " BINARY" : "") +
                      "', expected OFF with ST, C or N before it, as text and of 3 dimensions");
  readCounts(lines, next.empty() ? lines.next("the numbers of vertices, faces and edges") : afterKeyword,
             bytes, header);
  return header;
}

void readVertices(OffLines& lines, const OffHeader& header, vtkPolyData* mesh, Flaws& flaws) {
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(vtkIdType(header.vertices));
  const auto normals = vtkSmartPointer<vtkFloatArray>::New();
  normals->SetName("Normals");
  normals->SetNumberOfComponents(3);
  if (header.normals) normals->SetNumberOfTuples(vtkIdType(header.vertices));
  FoundColors colors;
  for (vtkIdType v = 0; v < vtkIdType(header.vertices); ++v) {
    TextScanner line =
        lines.next("vertex " + std::to_string(v + 1) + " of " + std::to_string(header.vertices));
    double p[3];
    for (double& x : p) x = lines.number<double>(line, "a coordinate");
    points->SetPoint(v, p);
    for (int axis = 0; header.normals && axis < 3; ++axis)
      normals->SetComponent(v, axis, lines.number<double>(line, "a normal's component"));
    std::vector<float> more = numbersLeft(line);
    if (header.textures) more.resize(std::max<size_t>(more.size(), 2) - 2);
    if (header.colors ? !colors.set(size_t(v), more) : !more.empty())
      flaws.add(header.colors ? "a vertex whose colour is not three or four numbers has none"
                              : "what follows a vertex is passed over",
                [&] { return lines.file().place(); });
  }
  mesh->SetPoints(points);
  mesh->GetPointData()->SetScalars(
      colors.array(vtkIdType(header.vertices), [](vtkIdType p) { return size_t(p); }));
  if (header.normals) mesh->GetPointData()->SetNormals(normals);
}

void readFaces(OffLines& lines, const OffHeader& header, vtkPolyData* mesh, Flaws& flaws) {
  const auto faces = vtkSmartPointer<vtkCellArray>::New();
  std::vector<vtkIdType> corners;
  FoundColors colors;
  for (size_t f = 0; f < header.faces; ++f) {
    TextScanner line = lines.next("face " + std::to_string(f + 1) + " of " + std::to_string(header.faces));
    const size_t count = lines.number<size_t>(line, "the number of corners");
    if (count > line.left())
      lines.file().fail("the line ends before the " + std::to_string(count) + " corners");
    corners.clear();
    for (size_t c = 0; c < count; ++c) {
      const size_t vertex = lines.number<size_t>(line, "a vertex, counted from 0 on");
      if (vertex >= header.vertices)
        lines.file().fail("face " + std::to_string(f) + " refers to vertex " + std::to_string(vertex) +
                          " of " + std::to_string(header.vertices));
      corners.push_back(vtkIdType(vertex));
    }
    if (count < 3) {
      flaws.add("a face of fewer than 3 corners is left out", [&] { return lines.file().place(); });
      continue;
    }
    faces->InsertNextCell(vtkIdType(count), corners.data());
    const std::vector<float> color = numbersLeft(line);
    if (!colors.set(size_t(faces->GetNumberOfCells() - 1), color) && !color.empty())
      flaws.add("what follows a face, no colour of three or four numbers, is passed over",
                [&] { return lines.file().place(); });
  }
  mesh->SetPolys(faces);
  mesh->GetCellData()->SetScalars(
      colors.array(faces->GetNumberOfCells(), [](vtkIdType f) { return size_t(f); }));
}

}  // namespace

vtkSmartPointer<vtkPolyData> readOff(std::string_view bytes, const std::string& path, Flaws& flaws) {
  OffLines lines(bytes, path);
  const OffHeader header = readHeader(lines, bytes.size());
  const auto mesh = vtkSmartPointer<vtkPolyData>::New();
  readVertices(lines, header, mesh, flaws);
  readFaces(lines, header, mesh, flaws);
  return mesh;
}

}  // namespace gxy
