// SPDX-License-Identifier: Apache-2.0
#include "core/io/legacy_vtk.h"

#include <vtkCellType.h>

#include <array>
#include <cctype>
#include <cstring>
#include <limits>
#include <optional>

#include "core/io/text_scanner.h"

namespace gxy {
namespace {

std::string upper(std::string_view word) {
  std::string text(word.substr(0, 40));
  for (char& c : text) c = char(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

struct Type {
  std::string_view name;
  uint64_t bytes;  ///< size of a value in a binary file
};
constexpr Type kTypes[] = {{"CHAR", 1},         {"UNSIGNED_CHAR", 1}, {"SHORT", 2},     {"UNSIGNED_SHORT", 2},
                           {"INT", 4},          {"UNSIGNED_INT", 4},  {"LONG", 8},      {"UNSIGNED_LONG", 8},
                           {"VTKTYPEINT64", 8}, {"VTKTYPEUINT64", 8}, {"VTKIDTYPE", 4}, {"FLOAT", 4},
                           {"DOUBLE", 8}};

class Walk {
 public:
  Walk(std::string& bytes, const std::string& path) : bytes_(bytes), scanner_(bytes, path) {}

  void run() {
    readHeader();
    for (std::string word = keyword(); !word.empty(); word = keyword()) {
      if (word == "POINT_DATA" || word == "CELL_DATA") break;
      if (word == "POINTS" && type_ != "RECTILINEAR_GRID") {
        const uint64_t points = count("a number of points", std::numeric_limits<uint32_t>::max());
        array(keyword(), points * 3);
      } else if (lattice_ && word == "DIMENSIONS") {
        dimensions();
      } else if (type_ == "RECTILINEAR_GRID" && word.size() == 13 && word.ends_with("_COORDINATES")) {
        coordinates(word[0]);
      } else if (word == "FIELD") {
        field();
      } else if (word == "METADATA") {
        blankMetadata();
      } else if (grid_ && word == "CELL_TYPES") {
        if (types_) scanner_.fail("a second CELL_TYPES");
        cellTypes();
      } else if (grid_ ? word == "CELLS"
                       : type_ == "POLYDATA" && (word == "VERTICES" || word == "LINES" ||
                                                 word == "POLYGONS" || word == "TRIANGLE_STRIPS")) {
        if (grid_ && cells_) scanner_.fail("a second CELLS");
        cells(word);
      } else {
        scanner_.fail("found '" + word + "', expected a keyword of " + type_);
      }
    }
    if (grid_ && cells_.value_or(0) != types_.value_or(0))
      scanner_.fail(std::to_string(types_.value_or(0)) + " CELL_TYPES for " +
                    std::to_string(cells_.value_or(0)) + " CELLS");
  }

 private:
  std::string keyword() { return upper(scanner_.word()); }

  uint64_t count(std::string_view what, uint64_t most = std::numeric_limits<int32_t>::max()) {
    const auto value = scanner_.number<int64_t>(what);
    if (value < 0 || uint64_t(value) > most)
      scanner_.fail("found " + std::to_string(value) + ", expected " + std::string(what) + " from 0 to " +
                    std::to_string(most));
    return uint64_t(value);
  }

  /// Passes over the end of a line that must have no more words: data follow.
  void lineEnd() {
    if (scanner_.line().find_first_not_of(" \t\r") != std::string_view::npos)
      scanner_.fail("expected the end of the line before");
  }

  static bool number(std::string_view text, int& value) {
    return !text.empty() && std::isdigit(static_cast<unsigned char>(text[0])) &&
           TextScanner::parse(text, value);
  }

  void readHeader() {
    constexpr std::string_view kMagic = "# vtk DataFile Version ";
    std::string_view version = scanner_.line();
    const bool named = version.starts_with(kMagic);
    version.remove_prefix(named ? kMagic.size() : version.size());
    version = version.substr(0, version.find_last_not_of(" \t") + 1);
    const size_t dot = std::min(version.find('.'), version.size());
    int minor = 0;
    if (!named || !number(version.substr(0, dot), major_) ||
        !number(version.substr(std::min(dot + 1, version.size())), minor))
      scanner_.fail("expected '# vtk DataFile Version' and two numbers, as 3.0");
    scanner_.line();
    const std::string encoding = keyword();
    if (encoding != "ASCII" && encoding != "BINARY")
      scanner_.fail("found '" + encoding + "', expected ASCII or BINARY");
    binary_ = encoding == "BINARY";
    if (keyword() != "DATASET") scanner_.fail("expected DATASET");
    type_ = keyword();
    grid_ = type_ == "UNSTRUCTURED_GRID";
    lattice_ = type_ == "STRUCTURED_GRID" || type_ == "RECTILINEAR_GRID";
    if (!grid_ && !lattice_ && type_ != "POLYDATA")
      scanner_.fail("found '" + type_ +
                    "', expected POLYDATA, UNSTRUCTURED_GRID, STRUCTURED_GRID or RECTILINEAR_GRID");
  }

  /// Reads the dimensions of a grid. VTK allocates by them only what the file must contain too: its points, or
  /// the coordinates of its axes. Throws Error for more than 2^31 - 1 points.
  void dimensions() {
    uint64_t points = 1;
    for (uint64_t& n : dimensions_) {
      n = count("a number of points");
      if (__builtin_mul_overflow(points, n, &points) || points > std::numeric_limits<int32_t>::max())
        scanner_.fail("the grid has more than 2^31 - 1 points");
    }
  }

  void coordinates(char axis) {
    const uint64_t values = count("a number of coordinates");
    if (axis < 'X' || axis > 'Z' || values != dimensions_[size_t(axis - 'X')])
      scanner_.fail(std::to_string(values) + " coordinates, expected as many as DIMENSIONS says before");
    array(keyword(), values);
  }

  void needs(uint64_t values, uint64_t bytesEach) {
    const uint64_t bytes = scanner_.left() + (binary_ ? 0 : 1);
    if (values > bytes / (binary_ ? bytesEach : 2))
      scanner_.fail("the file ends too early for an array of " + std::to_string(values) + " values");
  }

  /// Reads the type of an array from the rest of its line, and passes over its values.
  void array(const std::string& name, uint64_t values) {
    const Type* type = nullptr;
    for (const Type& known : kTypes)
      if (name == known.name) type = &known;
    if (!type) scanner_.fail("found '" + name + "', expected the type of an array");
    if (binary_) lineEnd();
    needs(values, type->bytes);
    if (binary_) {
      scanner_.take(values * type->bytes, "the array's end");
      return;
    }
    const bool real = name == "FLOAT" || name == "DOUBLE";
    for (uint64_t i = 0; i < values; ++i) {
      if (real)
        scanner_.number<double>("a number");
      else
        scanner_.number<int64_t>("an integer");
    }
  }

  /// Reads the length of a string in a binary file. It has 1, 2, 4 or 8 bytes; its first two bits say which.
  uint64_t stringLength() {
    const auto first = static_cast<unsigned char>(scanner_.take(1, "a string's length")[0]);
    const size_t more = (size_t(1) << (3 - (first >> 6))) - 1;
    uint64_t length = first & 0x3f;
    for (const char c : scanner_.take(more, "a string's length"))
      length = length << 8 | static_cast<unsigned char>(c);
    return length;
  }

  void field() {
    if (scanner_.word().empty()) scanner_.fail("expected the name of a FIELD");
    const uint64_t arrays = count("a number of arrays");
    for (uint64_t i = 0; i < arrays; ++i) {
      std::string_view name = scanner_.word();
      while (upper(name) == "METADATA") {
        blankMetadata();
        name = scanner_.word();
      }
      if (name.empty()) scanner_.fail("the file ends within a FIELD");
      if (name == "NULL_ARRAY") continue;
      const uint64_t components = count("a number of components"), tuples = count("a number of tuples");
      const std::string type = keyword();
      if (type != "STRING") {
        array(type, components * tuples);
        continue;
      }
      lineEnd();
      needs(components * tuples, 1);
      for (uint64_t s = 0; s < components * tuples; ++s)
        if (binary_)
          scanner_.take(stringLength(), "a string's end");
        else
          scanner_.line();
    }
  }

  /// Blanks out a METADATA block, from the keyword that was just read to the first empty line.
  void blankMetadata() {
    const size_t begin = bytes_.size() - scanner_.left() - std::strlen("METADATA");
    scanner_.line();
    while (scanner_.left() && !scanner_.line().empty()) {
    }
    for (size_t at = begin; at < bytes_.size() - scanner_.left(); ++at)
      if (bytes_[at] != '\n') bytes_[at] = ' ';
  }

  /// Checks a list of cells: n0 id id ... n1 id ..., or, since version 5, offsets and ids.
  void cells(const std::string& kind) {
    const uint64_t cells = count("a number of cells"), size = count("a number of integers");
    cells_ = cells;
    if (major_ >= 5) {
      if (cells == 0) return;
      cells_ = cells - 1;
      for (const auto& [name, values] : {std::pair("OFFSETS", cells), std::pair("CONNECTIVITY", size)}) {
        if (keyword() != name) scanner_.fail("expected " + std::string(name));
        array(keyword(), values);
      }
      return;
    }
    if (binary_) lineEnd();
    needs(size, 4);
    uint64_t left = size;
    for (uint64_t cell = 0; cell < cells; ++cell) {
      const int32_t corners = left ? integer() : -1;
      if (corners < 0 || uint64_t(corners) >= left)
        scanner_.fail(kind + ": cell " + std::to_string(cell) + " of " + std::to_string(cells) +
                      (left ? " has " + std::to_string(corners) + " points, but " + std::to_string(left - 1)
                            : std::string(" is missing: 0")) +
                      " of the stated " + std::to_string(size) + " integers are left for it");
      for (int32_t corner = 0; corner < corners; ++corner) integer();
      left -= uint64_t(corners) + 1;
    }
    if (left)
      scanner_.fail(kind + ": " + std::to_string(cells) + " cells take " + std::to_string(size - left) +
                    " integers, not " + std::to_string(size));
  }

  void cellTypes() {
    types_ = count("a number of cell types");
    if (binary_) lineEnd();
    needs(*types_, 4);
    for (uint64_t i = 0; i < *types_; ++i)
      if (integer() == VTK_POLYHEDRON) scanner_.fail("polyhedra are read from .vtu files only");
  }

  int32_t integer() {
    if (!binary_) return scanner_.number<int32_t>("an integer");
    uint32_t value = 0;
    for (const char c : scanner_.take(4, "an integer")) value = value << 8 | static_cast<unsigned char>(c);
    return int32_t(value);
  }

  std::string& bytes_;
  TextScanner scanner_;
  std::string type_;
  bool binary_ = false, grid_ = false, lattice_ = false;
  std::array<uint64_t, 3> dimensions_{};
  int major_ = 0;
  std::optional<uint64_t> cells_, types_;
};

}  // namespace

std::string legacyDatasetType(std::string_view head) {
  const std::string path;
  TextScanner scanner(head, path);
  if (!scanner.line().starts_with("# vtk DataFile Version")) return {};
  scanner.line();  // the title, which may be any text
  scanner.word();  // ASCII or BINARY
  return upper(scanner.word()) == "DATASET" ? upper(scanner.word()) : std::string();
}

void checkLegacyVtk(std::string& bytes, const std::string& path) { Walk(bytes, path).run(); }

}  // namespace gxy
