// SPDX-License-Identifier: Apache-2.0
#include "core/scene/paraview_camera.h"

#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "core/comm/error.h"
#include "core/scene/json_text.h"
#include "core/scene/xml_tags.h"

namespace gxy {
namespace {

/// The values of every property, by name.
using Properties = std::map<std::string, std::vector<double>, std::less<>>;

double parseNumber(std::string_view text, const std::string& where) {
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(x)) {
    throw Error(where + "expected a number, found " + inQuotes(text));
  }
  return x;
}

/// ParaView writes start tags with quoted attributes only, so going from tag to tag is enough to read the file.
Properties fromXml(std::string_view text, const std::string& sourceName) {
  if (text.find("<PVCameraConfiguration") == std::string_view::npos) {
    throw Error(sourceName + ": expected a ParaView camera, with a PVCameraConfiguration element");
  }
  Properties out;
  std::string current;
  forEachTag(text, sourceName, [&](std::string_view tag) {
    if (tag.starts_with("<Property ")) {
      current = attributeOf(tag, "name").value_or("");
    } else if (tag.starts_with("</Property")) {
      current.clear();
    } else if (tag.starts_with("<Element ") && !current.empty()) {
      if (const auto value = attributeOf(tag, "value"))
        out[current].push_back(parseNumber(*value, sourceName + ": " + inQuotes(current, '`') + ": "));
    }
  });
  return out;
}

const JsonValue& descend(const JsonValue& value, std::string_view key, const std::string& sourceName) {
  const JsonMember* member = value.find(key);
  if (!member) {
    throw Error(locationPrefix(sourceName, value.at) + "no `" + std::string(key) +
                "`; expected a ParaView camera (PVCameraConfiguration / Proxy / Property)");
  }
  return member->value;
}

/// Converters from XML to JSON write a repeated element as a list, and a single one as the object itself.
std::vector<const JsonValue*> oneOrMany(const JsonValue& value) {
  if (!value.array()) return {&value};
  std::vector<const JsonValue*> out;
  for (const JsonValue& item : *value.array()) out.push_back(&item);
  return out;
}

Properties fromJson(std::string_view text, const std::string& sourceName) {
  const JsonValue root = parseJson(text, sourceName);
  const JsonValue& proxy = descend(descend(root, "PVCameraConfiguration", sourceName), "Proxy", sourceName);
  Properties out;
  for (const JsonValue* property : oneOrMany(descend(proxy, "Property", sourceName))) {
    const JsonMember* name = property->find("@name");
    const JsonMember* elements = property->find("Element");
    if (!name || !name->value.string() || !elements) continue;
    for (const JsonValue* element : oneOrMany(elements->value)) {
      const JsonMember* value = element->find("@value");
      if (!value) continue;
      const std::string where =
          locationPrefix(sourceName, value->value.at) + inQuotes(*name->value.string(), '`') + ": ";
      if (const JsonNumber* number = value->value.number()) {
        out[*name->value.string()].push_back(number->value);
      } else {
        const std::string* digits = value->value.string();
        out[*name->value.string()].push_back(parseNumber(digits ? *digits : value->value.describe(), where));
      }
    }
  }
  return out;
}

glm::dvec3 vector(const Properties& properties, std::string_view name, const std::string& sourceName) {
  const auto it = properties.find(name);
  if (it == properties.end() || it->second.size() != 3) {
    throw Error(sourceName + ": expected a ParaView camera with three values of " + std::string(name));
  }
  return {it->second[0], it->second[1], it->second[2]};
}

std::optional<double> scalar(const Properties& properties, std::string_view name) {
  const auto it = properties.find(name);
  if (it == properties.end() || it->second.empty()) return std::nullopt;
  return it->second.front();
}

}  // namespace

Camera parseParaViewCamera(std::string_view text, const std::string& sourceName) {
  const size_t start = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const bool json = start != std::string_view::npos && text[start] == '{';
  const Properties properties = json ? fromJson(text, sourceName) : fromXml(text, sourceName);
  Camera camera;
  camera.viewpoint = vector(properties, "CameraPosition", sourceName);
  camera.viewdirection = vector(properties, "CameraFocalPoint", sourceName) - camera.viewpoint;
  camera.viewup = vector(properties, "CameraViewUp", sourceName);
  camera.aov = scalar(properties, "CameraViewAngle").value_or(camera.aov);
  if (scalar(properties, "CameraParallelProjection").value_or(0) != 0) {
    camera.aov = 0;
    // The scale is half the window's height.
    camera.height = 2 * scalar(properties, "CameraParallelScale").value_or(1);
  }
  return camera;
}

}  // namespace gxy
