// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/trigger.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <set>

#include "core/comm/error.h"
#include "core/scene/json_text.h"
#include "insitu/plan/description.h"
#include "multiserver/protocol/json.h"

namespace gxy {

using nlohmann::json;

namespace {

constexpr struct {
  const char* key;
  Trigger::Threshold::Kind kind;
} kKinds[] = {{"above", Trigger::Threshold::Kind::Above},
              {"below", Trigger::Threshold::Kind::Below},
              {"nodata", Trigger::Threshold::Kind::NoData}};

[[noreturn]] void fail(const std::string& key, const std::string& expected) {
  throw Error("trigger: `" + key + "`: expected " + expected);
}

void expectKeys(const json& object, const std::set<std::string>& known, const std::string& what) {
  std::string names;
  for (const std::string& k : known) names += (names.empty() ? "`" : ", `") + k + "`";
  for (const auto& [key, value] : object.items())
    if (known.count(key) == 0) throw Error(what + ": unknown key " + inQuotes(key) + ", expected " + names);
}

void readWhen(const json& when, Trigger& trigger) {
  if (!when.is_object() || when.empty()) fail("when", "an object with `every`, `above`, `below` or `nodata`");
  expectKeys(when, {"every", "above", "below", "nodata"}, "trigger: `when`");
  if (const auto every = when.find("every"); every != when.end()) {
    if (!every->is_number_integer() || every->get<int64_t>() < 1)
      fail("every", "an integer from 1 up, of steps");
    trigger.every = every->get<int64_t>();
  }
  for (const auto& [key, kind] : kKinds) {
    const auto given = when.find(key);
    if (given == when.end()) continue;
    if (!given->is_object() || given->empty()) fail(key, "an object with a number for each field");
    for (const auto& [field, value] : given->items()) {
      if (!value.is_number() || !std::isfinite(value.get<double>()))
        fail(key, "a number for field " + inQuotes(field));
      insitu::checkName(field, "field");
      trigger.thresholds.push_back({kind, field, value.get<double>()});
    }
  }
}

void readSteer(const json& document, Trigger& trigger) {
  const json values = document.value("steer", json());
  const bool steers = trigger.does == Trigger::Does::Steer;
  if (steers != (values.is_object() && !values.empty()) || (!steers && document.contains("steer")))
    fail("steer", "with \"do\": \"steer\", and only then, an object with a number for each parameter");
  if (!steers) return;
  for (const auto& [name, value] : values.items()) {
    if (!value.is_number()) fail("steer", "a number for parameter " + inQuotes(name));
    trigger.steer[name] = value.get<double>();
  }
}

constexpr struct {
  const char* word;
  Trigger::Does does;
} kDeeds[] = {{"batch", Trigger::Does::Batch},
              {"cinema", Trigger::Does::Cinema},
              {"event", Trigger::Does::Event},
              {"steer", Trigger::Does::Steer}};

const char* wordOf(Trigger::Does does) {
  for (const auto& deed : kDeeds)
    if (deed.does == does) return deed.word;
  return "";
}

bool hasStep(const json& text) {
  return text.is_string() && text.get<std::string>().find("{step}") != std::string::npos;
}

bool hasTimeAxis(const json& sweep) {
  const json axes = sweep.is_object() ? sweep.value("axes", json()) : json();
  return axes.is_array() && std::any_of(axes.begin(), axes.end(), [](const json& axis) {
           return axis.is_object() && axis.value("axis", json()) == "time";
         });
}

/// Reads what a trigger renders.
void readDocument(const json& document, Trigger& trigger) {
  for (const Trigger::Does does : {Trigger::Does::Batch, Trigger::Does::Cinema}) {
    const char* word = wordOf(does);
    const json given = document.value(word, json());
    if ((trigger.does == does) != given.is_object())
      fail(word, "with \"do\": \"" + std::string(word) + "\", and only then, an object as `viewer." + word +
                     "` takes it");
    if (trigger.does == does) trigger.document = given;
  }
  json& what = trigger.document;
  if (trigger.does == Trigger::Does::Batch) {
    what["prefix"] = what.value("prefix", json("picture-{step}"));
    if (!hasStep(what["prefix"]))
      fail("prefix", "a text with {step} in it, so that no picture replaces another");
    if (what.value("to", json("files")) != "files")
      fail("to", "\"files\", as there is no client that pictures could be sent to");
  }
  if (trigger.does == Trigger::Does::Cinema) {
    if (!what.value("to", json()).is_string()) fail("to", "a text, the name of a database");
    if (what.contains("steps")) fail("steps", "none, as the trigger says for which steps it is");
    if (!hasStep(what["to"]) && !hasTimeAxis(what.value("sweep", json())))
      fail("sweep", "an axis \"time\", or else `to` with {step} in it, so that no step replaces another");
  }
}

}  // namespace

Trigger readTrigger(const json& document) {
  if (!document.is_object()) throw Error("trigger: expected an object with `name`, `when` and `do`");
  expectKeys(document, {"name", "when", "do", "batch", "cinema", "steer", "exact"}, "trigger");
  Trigger trigger;
  const auto name = document.find("name");
  if (name == document.end() || !name->is_string()) fail("name", "a text");
  trigger.name = name->get<std::string>();
  insitu::checkName(trigger.name, "trigger");
  readWhen(document.value("when", json()), trigger);
  const json what = document.value("do", json());
  const auto* deed =
      std::find_if(std::begin(kDeeds), std::end(kDeeds), [&](const auto& d) { return what == d.word; });
  if (deed == std::end(kDeeds)) fail("do", "\"batch\", \"cinema\", \"event\" or \"steer\"");
  trigger.does = deed->does;
  readSteer(document, trigger);
  readDocument(document, trigger);
  const json exact = document.value("exact", json(false));
  if (!exact.is_boolean()) fail("exact", "true or false");
  trigger.exact = exact.get<bool>();
  return trigger;
}

json written(const Trigger& trigger) {
  json when = json::object();
  if (trigger.every > 0) when["every"] = trigger.every;
  for (const Trigger::Threshold& t : trigger.thresholds)
    for (const auto& [key, kind] : kKinds)
      if (kind == t.kind) when[key][t.field] = t.value;
  json document{{"name", trigger.name}, {"when", when}, {"exact", trigger.exact}};
  document["do"] = wordOf(trigger.does);
  if (trigger.does == Trigger::Does::Steer) document["steer"] = trigger.steer;
  if (trigger.document.is_object()) document[wordOf(trigger.does)] = trigger.document;
  return document;
}

namespace {
// A step so many steps later, or the last one that there can be.
int64_t later(int64_t step, int64_t steps) { return step > INT64_MAX - steps ? INT64_MAX : step + steps; }
}  // namespace

bool TriggerCondition::holds(int64_t step, const ValuesOf& valuesOf) {
  bool hold = true;
  for (const Trigger::Threshold& t : thresholds_) {
    const StepValues values = valuesOf(t.field);
    hold = hold && (t.kind == Trigger::Threshold::Kind::Above   ? values.largest > t.value
                    : t.kind == Trigger::Threshold::Kind::Below ? values.least < t.value
                                                                : double(values.noData) > t.value);
  }
  const bool before = std::exchange(held_, hold);
  if (!hold || (every_ == 0 && before)) return false;
  if (every_ > 0 && last_ && step < later(*last_, every_)) return false;
  last_ = step;
  return true;
}

std::optional<int64_t> TriggerCondition::next() const {
  if (!thresholds_.empty() || !last_) return std::nullopt;
  return later(*last_, every_);
}

std::string nameAtStep(const std::string& pattern, int64_t step) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%08lld", static_cast<long long>(step));
  std::string name = pattern;
  constexpr std::string_view kStep = "{step}";
  for (size_t at = 0; (at = name.find(kStep, at)) != std::string::npos;
       at += std::char_traits<char>::length(digits))
    name.replace(at, kStep.size(), digits);
  return name;
}

std::string statementOf(const Trigger& trigger, int64_t step) {
  if (!trigger.document.is_object()) return {};
  json document = trigger.document;
  json& name = document[trigger.does == Trigger::Does::Batch ? "prefix" : "to"];
  name = nameAtStep(name.get<std::string>(), step);
  return std::string("viewer.") + wordOf(trigger.does) + " " + protocol::dump(document);
}

}  // namespace gxy
