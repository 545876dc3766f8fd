// SPDX-License-Identifier: Apache-2.0
// The schema of the state file: one table per kind of object. Its rows drive reading, the checks and their
// messages, writing, and the reference in docs/state-file.md.
#pragma once
#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/scene/read_context.h"

namespace gxy {

using OrderedJson = nlohmann::ordered_json;

/// Returns a value as it was read; whole numbers as integers where these are exact.
OrderedJson jsonOf(const JsonValue& value);

/// The description of a key.
struct KeyInfo {
  std::string name;
  std::vector<std::string> aliases;
  std::string type;  ///< in words, range included: "number > 0"
  std::string meaning;
  std::string defaultText;  ///< default value in words; empty: the saved form of a default T
  bool required = false;
  unsigned appliesTo = ~0u;  ///< bits 1 << VisType, for keys of operators
  std::string needs;         ///< a flag in an earlier row without which this key has no effect; empty: none
  bool advanced = false;     ///< forms show it only when asked
};

/// One row: a key of the objects that describe a T.
template <class T>
struct KeyRow {
  KeyInfo info;
  std::function<void(const Found&, T&)> read;
  std::function<OrderedJson(const T&)> write;  ///< returns null if the key is not saved
  bool T::*flag = nullptr;                     ///< the member that the key info.needs sets

  KeyRow alias(std::vector<std::string> names) && {
    info.aliases = std::move(names);
    return std::move(*this);
  }
  KeyRow require() && {
    info.required = true;
    return std::move(*this);
  }
  KeyRow only(unsigned types) && {
    info.appliesTo = types;
    return std::move(*this);
  }
  KeyRow with(std::string other, bool T::*member) && {
    info.needs = std::move(other);
    flag = member;
    return std::move(*this);
  }
  KeyRow advanced() && {
    info.advanced = true;
    return std::move(*this);
  }
  KeyRow byDefault(std::string text) && {
    info.defaultText = std::move(text);
    return std::move(*this);
  }
};

template <class T>
struct Schema {
  std::string title;  ///< name of the object in messages and the reference, such as "operator"
  std::vector<KeyRow<T>> keys;
};

/// The bit of KeyInfo::appliesTo for an object's type. Objects without types have all bits.
template <class T>
unsigned typeBit(const T&) {
  return ~0u;
}
inline unsigned typeBit(const Vis& vis) { return 1u << unsigned(vis.type); }
inline unsigned typeBit(const DatasetSpec& dataset) { return 1u << unsigned(dataset.type); }

/// Whether the key has an effect on an object. The rows before it must have been read into the object.
template <class T>
bool hasEffect(const KeyRow<T>& key, const T& t) {
  return (key.info.appliesTo & typeBit(t)) && (!key.flag || t.*key.flag);
}

inline std::string withRange(const std::string& noun, const Limits& limits) {
  const std::string range = limits.text();
  return range.empty() ? noun : noun + " " + range;
}

inline OrderedJson toJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
inline OrderedJson toJson(const glm::dvec4& v) { return {v.x, v.y, v.z, v.w}; }
inline OrderedJson toJson(const std::vector<Plane>& planes) {
  OrderedJson out = nullptr;  // an empty list is not saved
  for (const Plane& p : planes) out.push_back({p.normal.x, p.normal.y, p.normal.z, p.offset});
  return out;
}

// Rows for members of simple types.
template <class T>
KeyRow<T> numberKey(std::string name, double T::*member, Limits limits, std::string meaning) {
  return {{std::move(name), {}, withRange("number", limits), std::move(meaning), "", false, ~0u, ""},
          [=](const Found& found, T& t) { t.*member = found.number(limits); },
          [=](const T& t) { return OrderedJson(t.*member); }};
}
template <class T>
KeyRow<T> integerKey(std::string name, int T::*member, Limits limits, std::string meaning) {
  return {{std::move(name), {}, withRange("integer", limits), std::move(meaning), "", false, ~0u, ""},
          [=](const Found& found, T& t) { t.*member = found.integer(limits); },
          [=](const T& t) { return OrderedJson(t.*member); }};
}
template <class T>
KeyRow<T> flagKey(std::string name, bool T::*member, std::string meaning) {
  return {{std::move(name), {}, "true or false", std::move(meaning), "", false, ~0u, ""},
          [=](const Found& found, T& t) { t.*member = found.boolean(); },
          [=](const T& t) { return OrderedJson(t.*member); }};
}
template <class T>
KeyRow<T> textKey(std::string name, std::string T::*member, std::string meaning) {
  return {{std::move(name), {}, "text", std::move(meaning), "empty", false, ~0u, ""},
          [=](const Found& found, T& t) { t.*member = found.text(); },
          [=](const T& t) { return (t.*member).empty() ? OrderedJson() : OrderedJson(t.*member); }};
}
template <class T>
KeyRow<T> vectorKey(std::string name, glm::dvec3 T::*member, std::string meaning) {
  return {{std::move(name), {}, "[x, y, z]", std::move(meaning), "", false, ~0u, ""},
          [=](const Found& found, T& t) { t.*member = found.vec3(); },
          [=](const T& t) { return toJson(t.*member); }};
}
template <class T>
KeyRow<T> colorKey(std::string name, glm::dvec4 T::*member, std::string meaning) {
  return {
      {std::move(name), {}, "[r, g, b] or [r, g, b, a] of 0 to 1", std::move(meaning), "", false, ~0u, ""},
      [=](const Found& found, T& t) { t.*member = found.color(); },
      [=](const T& t) { return toJson(t.*member); }};
}

/// The same for a colour that may be absent.
template <class T>
KeyRow<T> colorKey(std::string name, std::optional<glm::dvec4> T::*member, std::string meaning) {
  return {
      {std::move(name), {}, "[r, g, b] or [r, g, b, a] of 0 to 1", std::move(meaning), "", false, ~0u, ""},
      [=](const Found& found, T& t) { t.*member = found.color(); },
      [=](const T& t) { return t.*member ? toJson(*(t.*member)) : OrderedJson(); }};
}

/// A row with a reader of its own and, if the key is saved, a writer.
template <class T, class Read>
KeyRow<T> customKey(
    std::string name, std::string type, std::string meaning, Read read,
    std::function<OrderedJson(const T&)> write = [](const T&) { return OrderedJson(); }) {
  return {{std::move(name), {}, std::move(type), std::move(meaning), "", false, ~0u, ""},
          std::move(read),
          std::move(write)};
}

namespace detail {

template <class T>
bool named(const KeyRow<T>& key, const std::string& name) {
  return key.info.name == name || std::count(key.info.aliases.begin(), key.info.aliases.end(), name) > 0;
}

template <class T>
void warnOfUnknownKeys(ReadContext& context, const JsonValue& value, const Schema<T>& schema) {
  std::vector<std::string> names;
  for (const KeyRow<T>& key : schema.keys) names.push_back(key.info.name);
  for (const JsonMember& member : *value.object()) {
    const bool known = std::any_of(schema.keys.begin(), schema.keys.end(),
                                   [&](const KeyRow<T>& key) { return named(key, member.key); });
    if (known) continue;
    context.warn(member.at, "unknown key " + inQuotes(member.key, '`') + " in the " + schema.title +
                                suggestion(member.key, names));
  }
}

template <class T>
const JsonMember* findMember(ReadContext& context, const JsonValue& value, const KeyRow<T>& key) {
  const JsonMember* found = nullptr;
  for (const JsonMember& member : *value.object()) {
    if (!named(key, member.key)) continue;
    if (found) {
      context.fail(member.at, inQuotes(member.key, '`') + ": means the same as " + inQuotes(found->key, '`') +
                                  " on line " + std::to_string(found->at.line) + "; expected one of them");
    }
    found = &member;
  }
  return found;
}

}  // namespace detail

/// Reads an object by its schema into `out`, in the order of the rows, so that a row may rely on earlier ones.
/// Absent keys leave `out` as it is. Unknown keys and keys without effect on this object give a warning. Throws
/// Error with the position for a missing required key, a key and its alias together, and wrong values.
template <class T>
void readObject(ReadContext& context, const JsonValue& value, const Schema<T>& schema, T& out) {
  if (!value.object())
    context.fail(value.at, "expected an object (" + schema.title + "), found " + value.describe());
  detail::warnOfUnknownKeys(context, value, schema);
  for (const KeyRow<T>& key : schema.keys) {
    const JsonMember* member = detail::findMember(context, value, key);
    if (!member) {
      if (key.info.required)
        context.fail(value.at, schema.title + " without " + inQuotes(key.info.name, '`') + "; expected " +
                                   key.info.type);
      continue;
    }
    key.read(Found{context, member->key, member->value, value}, out);
    if (!hasEffect(key, out)) {
      const bool otherType = !(key.info.appliesTo & typeBit(out));
      context.warn(member->at, inQuotes(member->key, '`') + " has no effect " +
                                   (otherType ? "on this type of " + schema.title
                                              : "without " + inQuotes(key.info.needs, '`')));
    }
  }
}

/// Calls readOne(found) for one object, or for each object of a list.
template <class ReadOne>
void readOneOrMany(const Found& found, ReadOne readOne) {
  if (!found.value.array()) return readOne(found);
  for (const Found& item : found.list("a list")) readOne(item);
}

/// Returns the saved form: all keys, except those that are empty and those that have no effect and their
/// default value.
template <class T>
OrderedJson writeObject(const T& t, const Schema<T>& schema) {
  OrderedJson out = OrderedJson::object();
  for (const KeyRow<T>& key : schema.keys) {
    OrderedJson value = key.write(t);
    const bool idle = !hasEffect(key, t) && value == key.write(T{});
    if (!value.is_null() && !idle) out[key.info.name] = std::move(value);
  }
  return out;
}

const Schema<Camera>& cameraSchema();
const Schema<Lighting>& lightingSchema();
const Schema<Vis>& operatorSchema();
const Schema<Visualization>& visualizationSchema();
const Schema<DatasetSpec>& datasetSchema();
const Schema<RenderSettings>& rendererSchema();
const Schema<OutputSpec>& outputSchema();
const Schema<Annotations>& annotationsSchema();
const Schema<State>& stateSchema();

/// Reads the key `type` of a dataset.
void readDatasetType(const Found& found, DatasetSpec& dataset);

/// Reads a camera of a state file: an object, or the name of a ParaView camera file.
Camera readCamera(const Found& found);

// The map keys of an operator.
/// Reads the colour map. If a preset file has opacities, they become the opacity map of an operator with
/// volume rendering.
void readColorMap(const Found& found, Vis& vis);
OpacityMap readOpacityMap(const Found& found, bool extinction);
OrderedJson toJson(const ColorMap& map);
OrderedJson toJson(const OpacityMap& map);

}  // namespace gxy
