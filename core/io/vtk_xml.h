// SPDX-License-Identifier: Apache-2.0
// Parses and checks files in VTK's XML format before VTK's readers read their arrays, because these readers
// trust the sizes that a file states. Used inside core/io only, by files that include VTK.
#pragma once
#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

#include <cstdint>
#include <istream>
#include <memory>
#include <string>
#include <vector>

#include "core/io/file.h"

namespace gxy {

/// Returns an attribute of an element; empty if it has none with that name.
std::string attribute(vtkXMLDataElement* element, const char* name);

/// The place and form of an array's data in the file: text, base64 or raw bytes, from `position` on. Base64
/// and raw bytes begin with a header.
struct XmlPlace {
  enum class Form { Text, Base64, Raw };
  Form form;
  int64_t position;
};

/// An open file whose XML is parsed and whose arrays are not read. One thread at a time may use it.
class VtkXml {
 public:
  /// Throws Error, with VTK's message if there is one, unless the file is a VTK XML file of this type
  /// ("PolyData") with at most 2^16 elements, nested at most 64 deep.
  VtkXml(const std::string& path, const char* type);

  const std::string& path() const { return file_->path(); }
  /// The parsed file, for a reader that must read the same file even if another one has its path by then.
  const std::shared_ptr<const File>& file() const { return file_; }
  /// For a VTK reader of the file. It does not parse again.
  vtkXMLDataParser* parser() const { return parser_; }
  vtkXMLDataElement* root() const { return parser_->GetRootElement(); }
  vtkXMLDataElement* data() const { return data_; }  ///< the element with the name of the type
  bool compressed() const;
  int64_t headerWordBytes() const;
  bool swapsBytes() const;  ///< the file's byte order is not this machine's
  /// For a list of cells (PUnstructuredGrid, PPolyData, PStructuredGrid, PRectilinearGrid), the attributes Source of its <Piece> elements.
  /// There may be any number of them, and they are not elements of data(). Empty for other files.
  const std::vector<std::string>& listedPieces() const;

  /// Throws Error for an offset that is not a position in the file.
  XmlPlace placeOf(vtkXMLDataElement* array) const;
  /// Returns the decompressed size of an array's data in bytes, by the header before them; for text, an upper
  /// bound. Throws Error if there is no header, or one that VTK's reader could not follow: blocks of few bytes
  /// or none, more or larger blocks than the file can contain, or a last block that is larger than the others.
  int64_t dataBytes(vtkXMLDataElement* array) const;
  /// Returns the size of `tuples` entries of an array in bytes, by its attributes; 0 for types that are not
  /// numbers.
  int64_t statedBytes(vtkXMLDataElement* array, int64_t tuples) const;
  /// Throws Error if the array is compressed and its decompressed size is not `bytes`.
  void checkCompressed(vtkXMLDataElement* array, int64_t bytes) const;
  /// Throws Error if the array is not compressed and the file is too short for its `bytes` bytes.
  void checkFileHolds(vtkXMLDataElement* array, int64_t bytes) const;

 private:
  [[noreturn]] void fail(vtkXMLDataElement* array, const std::string& what) const;

  std::shared_ptr<const File> file_;
  std::unique_ptr<std::istream> stream_;
  vtkSmartPointer<vtkXMLDataParser> parser_;
  vtkXMLDataElement* data_ = nullptr;
};

}  // namespace gxy
