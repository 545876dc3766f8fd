// SPDX-License-Identifier: Apache-2.0
#include "multiserver/graph/document_edits.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <string>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {
namespace {

using nlohmann::json;

constexpr size_t kMostSteps = 64;    // of a path
constexpr size_t kMostEdits = 1000;  // of a request

std::string found(const json& value) {
  return inQuotes(value.dump(-1, ' ', false, json::error_handler_t::replace));
}

/// The place of a list's element; nothing: there is none.
std::optional<size_t> placeIn(const json& list, const json& step) {
  if (step.is_number_integer()) {
    const auto index = step.get<int64_t>();
    return index >= 0 && size_t(index) < list.size() ? std::optional(size_t(index)) : std::nullopt;
  }
  if (step.is_string())
    for (size_t i = 0; i < list.size(); i++)
      if (list[i].is_object() && list[i].value("name", json()) == step) return i;
  return std::nullopt;
}

/// One edit of a document.
class Edit {
 public:
  /// `isWhole` becomes true where only the whole document of before undoes an edit.
  Edit(json& document, json& inverse, bool& isWhole,
       std::vector<std::pair<std::string, std::string>>& renamedViews)
      : document_(document), inverse_(inverse), isWhole_(isWhole), renamedViews_(renamedViews) {}

  void apply(const json& edit) {
    if (!edit.is_object()) throw Error("expected an object, found " + found(edit));
    struct Kind {
      const char* key;
      void (Edit::*action)(const json& path, const json& edit);
    };
    for (const Kind& kind : {Kind{"set", &Edit::set}, Kind{"add", &Edit::add}, Kind{"remove", &Edit::remove},
                             Kind{"rename", &Edit::rename}}) {
      const char* const key = kind.key;
      const auto action = kind.action;
      const auto path = edit.find(key);
      if (path == edit.end()) continue;
      const bool hasValue = action != &Edit::remove;
      const size_t known = 1 + (hasValue ? 1 : 0) + (action == &Edit::add ? edit.count("at") : 0);
      if (hasValue && !edit.contains("to"))
        throw Error(std::string(key) + ": `to` is missing, expected a value");
      if (edit.size() != known)
        throw Error(std::string(key) + ": there are keys that mean nothing in this edit");
      if (!path->is_array() || path->size() > kMostSteps)
        throw Error(std::string(key) +
                    ": expected a path, a list of at most 64 keys, indices and names, found " + found(*path));
      return (this->*action)(*path, edit);
    }
    throw Error("expected `set`, `add`, `remove` or `rename`, found " + found(edit));
  }

 private:
  [[noreturn]] static void failAt(const json& path, size_t steps, const std::string& what) {
    throw Error(pathText(json(path.begin(), path.begin() + std::ptrdiff_t(steps))) + ": " + what);
  }

  /// Follows the first steps of a path.
  json& at(const json& path, size_t steps) {
    json* value = &document_;
    for (size_t i = 0; i < steps; i++) {
      const json& step = path[i];
      if (value->is_object() && step.is_string()) {
        const auto member = value->find(step.get<std::string>());
        if (member == value->end()) failAt(path, i + 1, "there is none");
        value = &*member;
      } else if (value->is_array()) {
        const auto place = placeIn(*value, step);
        if (!place) failAt(path, i + 1, "there is no such element");
        value = &(*value)[*place];
      } else {
        failAt(path, i + 1, "expected a key of an object or an element of a list, found " + found(step));
      }
    }
    return *value;
  }

  void set(const json& path, const json& edit) {
    const json& to = edit.at("to");
    if (path.empty()) {
      if (!to.is_object()) throw Error("set: the document is an object, found " + found(to));
      isWhole_ = true;
      document_ = to;
      return;
    }
    json& parent = at(path, path.size() - 1);
    if (parent.is_object() && path.back().is_string()) {
      const auto key = path.back().get<std::string>();
      const auto member = parent.find(key);
      inverse_.push_back(member == parent.end() ? json{{"remove", path}}
                                                : json{{"set", path}, {"to", *member}});
      parent[key] = to;
      return;
    }
    json& element = at(path, path.size());
    json back = path;  // by its place, since the element may get another name
    back.back() = *placeIn(parent, path.back());
    inverse_.push_back({{"set", back}, {"to", element}});
    element = to;
  }

  void add(const json& path, const json& edit) {
    if (path.empty()) throw Error("add: expected the path of a list, found []");
    json& parent = at(path, path.size() - 1);
    const bool isNew =
        parent.is_object() && path.back().is_string() && !parent.contains(path.back().get<std::string>());
    if (isNew) {
      parent[path.back().get<std::string>()] = json::array();
      inverse_.push_back({{"remove", path}});
    }
    json& list = at(path, path.size());
    if (!list.is_array()) failAt(path, path.size(), "expected a list, found " + found(list));
    size_t place = list.size();
    if (const auto index = edit.find("at"); index != edit.end()) {
      if (!index->is_number_unsigned() || index->get<uint64_t>() > list.size())
        failAt(path, path.size(),
               "`at`: expected 0 to " + std::to_string(list.size()) + ", found " + found(*index));
      place = index->get<size_t>();
    }
    list.insert(list.begin() + std::ptrdiff_t(place), edit.at("to"));
    if (isNew) return;
    json element = path;
    element.push_back(place);
    inverse_.push_back({{"remove", element}});
  }

  void remove(const json& path, const json&) {
    if (path.empty()) throw Error("remove: expected the path of a member or an element, found []");
    const json value = at(path, path.size());
    json& parent = at(path, path.size() - 1);
    if (parent.is_object()) {
      inverse_.push_back({{"set", path}, {"to", value}});
      parent.erase(path.back().get<std::string>());
      return;
    }
    const size_t place = *placeIn(parent, path.back());
    json list = path;
    list.erase(list.size() - 1);
    inverse_.push_back({{"add", list}, {"to", value}, {"at", place}});
    parent.erase(place);
  }

  void rename(const json& path, const json& edit);

  json& document_;
  json& inverse_;
  bool& isWhole_;
  std::vector<std::pair<std::string, std::string>>& renamedViews_;
};

/// Gives names that refer to an element another one.
class References {
 public:
  References(json& document, std::string section) : document_(document), section_(std::move(section)) {}

  /// Counts those of `from`, and makes them `to` unless that is empty.
  size_t replace(const std::string& from, const std::string& to) {
    from_ = from;
    to_ = to;
    count_ = 0;
    if (section_ == "Datasets") {
      forEach("Datasets", [&](json& dataset) {
        if (const auto inputs = dataset.find("inputs"); inputs != dataset.end() && inputs->is_object())
          for (json& input : *inputs) names(input);
      });
      forEach("Operators", [&](json& vis) { member(vis, "dataset"); });
      forEach("Visualizations", [&](json& view) {
        if (const auto all = view.find("operators"); all != view.end() && all->is_array())
          for (json& vis : *all) member(vis, "dataset");
      });
    }
    if (section_ == "Operators")
      forEach("Visualizations", [&](json& view) {
        if (const auto all = view.find("operators"); all != view.end()) names(*all);
      });
    if (section_ == "Datasets" || section_ == "Visualizations")
      forEach("Outputs", [&](json& output) { member(output, "of"); });
    return count_;
  }

 private:
  template <class F>
  void forEach(const char* section, const F& action) {
    const auto list = document_.find(section);
    if (list == document_.end() || !list->is_array()) return;
    for (json& element : *list)
      if (element.is_object()) action(element);
  }
  void member(json& object, const char* key) {
    if (!object.is_object()) return;
    if (const auto found = object.find(key); found != object.end()) name(*found);
  }
  void names(json& value) {
    if (!value.is_array()) return name(value);
    for (json& item : value) name(item);
  }
  void name(json& value) {
    if (!value.is_string() || value.get_ref<const std::string&>() != from_) return;
    count_++;
    if (!to_.empty()) value = to_;
  }

  json& document_;
  const std::string section_;
  std::string from_, to_;
  size_t count_ = 0;
};

void Edit::rename(const json& path, const json& edit) {
  static const std::set<std::string> sections{"Datasets", "Operators", "Visualizations", "Outputs"};
  const json& to = edit.at("to");
  if (path.size() != 2 || !path[0].is_string() || !sections.contains(path[0].get<std::string>()))
    throw Error(
        "rename: expected [\"Datasets\", \"Operators\", \"Visualizations\" or \"Outputs\", ELEMENT], found " +
        found(path));
  if (!to.is_string() || to.get_ref<const std::string&>().empty())
    failAt(path, 2, "`to`: expected a name, found " + found(to));
  json& element = at(path, 2);
  const std::string section = path[0].get<std::string>();
  const json old = element.is_object() ? element.value("name", json()) : json();
  if (!old.is_string()) failAt(path, 2, "it has no name; expected an element with one");
  const std::string from = old.get<std::string>(), name = to.get<std::string>();
  if (from == name) return;
  if (placeIn(at(path, 1), to))
    failAt(path, 2, "the name " + inQuotes(name) + " is in use, expected a free one");
  References references(document_, section);
  // Names that would be taken for those that are changed here cannot be told apart later.
  if (references.replace(name, "") > 0)
    isWhole_ = true;
  else
    inverse_.push_back({{"rename", json{section, name}}, {"to", from}});
  element["name"] = name;
  references.replace(from, name);
  if (section == "Visualizations") renamedViews_.emplace_back(from, name);
}

}  // namespace

std::string pathText(const json& path) {
  std::string text;
  for (size_t i = 0; i < path.size(); i++)
    if (path[i].is_string() && i != 1)
      text += (i == 0 ? "" : ".") + path[i].get<std::string>();
    else
      text += "[" + path[i].dump(-1, ' ', false, json::error_handler_t::replace) + "]";
  return text.empty() ? "document" : text;
}

EditedDocument edited(const json& document, const json& edits) {
  if (!edits.is_array() || edits.empty())
    throw Error("edit: `edits`: expected a list of edits, found " + found(edits));
  if (edits.size() > kMostEdits)
    throw Error("edit: there are " + std::to_string(edits.size()) + " edits, expected at most " +
                std::to_string(kMostEdits) + " in one request");
  EditedDocument out{document, json::array()};
  json inverse = json::array();
  bool isWhole = false;
  for (size_t i = 0; i < edits.size(); i++) try {
      Edit(out.document, inverse, isWhole, out.renamedViews).apply(edits[i]);
    } catch (const Error& e) {
      throw Error("edit: `edits`[" + std::to_string(i) + "]: " + e.what());
    }
  if (isWhole)
    out.inverse.push_back({{"set", json::array()}, {"to", document}});
  else
    std::move(inverse.rbegin(), inverse.rend(), std::back_inserter(out.inverse));
  return out;
}

}  // namespace gxy
