// SPDX-License-Identifier: Apache-2.0
#include "core/io/mesh_file.h"

#include <vtkCellData.h>
#include <vtkDataSetAttributes.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/flaws.h"
#include "core/io/listed_arrays.h"
#include "core/io/volume_cells.h"
#include "core/io/vtk_geometry.h"
#include "core/io/vtk_scalars.h"

namespace gxy {

namespace {

static_assert(kDuplicateCell == vtkDataSetAttributes::DUPLICATECELL &&
              kRefinedCell == vtkDataSetAttributes::REFINEDCELL &&
              kHiddenCell == vtkDataSetAttributes::HIDDENCELL &&
              kHiddenPoint == vtkDataSetAttributes::HIDDENPOINT);
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

/// Returns which array gives the values, among those that have been read.
ChosenArray valuesOf(vtkPointSet* grid, const MeshWanted& wanted, const std::string& path) {
  const ListedArrays points = listOf(grid->GetPointData()), cells = listOf(grid->GetCellData());
  if (auto chosen = chooseValues(points, cells, ValuesWanted(wanted.array, wanted.ofCells))) return *chosen;
  const std::string kind = wanted.ofCells ? (*wanted.ofCells ? "cells" : "points") : "points or cells";
  throw Error(path + ": no " + (wanted.array.empty() ? "numeric array" : "array '" + wanted.array + "'") +
              " of " + kind + ", which an unstructured volume needs; of points the file has " +
              namesOf(points) + ", of cells " + namesOf(cells));
}

class MeshReader {
 public:
  MeshReader(vtkPointSet* grid, const std::string& path)
      : grid_(grid),
        path_(path),
        list_(grid),
        ghosts_(grid->GetCellGhostArray()),
        hidden_(grid->GetPointGhostArray()) {}

  MeshContent read(const MeshWanted& wanted, const TakeMemory& toTake) {
    content_.pointsOfFile = uint64_t(grid_->GetNumberOfPoints());
    if (content_.pointsOfFile >= kMostMeshPoints)
      throw Error(path_ + ": " + std::to_string(content_.pointsOfFile) +
                  " points; one file may have fewer than 2^30");
    const vtkIdType cells = list_.count(), first = cells * wanted.part / wanted.of,
                    end = cells * (wanted.part + 1) / wanted.of;
    const int64_t corners = countKinds(first, end);
    if (content_.pointsOfFile == 0) return std::move(content_);
    const ChosenArray chosen = valuesOf(grid_, wanted, path_);
    vtkDataSetAttributes* const data = chosen.ofCells
                                           ? static_cast<vtkDataSetAttributes*>(grid_->GetCellData())
                                           : static_cast<vtkDataSetAttributes*>(grid_->GetPointData());
    vtkDataArray* const values = data->GetArray(chosen.name.c_str());
    content_.array = chosen.name;
    content_.ofCells = chosen.ofCells;
    content_.components = values->GetNumberOfComponents();
    content_.type = scalarOfVtk(values->GetDataType()).value_or(ScalarType::Float64);
    if (toTake)
      toTake(int64_t(content_.pointsOfFile) * int64_t(sizeof(uint32_t)) +
             grid_->GetNumberOfPoints() / wanted.of * int64_t(sizeof(glm::dvec3) + sizeof(uint64_t)) +
             (chosen.ofCells ? end - first : grid_->GetNumberOfPoints() / wanted.of) *
                 int64_t(sizeof(double) * size_t(content_.components)) +
             corners * int64_t(sizeof(uint32_t)));
    numberOf_.assign(size_t(content_.pointsOfFile), kNone);
    for (vtkIdType cell = first; cell < end; cell++) take(cell, values);
    if (!chosen.ofCells) takeValues(values);
    content_.warnings = flaws_.warnings(path_);
    return std::move(content_);
  }

 private:
  bool isGhost(vtkIdType cell) const { return ghosts_ && isGhostCell(ghosts_->GetValue(cell)); }

  bool isHidden(vtkIdType point) const { return hidden_ && (hidden_->GetValue(point) & kHiddenPoint); }

  /// Returns how many points the cells from `first` to `end` have that become cells of the mesh.
  int64_t countKinds(vtkIdType first, vtkIdType end) {
    CellKinds others;
    int64_t corners = 0;
    for (vtkIdType cell = 0; cell < list_.count(); cell++) {
      if (isGhost(cell)) continue;
      const int type = list_.type(cell);
      content_.kinds[type]++;
      const auto meshType = meshCellOf(type);
      if (meshType && cell >= first && cell < end) corners += shapeOf(*meshType).points;
      if (dimensionOf(type).value_or(3) == 3 && !meshType) others[type]++;
    }
    if (!others.empty())
      throw Error(path_ + ": it has cells that an unstructured volume cannot have yet: " + describe(others) +
                  "; expected " + kMeshCellKinds);
    return corners;
  }

  /// Whether a ghost has a value for averages at points.
  bool serves(vtkIdType cell) const { return content_.ofCells && isDuplicateOnly(ghosts_->GetValue(cell)); }

  void take(vtkIdType cell, vtkDataArray* values) {
    const int type = list_.type(cell);
    const auto meshType = meshCellOf(type);
    const bool isDuplicate = isGhost(cell);
    if (isDuplicate) {
      content_.ghostCells += meshType.has_value() || dimensionOf(type).value_or(3) == 3;
      if (!meshType || !serves(cell)) return;
    }
    if (!meshType) {
      content_.flatCells++;
      return;
    }
    list_.points(cell, ids_);
    if (size_t(ids_->GetNumberOfIds()) != shapeOf(*meshType).points) {
      flaws_.add("a cell whose number of points is not that of its type is left out",
                 [&] { return "cell " + std::to_string(cell); });
      return;
    }
    const auto isFinite = [&](vtkIdType point) {
      const double* p = grid_->GetPoint(point);
      return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
    };
    if (!std::all_of(ids_->begin(), ids_->end(), isFinite)) {
      content_.unusableCells += !isDuplicate;
      return;
    }
    for (size_t i = 0; i < shapeOf(*meshType).points; i++)
      content_.cells.points[size_t(*meshType)].push_back(
          numberOf(ids_->GetId(vtkIdType(placeInFile(type, i)))));
    if (content_.ofCells) takeValue(values, cell, *meshType, isDuplicate);
  }

  void takeValue(vtkDataArray* values, vtkIdType cell, CellType type, bool isDuplicate) {
    std::vector<double>& of = content_.cellValues[size_t(type)];
    of.resize(of.size() + size_t(content_.components));
    double* const own = of.data() + of.size() - size_t(content_.components);
    values->GetTuple(cell, own);
    if (std::any_of(ids_->begin(), ids_->end(), [&](vtkIdType point) { return isHidden(point); }))
      std::fill_n(own, content_.components, std::numeric_limits<double>::quiet_NaN());
    content_.duplicates[size_t(type)].push_back(isDuplicate);
  }

  uint32_t numberOf(vtkIdType point) {
    uint32_t& number = numberOf_[size_t(point)];
    if (number == kNone) {
      number = uint32_t(content_.points.size());
      const double* p = grid_->GetPoint(point);
      content_.points.push_back({p[0], p[1], p[2]});
      content_.numbers.push_back(uint64_t(point));
    }
    return number;
  }

  void takeValues(vtkDataArray* values) {
    const auto components = size_t(content_.components);
    content_.values.resize(content_.points.size() * components);
    for (size_t p = 0; p < content_.points.size(); p++) {
      double* of = content_.values.data() + p * components;
      const auto point = vtkIdType(content_.numbers[p]);
      values->GetTuple(point, of);
      if (isHidden(point)) std::fill_n(of, components, std::numeric_limits<double>::quiet_NaN());
    }
  }

  vtkPointSet* const grid_;
  const std::string& path_;
  const VolumeCells list_;
  vtkUnsignedCharArray *const ghosts_, *const hidden_;
  const vtkSmartPointer<vtkIdList> ids_ = vtkSmartPointer<vtkIdList>::New();  // points of the current cell
  std::vector<uint32_t> numberOf_;                                            // by point of the file
  Flaws flaws_;
  MeshContent content_;
};

}  // namespace

MeshContent readMesh(const std::string& path, const MeshWanted& wanted, const TakeMemory& toTake) {
  LeftOut leftOut;
  const vtkSmartPointer<vtkPointSet> set =
      readPointSet(path, toTake, ArraysNeeded{ValuesWanted(wanted.array, wanted.ofCells), false}, &leftOut);
  if (!vtkUnstructuredGrid::SafeDownCast(set) && !vtkStructuredGrid::SafeDownCast(set))
    throw Error(path + ": expected an unstructured, structured or rectilinear grid, found " +
                set->GetClassName());
  MeshContent content = MeshReader(set, path).read(wanted, toTake);
  content.leftOut = leftOut;
  return content;
}

}  // namespace gxy
