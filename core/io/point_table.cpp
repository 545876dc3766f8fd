// SPDX-License-Identifier: Apache-2.0
#include "core/io/point_table.h"

#include <vtkDoubleArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <optional>
#include <vector>

#include "core/io/color_arrays.h"
#include "core/io/text_scanner.h"

namespace gxy {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

std::string_view withoutSpaces(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Columns in their order, each with a name and one value for each point.
struct Columns {
  std::vector<std::string> names;
  std::vector<std::vector<double>> values;

  explicit Columns(std::vector<std::string> of) : names(std::move(of)), values(names.size()) {}
};

/// Splits "name:2" into "name" and 2; returns nothing for other names.
std::optional<std::pair<std::string, size_t>> componentOf(const std::string& name) {
  const size_t colon = name.rfind(':');
  size_t component = 0;
  if (colon == std::string::npos || colon == 0 ||
      !TextScanner::parse(std::string_view(name).substr(colon + 1), component))
    return std::nullopt;
  return std::pair(name.substr(0, colon), component);
}

void addArray(vtkPolyData* data, const std::string& name,
              const std::vector<const std::vector<double>*>& columns) {
  const auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name.c_str());
  array->SetNumberOfComponents(int(columns.size()));
  array->SetNumberOfTuples(vtkIdType(columns[0]->size()));
  for (size_t c = 0; c < columns.size(); ++c)
    for (size_t i = 0; i < columns[c]->size(); ++i)
      array->SetTypedComponent(vtkIdType(i), int(c), (*columns[c])[i]);
  data->GetPointData()->AddArray(array);
}

/// Returns the column with this name in any letter case; -1 if there is none.
int columnNamed(const std::vector<std::string>& names, std::string_view wanted) {
  const auto same = [&](const std::string& name) {
    return std::ranges::equal(
        name, wanted, [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
  };
  const auto found = std::ranges::find_if(names, same);
  return found == names.end() ? -1 : int(found - names.begin());
}

/// Returns the columns of red, green, blue and, if it exists, opacity; none unless the first three exist.
std::vector<int> colorColumns(const std::vector<std::string>& names) {
  constexpr std::array<const char*, 4> kNames[] = {{"red", "green", "blue", "alpha"}, {"r", "g", "b", "a"}};
  for (const auto& wanted : kNames) {
    std::vector<int> found;
    for (const char* name : wanted)
      if (const int column = columnNamed(names, name); column >= 0) found.push_back(column);
    if (found.size() == 4 || (found.size() == 3 && columnNamed(names, wanted[3]) < 0)) return found;
  }
  return {};
}

/// Makes points with coordinates from the columns `axes` (-1: coordinate 0). Other columns become arrays.
vtkSmartPointer<vtkPolyData> pointsOf(const Columns& table, const std::array<int, 3>& axes) {
  const auto data = vtkSmartPointer<vtkPolyData>::New();
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  const size_t count = table.values.empty() ? 0 : table.values[0].size();
  points->SetNumberOfPoints(vtkIdType(count));
  for (size_t i = 0; i < count; ++i) {
    double p[3];
    for (size_t a = 0; a < 3; ++a) p[a] = axes[a] < 0 ? 0 : table.values[size_t(axes[a])][i];
    points->SetPoint(vtkIdType(i), p);
  }
  data->SetPoints(points);
  const std::vector<int> colorsAt = colorColumns(table.names);
  for (size_t c = 0; c < table.names.size(); ++c) {
    if (std::ranges::find(axes, int(c)) != axes.end()) continue;
    if (std::ranges::find(colorsAt, int(c)) != colorsAt.end()) continue;
    const auto component = componentOf(table.names[c]);
    if (!component || component->second != 0) {
      addArray(data, table.names[c], {&table.values[c]});
      continue;
    }
    std::vector<const std::vector<double>*> columns{&table.values[c]};
    for (; c + 1 < table.names.size() &&
           componentOf(table.names[c + 1]) == std::pair(component->first, columns.size());
         ++c)
      columns.push_back(&table.values[c + 1]);
    addArray(data, component->first, columns);
  }
  if (colorsAt.empty()) return data;
  const auto colors = makeColors(int(colorsAt.size()), vtkIdType(count));
  for (size_t c = 0; c < colorsAt.size(); ++c)
    for (size_t i = 0; i < count; ++i)
      colors->SetTypedComponent(vtkIdType(i), int(c), float(table.values[size_t(colorsAt[c])][i]));
  scaleColors(colors);
  data->GetPointData()->AddArray(colors);
  return data;
}

// ---------------------------------------------------------------------------------------------------------- tables

char separatorOf(std::string_view line) {
  constexpr std::string_view kSeparators = ",;\t";
  return *std::ranges::max_element(kSeparators, {},
                                   [&](char separator) { return std::ranges::count(line, separator); });
}

/// Returns the fields of a line, without quotes and surrounding white space.
std::vector<std::string> fieldsOf(std::string_view line, char separator) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == separator && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  for (std::string& field : fields) field = withoutSpaces(field);
  return fields;
}

/// Returns the number in a field, NaN for an empty field, and nothing for other text.
std::optional<double> numberOf(const std::string& field) {
  double value = kNoNumber;
  if (!field.empty() && !TextScanner::parse(field, value)) return std::nullopt;
  return value;
}

std::array<int, 3> axesOf(const std::vector<std::string>& names, const std::string& path) {
  const auto find = [&](const char* wanted) { return columnNamed(names, wanted); };
  std::array<int, 3> axes{find("x"), find("y"), find("z")};
  if (axes[0] < 0 || axes[1] < 0) axes = {find("Points:0"), find("Points:1"), find("Points:2")};
  if (axes[0] >= 0 && axes[1] >= 0) return axes;
  std::string found;
  for (const std::string& name : names) found += (found.empty() ? "'" : ", '") + name + "'";
  throw Error(path + ": the columns are " + found + ", expected 'x', 'y' and 'z' among them");
}

// ----------------------------------------------------------------------------------------------------------- atoms

constexpr const char* kElements[] = {
    "H",  "He", "Li", "Be", "B",  "C",  "N",  "O",  "F",  "Ne", "Na", "Mg", "Al", "Si", "P",  "S",  "Cl",
    "Ar", "K",  "Ca", "Sc", "Ti", "V",  "Cr", "Mn", "Fe", "Co", "Ni", "Cu", "Zn", "Ga", "Ge", "As", "Se",
    "Br", "Kr", "Rb", "Sr", "Y",  "Zr", "Nb", "Mo", "Tc", "Ru", "Rh", "Pd", "Ag", "Cd", "In", "Sn", "Sb",
    "Te", "I",  "Xe", "Cs", "Ba", "La", "Ce", "Pr", "Nd", "Pm", "Sm", "Eu", "Gd", "Tb", "Dy", "Ho", "Er",
    "Tm", "Yb", "Lu", "Hf", "Ta", "W",  "Re", "Os", "Ir", "Pt", "Au", "Hg", "Tl", "Pb", "Bi", "Po", "At",
    "Rn", "Fr", "Ra", "Ac", "Th", "Pa", "U",  "Np", "Pu", "Am", "Cm", "Bk", "Cf", "Es", "Fm", "Md", "No",
    "Lr", "Rf", "Db", "Sg", "Bh", "Hs", "Mt", "Ds", "Rg", "Cn", "Nh", "Fl", "Mc", "Lv", "Ts", "Og"};

/// Returns the atomic number of a symbol, or a number itself; NaN for other words.
double atomicNumber(std::string_view symbol) {
  double number = kNoNumber;
  if (TextScanner::parse(symbol, number)) return number;
  const auto found =
      std::ranges::find(kElements, symbol, [](const char* name) { return std::string_view(name); });
  return found == std::end(kElements) ? kNoNumber : double(found - std::begin(kElements) + 1);
}

vtkSmartPointer<vtkPolyData> readAtoms(TextScanner& file, size_t count, Flaws& flaws) {
  file.lineOfAnyEnd();  // the comment
  Columns table({"x", "y", "z", "element"});
  for (size_t atom = 0; atom < count; ++atom) {
    if (!file.left())
      file.fail("the file ends after " + std::to_string(atom) + " of " + std::to_string(count) + " atoms");
    TextScanner line(file.lineOfAnyEnd(), file.path());
    table.values[3].push_back(atomicNumber(line.word()));
    for (size_t axis = 0; axis < 3; ++axis) {
      double value = 0;
      if (!TextScanner::parse(line.word(), value))
        file.fail("expected an atom: a symbol and three coordinates");
      table.values[axis].push_back(value);
    }
  }
  while (file.left())
    if (!withoutSpaces(file.lineOfAnyEnd()).empty())
      flaws.add("what comes after the first atoms is passed over", [&] { return file.place(); });
  return pointsOf(table, {0, 1, 2});
}

/// Returns the numbers in a line of a point cloud.
std::vector<double> numbersOf(std::string_view text, const TextScanner& file) {
  std::vector<double> numbers;
  TextScanner line(text, file.path());
  for (std::string_view word = line.word(); !word.empty(); word = line.word()) {
    if (!TextScanner::parse(word, numbers.emplace_back()))
      file.fail("found '" + std::string(word.substr(0, 40)) + "', expected a number");
  }
  return numbers;
}

}  // namespace

vtkSmartPointer<vtkPolyData> readCsv(std::string_view bytes, const std::string& path, Flaws& flaws) {
  TextScanner file(bytes, path);
  file.passByteOrderMark();
  std::optional<Columns> table;
  std::array<int, 3> axes{0, 1, 2};
  std::vector<bool> numbers;  // by column: it has only numbers so far
  char separator = ',';
  while (file.left()) {
    const std::string_view line = file.lineOfAnyEnd();
    if (withoutSpaces(line).empty()) continue;
    if (!table) separator = separatorOf(line);
    std::vector<std::string> fields = fieldsOf(line, separator);
    if (!table) {
      const bool named = std::ranges::any_of(fields, [](const std::string& f) { return !numberOf(f); });
      if (!named && fields.size() < 3)
        file.fail(std::to_string(fields.size()) + " columns, expected three or more");
      if (named) axes = axesOf(fields, path);
      std::vector<std::string> names = fields;
      for (size_t c = 0; !named && c < names.size(); ++c) names[c] = "column " + std::to_string(c + 1);
      table.emplace(std::move(names));
      numbers.assign(table->names.size(), true);
      if (named) continue;
    }
    if (fields.size() != table->names.size())
      file.fail(std::to_string(fields.size()) + " fields, expected " + std::to_string(table->names.size()));
    for (size_t c = 0; c < fields.size(); ++c) {
      const std::optional<double> value = numberOf(fields[c]);
      if (!value && std::ranges::find(axes, int(c)) != axes.end())
        file.fail("found '" + fields[c].substr(0, 40) + "', expected a coordinate");
      if (!value && numbers[c]) {
        numbers[c] = false;
        flaws.add("a column of text is passed over",
                  [&] { return file.place() + ": '" + table->names[c] + "'"; });
      }
      table->values[c].push_back(value.value_or(kNoNumber));
    }
  }
  if (!table) throw Error(path + ": it is empty, expected columns 'x', 'y' and 'z'");
  Columns kept({});
  for (size_t c = 0; c < table->names.size(); ++c) {
    if (!numbers[c]) continue;
    for (int& axis : axes)
      if (axis == int(c)) axis = int(kept.names.size());
    kept.names.push_back(table->names[c]);
    kept.values.push_back(std::move(table->values[c]));
  }
  return pointsOf(kept, axes);
}

vtkSmartPointer<vtkPolyData> readXyz(std::string_view bytes, const std::string& path, Flaws& flaws) {
  TextScanner file(bytes, path);
  file.passByteOrderMark();
  std::optional<Columns> table;
  while (file.left()) {
    std::string_view line = file.lineOfAnyEnd();
    size_t atoms = 0;
    if (!table && TextScanner::parse(withoutSpaces(line), atoms)) return readAtoms(file, atoms, flaws);
    line = line.substr(0, line.find('#'));
    const std::vector<double> numbers = numbersOf(line, file);
    if (numbers.empty()) continue;
    if (!table) {
      std::vector<std::string> names{"x", "y", "z"};
      for (size_t c = 3; c < numbers.size(); ++c) names.push_back("value " + std::to_string(c - 2));
      table.emplace(std::move(names));
    }
    if (numbers.size() != table->names.size() || numbers.size() < 3)
      file.fail(std::to_string(numbers.size()) + " numbers, expected " +
                std::to_string(std::max<size_t>(3, table->names.size())));
    for (size_t c = 0; c < numbers.size(); ++c) table->values[c].push_back(numbers[c]);
  }
  return pointsOf(table.value_or(Columns({"x", "y", "z"})), {0, 1, 2});
}

}  // namespace gxy
