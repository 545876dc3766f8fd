// SPDX-License-Identifier: Apache-2.0
// Examines the arrays of VTK's XML files of geometry before any of them is read. Used inside core/io only, by
// files that include VTK.
#pragma once
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/io/left_out.h"
#include "core/io/vtk_geometry.h"
#include "core/io/vtk_xml.h"

namespace gxy {

/// Computes the memory that VTK's readers of .vtp, .vtu, .vts and .vtr would allocate for a file, and chooses
/// the arrays that they should not read. It considers all elements in the pieces, because of two elements
/// with one name a reader may use either.
class XmlArrays {
 public:
  /// Throws Error for a file that states impossible sizes.
  XmlArrays(const VtkXml& xml, const std::optional<ArraysNeeded>& needed);

  int64_t bytes() const { return bytes_; }
  /// Names of arrays that are not needed, of arrays of strings, whose size no attribute states, and of arrays
  /// of unknown types, which are not used.
  const std::set<std::string>& pointArraysToPassOver() const { return points_; }
  const std::set<std::string>& cellArraysToPassOver() const { return cells_; }
  const LeftOut& leftOut() const { return leftOut_; }

 private:
  bool isPassedOver(vtkXMLDataElement* array, bool ofCells) const;
  void choose(const std::vector<vtkXMLDataElement*>& pieces, const ArraysNeeded& needed);
  int64_t count(vtkXMLDataElement* piece, const char* attribute) const;
  void addPiece(vtkXMLDataElement* piece);
  void addLattice(vtkXMLDataElement* piece);
  void addArrays(vtkXMLDataElement* group, int64_t tuples);
  void addCells(vtkXMLDataElement* group, int64_t cells);
  int64_t sum(int64_t a, int64_t b) const;
  void add(int64_t n, int64_t each);
  [[noreturn]] void tooLarge() const;

  const VtkXml& xml_;
  int64_t bytes_ = 0;
  bool several_ = false, all_;
  std::set<std::string> chosen_, chosenOfCells_;
  std::set<std::string> points_, cells_;
  LeftOut leftOut_;
};

/// Returns the arrays of points and of cells that a list of pieces of this type declares.
std::pair<ListedArrays, ListedArrays> arraysOfXmlList(const std::string& path, const char* type);

}  // namespace gxy
