// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/io/header_lines.h"
#include "core/io/image_header.h"

namespace gxy {
namespace {

/// Returns the value of a key of the header's dictionary: the text up to the next ',' or '}' outside parentheses.
std::string_view valueOfKey(std::string_view dictionary, const std::string& key, const std::string& where) {
  const size_t at = std::min(dictionary.find("'" + key + "'"), dictionary.find("\"" + key + "\""));
  const size_t colon = at == dictionary.npos ? at : dictionary.find(':', at);
  if (colon == dictionary.npos) throw Error(where + ": the header has no " + inQuotes(key));
  size_t end = colon + 1;
  for (int depth = 0; end < dictionary.size(); ++end) {
    const char c = dictionary[end];
    depth += (c == '(') - (c == ')');
    if (depth == 0 && (c == ',' || c == '}')) break;
  }
  return trimmed(dictionary.substr(colon + 1, end - colon - 1));
}

ScalarType typeOfDescr(std::string_view descr, bool& swaps, const std::string& where) {
  const std::string_view word =
      descr.size() > 2 ? descr.substr(1, descr.size() - 2) : "";  // without its quotes
  const char order = word.empty() ? ' ' : word.front();
  swaps = (order == '>' && std::endian::native == std::endian::little) ||
          (order == '<' && std::endian::native == std::endian::big);
  constexpr std::pair<std::string_view, ScalarType> kWords[] = {
      {"i1", ScalarType::Int8},    {"u1", ScalarType::UInt8},  {"b1", ScalarType::UInt8},
      {"i2", ScalarType::Int16},   {"u2", ScalarType::UInt16}, {"i4", ScalarType::Int32},
      {"u4", ScalarType::UInt32},  {"i8", ScalarType::Int64},  {"u8", ScalarType::UInt64},
      {"f4", ScalarType::Float32}, {"f8", ScalarType::Float64}};
  for (const auto& [name, type] : kWords)
    if (!word.empty() && word.substr(1) == name &&
        std::string_view("<>|=").find(order) != std::string_view::npos)
      return type;
  throw Error(where + ": type " + inQuotes(descr.substr(0, 40)) +
              ", expected integers or floats such as '<f4'");
}

std::vector<int64_t> shapeOf(std::string_view text, const std::string& where) {
  std::vector<int64_t> shape;
  std::string numbers(text);
  for (char& c : numbers)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  for (const std::string_view word : wordsOf(numbers)) {
    int64_t n = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), n);
    if (error != std::errc() || end != word.data() + word.size() || n < 1)
      throw Error(where + ": shape " + inQuotes(text.substr(0, 60)) +
                  ", expected whole numbers of 1 or more");
    shape.push_back(n);
  }
  if (shape.size() < 2 || shape.size() > 4)
    throw Error(where + ": an array of " + std::to_string(shape.size()) +
                " axes, expected 2 or 3, or 4 with components");
  return shape;
}

}  // namespace

ImageHeader parseNpy(std::string_view bytes, const std::string& where) {
  if (bytes.size() < 12 || !bytes.starts_with("\x93NUMPY"))
    throw Error(where + ": expected a file of NumPy's form");
  const bool wide = bytes[6] >= 2;  // From version 2 on, the length has four bytes.
  size_t length = 0, begin = wide ? 12 : 10;
  for (size_t i = begin; i-- > 8;) length = length << 8 | static_cast<unsigned char>(bytes[i]);
  if (length > bytes.size() - begin) throw Error(where + ": the file ends within its header");
  const std::string_view dictionary = bytes.substr(begin, length);
  ImageHeader header;
  header.image.path = where;
  header.type = typeOfDescr(valueOfKey(dictionary, "descr", where), header.swapBytes, where);
  std::vector<int64_t> shape = shapeOf(valueOfKey(dictionary, "shape", where), where);
  const bool fortran = valueOfKey(dictionary, "fortran_order", where) == "True";
  if (!fortran) std::reverse(shape.begin(), shape.end());  // The fastest axis comes first.
  if (shape.size() == 4) {
    if (fortran || shape[0] > 1024)
      throw Error(
          where +
          ": an array of four axes, expected at most 1024 components of a point on the last, in C's order");
    header.components = int(shape[0]);
    shape.erase(shape.begin());
  }
  std::copy(shape.begin(), shape.end(), header.image.points.begin());
  header.offset = int64_t(begin + length);
  header.exact = true;
  return header;
}

}  // namespace gxy
