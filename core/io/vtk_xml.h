// SPDX-License-Identifier: Apache-2.0
// Files in VTK's XML form before VTK's readers, which believe the sizes that a file states, read their arrays. Used inside
// core/io only, by files that see VTK.
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

/// Empty if the element has none of that name.
std::string attribute(vtkXMLDataElement* element, const char* name);

/// Where an array's data stand, and how: as text, as base64, or as bytes, from `position` on; the last two with a header.
struct XmlPlace {
  enum class Form { Text, Base64, Raw };
  Form form;
  int64_t position;
};

/// An open file, its XML parsed and none of its arrays read. For one thread at a time.
class VtkXml {
 public:
  /// Throws Error, with VTK's own words if it has some, unless it is a VTK XML file of this type ("PolyData"),
  /// of at most 2^16 elements and not deeply nested ones.
  VtkXml(const std::string& path, const char* type);

  const std::string& path() const { return file_->path(); }
  /// What was parsed, for a reader that is to see the same file, whatever is at its path by then.
  const std::shared_ptr<const File>& file() const { return file_; }
  vtkXMLDataParser* parser() const { return parser_; }
  vtkXMLDataElement* root() const { return parser_->GetRootElement(); }
  vtkXMLDataElement* data() const { return data_; }  ///< the element called like the type
  bool compressed() const;
  int64_t headerWordBytes() const;
  bool swapsBytes() const;  ///< the file's byte order is not this machine's
  /// Of a list of geometry (PUnstructuredGrid, PPolyData) what its <Piece> elements, of which there may be any number, have as
  /// attribute Source; they are no elements of data(). Empty where there is none.
  const std::vector<std::string>& listedPieces() const;

  /// Throws Error for an offset that is no position.
  XmlPlace placeOf(vtkXMLDataElement* array) const;
  /// Bytes of an array's data when they are decompressed, by the header before them; of text, the most that it can come
  /// to. Throws Error if there is no header, or one that VTK's reader could not follow: blocks of a few bytes or none,
  /// more of them or larger ones than the file can hold, a last one that is larger than the others.
  int64_t dataBytes(vtkXMLDataElement* array) const;
  /// Bytes of `tuples` entries of an array, by its attributes; 0 for types that hold no numbers.
  int64_t statedBytes(vtkXMLDataElement* array, int64_t tuples) const;
  /// Throws Error if the array is compressed and its data do not become `bytes` bytes.
  void checkCompressed(vtkXMLDataElement* array, int64_t bytes) const;
  /// Throws Error if a word of an array in text is no number: VTK's reader takes 1.0-101 for two. Returns whether the text ends at
  /// its end tag with NaN or infinity, which that reader does not read there.
  bool checkText(vtkXMLDataElement* array) const;

 private:
  [[noreturn]] void fail(vtkXMLDataElement* array, const std::string& what) const;

  std::shared_ptr<const File> file_;
  std::unique_ptr<std::istream> stream_;
  vtkSmartPointer<vtkXMLDataParser> parser_;
  vtkXMLDataElement* data_ = nullptr;
};

/// VTK's reader of a kind of dataset, which passes over field data: no use is made of them, and their sizes are unchecked.
template <class Reader>
class WithoutFieldData final : public Reader {
 public:
  static WithoutFieldData* New() { VTK_STANDARD_NEW_BODY(WithoutFieldData); }

 protected:
  int ReadPrimaryElement(vtkXMLDataElement* primary) override {
    const int read = Reader::ReadPrimaryElement(primary);
    this->FieldDataElement = nullptr;
    return read;
  }
};

}  // namespace gxy
