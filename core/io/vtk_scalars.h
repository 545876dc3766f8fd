// SPDX-License-Identifier: Apache-2.0
// Converts between VTK's scalar types and Galaxy's, and escapes text for XML. Used inside core/io only, by
// files that include VTK.
#pragma once
#include <vtkType.h>

#include <optional>
#include <string>
#include <string_view>

#include "core/data/volume.h"

namespace gxy {

/// Returns nothing for types that are not numbers (bits, strings).
inline std::optional<ScalarType> scalarOfVtk(int type) {
  switch (type) {
    case VTK_CHAR:
    case VTK_SIGNED_CHAR:
      return ScalarType::Int8;
    case VTK_UNSIGNED_CHAR:
      return ScalarType::UInt8;
    case VTK_SHORT:
      return ScalarType::Int16;
    case VTK_UNSIGNED_SHORT:
      return ScalarType::UInt16;
    case VTK_INT:
      return ScalarType::Int32;
    case VTK_UNSIGNED_INT:
      return ScalarType::UInt32;
    case VTK_LONG:
    case VTK_LONG_LONG:
    case VTK_ID_TYPE:
      return ScalarType::Int64;
    case VTK_UNSIGNED_LONG:
    case VTK_UNSIGNED_LONG_LONG:
      return ScalarType::UInt64;
    case VTK_FLOAT:
      return ScalarType::Float32;
    case VTK_DOUBLE:
      return ScalarType::Float64;
    default:
      return {};
  }
}

/// Returns the name of a type in VTK's XML files.
inline const char* xmlWord(ScalarType type) {
  switch (type) {
    case ScalarType::Int8:
      return "Int8";
    case ScalarType::UInt8:
      return "UInt8";
    case ScalarType::Int16:
      return "Int16";
    case ScalarType::UInt16:
      return "UInt16";
    case ScalarType::Int32:
      return "Int32";
    case ScalarType::UInt32:
      return "UInt32";
    case ScalarType::Int64:
      return "Int64";
    case ScalarType::UInt64:
      return "UInt64";
    case ScalarType::Float32:
      return "Float32";
    case ScalarType::Float64:
      break;
  }
  return "Float64";
}

/// Escapes text for an XML attribute.
inline std::string escaped(std::string_view text) {
  std::string out;
  for (char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

inline std::optional<ScalarType> scalarOfXmlWord(std::string_view word) {
  for (int t = 0; t <= int(ScalarType::Float64); ++t)
    if (word == xmlWord(ScalarType(t))) return ScalarType(t);
  return {};
}

}  // namespace gxy
