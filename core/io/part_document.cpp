// SPDX-License-Identifier: Apache-2.0
#include "core/io/part_document.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {
namespace {

using nlohmann::json;

Box parseExtent(const json& extent, const std::string& where) {
  double e[6];
  bool right = extent.is_array() && extent.size() == 6;
  for (size_t i = 0; right && i < 6; ++i) {
    right = extent[i].is_number();
    if (right) e[i] = extent[i].get<double>();
    right = right && std::isfinite(e[i]);
  }
  if (!right) throw Error(where + ": \"extent\": expected six numbers: xmin, xmax, ymin, ymax, zmin, zmax");
  const Box box{{e[0], e[2], e[4]}, {e[1], e[3], e[5]}};
  if (box.empty()) throw Error(where + ": \"extent\": a minimum is above its maximum");
  return box;
}

GeometryPart parseEntry(const json& entry, const std::string& where) {
  if (!entry.is_object()) throw Error(where + ": expected an object with \"extent\" and \"filename\"");
  GeometryPart part;
  if (entry.contains("extent")) part.extent = parseExtent(entry["extent"], where);
  if (entry.contains("host") || entry.contains("port"))
    throw Error(where +
                ": pieces sent over a socket (\"host\", \"port\") are not supported; expected \"filename\"");
  const auto name = entry.find("filename");
  if (name == entry.end()) throw Error(where + ": key \"filename\" is missing");
  if (!name->is_string()) throw Error(where + ": \"filename\": expected a string");
  part.file = name->get<std::string>();
  if (part.file.empty() || part.file.find('\0') != std::string::npos)
    throw Error(where + ": \"filename\" is empty or not a name");
  for (const auto& [key, value] : entry.items())
    if (key != "extent" && key != "filename")
      spdlog::warn("{}: unknown key {} is ignored", where, inQuotes(key));
  return part;
}

}  // namespace

std::vector<GeometryPart> parsePart(std::string_view text, const std::string& where) {
  json document;
  try {
    document = json::parse(text);
  } catch (const json::exception& e) {
    throw Error(where + ": not valid JSON: " + e.what());
  }
  if (!document.is_object() || !document.contains("parts") || !document["parts"].is_array())
    throw Error(where + ": expected a JSON object with an array \"parts\"");
  if (document["parts"].empty()) throw Error(where + ": \"parts\" is empty");
  std::vector<GeometryPart> parts;
  for (const json& entry : document["parts"])
    parts.push_back(parseEntry(entry, where + ": part " + std::to_string(parts.size())));
  return parts;
}

std::string formatPart(const std::vector<GeometryPart>& parts) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const GeometryPart& part : parts) {
    const glm::dvec3 &lo = part.extent.lo, &hi = part.extent.hi;
    list.push_back({{"extent", {lo.x, hi.x, lo.y, hi.y, lo.z, hi.z}}, {"filename", part.file}});
  }
  return nlohmann::ordered_json{{"parts", list}}.dump(2) + "\n";
}

}  // namespace gxy
