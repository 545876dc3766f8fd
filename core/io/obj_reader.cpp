// SPDX-License-Identifier: Apache-2.0
#include "core/io/obj_reader.h"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <array>
#include <map>
#include <vector>

#include "core/io/color_arrays.h"
#include "core/io/text_scanner.h"

namespace gxy {
namespace {

/// Indices, from 0 on, of a vertex, its texture coordinates and its normal; -1: none.
using Corner = std::array<int64_t, 3>;

struct Cells {
  size_t leastCorners;
  const char* tooFew;  ///< the flaw of a cell with fewer corners
  std::vector<Corner> corners = {};
  std::vector<size_t> ends = {};  ///< by cell: index after its last corner
};

struct Mesh {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<float, 2>> coordinates;
  std::vector<std::array<float, 3>> normals;
  FoundColors colors;  ///< colours of vertices
  Cells points{1, "a list of points without any is left out"},
      lines{2, "a line of fewer than 2 points is left out"},
      polygons{3, "a face of fewer than 3 corners is left out"};

  std::array<int64_t, 3> counts() const {
    return {int64_t(vertices.size()), int64_t(coordinates.size()), int64_t(normals.size())};
  }
};
constexpr const char* kKinds[] = {"vertex", "texture coordinates", "normal"};
constexpr const char* kMissing[] = {"", "texture coordinates that are not there are not used",
                                    "a normal that is not there is not used"};

template <size_t N, class T>
std::array<T, N> readNumbers(TextScanner& line, const TextScanner& file, size_t least = N) {
  std::array<T, N> numbers{};
  for (size_t i = 0; i < N; ++i) {
    const std::string_view word = line.word();
    if (word.empty() && i >= least) break;
    double value = 0;
    if (!TextScanner::parse(word, value))
      file.fail("found '" + std::string(word.substr(0, 40)) + "', expected a number");
    numbers[i] = T(value);
  }
  return numbers;
}

Corner readCorner(std::string_view word, const Mesh& mesh, const TextScanner& file, Flaws& flaws) {
  const auto malformed = [&] {
    file.fail("found the corner '" + std::string(word.substr(0, 40)) +
              "', expected v, v/t, v//n or v/t/n with numbers that are not 0");
  };
  Corner corner{-1, -1, -1};
  std::string_view rest = word;
  for (size_t i = 0; i < 3; ++i) {
    const size_t slash = std::min(rest.find('/'), rest.size());
    const std::string_view text = rest.substr(0, slash);
    const bool last = slash == rest.size();
    if (text.empty() && i > 0) {
      if (last)
        flaws.add("a corner ends with '/', so that it has no more than is before",
                  [&] { return file.place(); });
    } else {
      int64_t index = 0;
      if (!TextScanner::parse(text, index) || index == 0) malformed();
      const int64_t count = mesh.counts()[i];
      if (index < -count && i > 0)
        flaws.add(kMissing[i], [&] { return file.place(); });
      else if (index < -count)
        file.fail("refers to " + std::string(kKinds[i]) + " " + std::to_string(index) + " of " +
                  std::to_string(count));
      corner[i] = index > 0 ? index - 1 : std::max<int64_t>(count + index, -1);
    }
    if (last) return corner;
    rest.remove_prefix(slash + 1);
  }
  malformed();
  return corner;
}

void readCell(TextScanner& line, const TextScanner& file, const Mesh& mesh, Cells& cells, Flaws& flaws) {
  const size_t begin = cells.corners.size();
  for (std::string_view word = line.word(); !word.empty(); word = line.word())
    cells.corners.push_back(readCorner(word, mesh, file, flaws));
  if (cells.corners.size() - begin < cells.leastCorners) {
    flaws.add(cells.tooFew, [&] { return file.place(); });
    return cells.corners.resize(begin);
  }
  cells.ends.push_back(cells.corners.size());
}

/// Returns the next line without its comment. Lines that continue it after a backslash are appended;
/// `joined` is the memory.
std::string_view statement(TextScanner& file, std::string& joined) {
  const auto next = [&] {
    const std::string_view text = file.lineOfAnyEnd();
    return text.substr(0, text.find('#'));
  };
  std::string_view text = next();
  if (!text.ends_with('\\')) return text;
  joined.clear();
  for (; text.ends_with('\\'); text = next()) {
    text.remove_suffix(1);
    joined.append(text) += ' ';
  }
  return joined.append(text);
}

Mesh parse(std::string_view bytes, const std::string& path, Flaws& flaws) {
  TextScanner file(bytes, path);
  file.passByteOrderMark();
  Mesh mesh;
  std::string joined;
  while (file.left()) {
    TextScanner line(statement(file, joined), path);
    const std::string_view word = line.word();
    if (word == "v") {
      mesh.vertices.push_back(readNumbers<3, double>(line, file));
      mesh.colors.set(mesh.vertices.size() - 1, numbersLeft(line));
    } else if (word == "vt")
      mesh.coordinates.push_back(readNumbers<2, float>(line, file, 1));
    else if (word == "vn")
      mesh.normals.push_back(readNumbers<3, float>(line, file));
    else if (word == "f")
      readCell(line, file, mesh, mesh.polygons, flaws);
    else if (word == "l")
      readCell(line, file, mesh, mesh.lines, flaws);
    else if (word == "p")
      readCell(line, file, mesh, mesh.points, flaws);
  }
  return mesh;
}

/// Checks the corners at the end of the file, because statements may refer to later ones.
void checkCorners(const Mesh& mesh, Cells& cells, const char* kind, const std::string& path, Flaws& flaws) {
  const auto counts = mesh.counts();
  for (size_t cell = 0, c = 0; cell < cells.ends.size(); ++cell)
    for (; c < cells.ends[cell]; ++c)
      for (size_t i = 0; i < 3; ++i) {
        int64_t& index = cells.corners[c][i];
        if (index < counts[i]) continue;
        const std::string place = kind + (" " + std::to_string(cell + 1));
        if (i == 0)
          throw Error(path + ": " + place + " refers to " + kKinds[i] + " " + std::to_string(index + 1) +
                      " of " + std::to_string(counts[i]));
        flaws.add(kMissing[i], [&] { return place; });
        index = -1;
      }
}

/// The points for all corners: first each vertex as its first use has it, then the copies.
class Points {
 public:
  explicit Points(size_t vertices) : corners_(vertices), used_(vertices, false) {
    for (size_t v = 0; v < vertices; ++v) corners_[v] = {int64_t(v), -1, -1};
  }
  vtkIdType idOf(const Corner& corner) {
    const size_t vertex = size_t(corner[0]);
    if (!used_[vertex]) {
      used_[vertex] = true;
      corners_[vertex] = corner;
    }
    if (corners_[vertex] == corner) return vtkIdType(vertex);
    const auto [found, isNew] = copies_.try_emplace(corner, vtkIdType(corners_.size()));
    if (isNew) corners_.push_back(corner);
    return found->second;
  }
  const std::vector<Corner>& corners() const { return corners_; }

 private:
  std::vector<Corner> corners_;
  std::vector<bool> used_;
  std::map<Corner, vtkIdType> copies_;
};

/// Makes cells; idOf(corner) returns the point of a corner.
template <class IdOf>
vtkSmartPointer<vtkCellArray> cellArray(const Cells& cells, IdOf idOf) {
  const auto array = vtkSmartPointer<vtkCellArray>::New();
  std::vector<vtkIdType> ids;
  for (size_t cell = 0, c = 0; cell < cells.ends.size(); ++cell) {
    ids.clear();
    for (; c < cells.ends[cell]; ++c) ids.push_back(idOf(cells.corners[c]));
    array->InsertNextCell(vtkIdType(ids.size()), ids.data());
  }
  return array;
}

/// Whether all corners of polygons have the i-th index.
bool allHave(const Mesh& mesh, size_t i) {
  const auto has = [i](const Corner& corner) { return corner[i] >= 0; };
  return !mesh.polygons.corners.empty() &&
         std::all_of(mesh.polygons.corners.begin(), mesh.polygons.corners.end(), has);
}

template <size_t N>
vtkSmartPointer<vtkFloatArray> pointArray(const char* name, const std::vector<Corner>& corners, size_t index,
                                          const std::vector<std::array<float, N>>& values) {
  const auto array = vtkSmartPointer<vtkFloatArray>::New();
  array->SetName(name);
  array->SetNumberOfComponents(int(N));
  array->SetNumberOfTuples(vtkIdType(corners.size()));
  for (size_t p = 0; p < corners.size(); ++p)
    array->SetTypedTuple(vtkIdType(p), values[size_t(std::max(corners[p][index], int64_t(0)))].data());
  return array;
}

}  // namespace

vtkSmartPointer<vtkPolyData> readObj(std::string_view bytes, const std::string& path, Flaws& flaws) {
  Mesh mesh = parse(bytes, path, flaws);
  checkCorners(mesh, mesh.points, "point", path, flaws);
  checkCorners(mesh, mesh.lines, "line", path, flaws);
  checkCorners(mesh, mesh.polygons, "face", path, flaws);
  const auto data = vtkSmartPointer<vtkPolyData>::New();
  Points points(mesh.vertices.size());
  data->SetPolys(cellArray(mesh.polygons, [&](const Corner& corner) { return points.idOf(corner); }));
  const auto vertexOf = [](const Corner& corner) { return vtkIdType(corner[0]); };
  data->SetLines(cellArray(mesh.lines, vertexOf));
  data->SetVerts(cellArray(mesh.points, vertexOf));
  const auto positions = vtkSmartPointer<vtkPoints>::New();
  positions->SetDataTypeToDouble();
  positions->SetNumberOfPoints(vtkIdType(points.corners().size()));
  for (size_t p = 0; p < points.corners().size(); ++p)
    positions->SetPoint(vtkIdType(p), mesh.vertices[size_t(points.corners()[p][0])].data());
  data->SetPoints(positions);
  data->GetPointData()->SetScalars(mesh.colors.array(
      positions->GetNumberOfPoints(), [&](vtkIdType p) { return size_t(points.corners()[size_t(p)][0]); }));
  if (allHave(mesh, 1))
    data->GetPointData()->SetTCoords(pointArray("TCoords", points.corners(), 1, mesh.coordinates));
  if (allHave(mesh, 2))
    data->GetPointData()->SetNormals(pointArray("Normals", points.corners(), 2, mesh.normals));
  return data;
}

}  // namespace gxy
