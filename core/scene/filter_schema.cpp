// SPDX-License-Identifier: Apache-2.0
#include "core/scene/filter_schema.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/comm/error.h"
#include "core/scene/dataset_type.h"

namespace gxy {

OrderedJson jsonOf(const JsonValue& value) {
  if (const bool* b = value.boolean()) return *b;
  if (const JsonNumber* n = value.number()) {
    constexpr double kExact = 9007199254740992;
    return n->integral && std::abs(n->value) <= kExact ? OrderedJson(int64_t(n->value))
                                                       : OrderedJson(n->value);
  }
  if (const std::string* s = value.string()) return *s;
  if (const JsonValue::Array* items = value.array()) {
    OrderedJson out = OrderedJson::array();
    for (const JsonValue& item : *items) out.push_back(jsonOf(item));
    return out;
  }
  if (const JsonValue::Object* members = value.object()) {
    OrderedJson out = OrderedJson::object();
    for (const JsonMember& member : *members) out[member.key] = jsonOf(member.value);
    return out;
  }
  return nullptr;
}

namespace {

constexpr size_t kMostInputs = 256;

bool isCommon(const std::string& key) {
  const auto& keys = filterEntrySchema().keys;
  return std::any_of(keys.begin(), keys.end(), [&](const auto& known) {
    return known.info.name == key ||
           std::count(known.info.aliases.begin(), known.info.aliases.end(), key) > 0;
  });
}

/// The keys that all entries have, and the filter's own.
std::pair<JsonValue, JsonValue> split(const JsonValue& entry) {
  JsonValue common{entry.at, JsonValue::Object()}, own{entry.at, JsonValue::Object()};
  for (const JsonMember& member : *entry.object())
    std::get<JsonValue::Object>((isCommon(member.key) ? common : own).value).push_back(member);
  return {std::move(common), std::move(own)};
}

void readInputs(const Found& found, DatasetSpec& dataset) {
  const JsonValue::Object* members = found.value.object();
  if (!members) found.fail("an object: for each input the name of a dataset, or a list of names");
  for (const JsonMember& member : *members) {
    FilterInput& input = dataset.inputs.emplace_back();
    input.input = member.key;
    readOneOrMany(Found{found.context, member.key, member.value, found.value}, [&](const Found& name) {
      if (input.datasets.size() == kMostInputs) name.fail("at most 256 datasets for an input");
      input.datasets.push_back(name.text());
    });
    if (dataset.inputs.size() > kMostInputs) found.fail("at most 256 inputs");
  }
}

OrderedJson writeInputs(const DatasetSpec& dataset) {
  OrderedJson out = nullptr;
  for (const FilterInput& input : dataset.inputs)
    out[input.input] =
        input.datasets.size() == 1 ? OrderedJson(input.datasets[0]) : OrderedJson(input.datasets);
  return out;
}

std::string quotedNames(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + inQuotes(name, '`');
  return text;
}

std::vector<std::string> namesOf(const std::vector<FilterPort>& ports) {
  std::vector<std::string> names;
  for (const FilterPort& port : ports)
    if (port.count != FilterPort::Count::AnyName) names.push_back(port.name);
  return names;
}

// What inputs there are and are not, whatever they mean.
void checkNames(const FilterSchema& filter, const DatasetSpec& entry) {
  const std::string where = "dataset " + inQuotes(entry.name) + ": filter " + filter.name + ": ";
  for (const FilterInput& input : entry.inputs) {
    const FilterPort* port = filter.port(input.input);
    if (!port)
      throw Error(
          where + "there is no input " + inQuotes(input.input, '`') +
          suggestion(input.input, namesOf(filter.inputs)) +
          (filter.inputs.empty() ? "; expected none" : "; expected " + quotedNames(namesOf(filter.inputs))));
    if (!port->takesMany() && input.datasets.size() != 1)
      throw Error(where + "input " + inQuotes(input.input, '`') + ": expected one dataset, found " +
                  std::to_string(input.datasets.size()));
  }
}

void checkNoneMissing(const FilterSchema& filter, const DatasetSpec& entry) {
  const std::vector<const FilterPort*> missing = missingInputs(filter, entry);
  if (missing.empty()) return;
  throw Error("dataset " + inQuotes(entry.name) + ": filter " + filter.name + ": input " +
              inQuotes(missing[0]->name, '`') + " is missing, expected " + gxy::namesOf(missing[0]->types));
}

void readOwnKeys(const Found& item, const FilterSchema& filter, const JsonValue& own, DatasetSpec& dataset) {
  try {
    checkNames(filter, dataset);
    checkNoneMissing(filter, dataset);
  } catch (const Error& e) {
    item.context.fail(item.value.at, e.what());
  }
  const bool isTyped = item.value.find("type") != nullptr;
  const bool isFixed = filter.makes && filter.makesLike.empty();
  if (isFixed && isTyped && dataset.type != *filter.makes)
    item.context.fail(item.value.at, "dataset " + inQuotes(dataset.name) + ": filter " + filter.name +
                                         " makes " + gxy::namesOf(bitOf(*filter.makes)) + ", found type " +
                                         gxy::namesOf(bitOf(dataset.type)));
  if (isFixed || (filter.makes && !isTyped)) dataset.type = *filter.makes;
  if (filter.makes && dataset.name.empty())
    item.context.fail(item.value.at, "filter " + filter.name +
                                         ": `name` is missing, expected that of the dataset to be made");
  dataset.properties = filter.read(item.context, own);
}

}  // namespace

std::string namesOf(unsigned types) {
  std::vector<std::string> names;
  for (int i = 0; i < kDatasetTypes; i++)
    if (types & bitOf(DatasetType(i))) names.push_back(nameOf(DatasetType(i)));
  if (types & kUnstructured) names.front() += " (also unstructured)";
  std::string text;
  for (size_t i = 0; i < names.size(); i++)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
  return text;
}

std::optional<DatasetType> FilterSchema::typeMadeBy(
    const DatasetSpec& entry,
    const std::function<std::optional<DatasetType>(const std::string&)>& typeOf) const {
  if (makesLike.empty()) return makes;
  for (const FilterInput& input : entry.inputs)
    if (input.input == makesLike && !input.datasets.empty()) return typeOf(input.datasets[0]);
  return std::nullopt;
}

std::string FilterSchema::madeText() const {
  if (!makes) return "no dataset: it tells numbers";
  return makesLike.empty() ? gxy::namesOf(bitOf(*makes)) : "what " + inQuotes(makesLike, '`') + " is";
}

const FilterPort* FilterSchema::port(const std::string& input) const {
  const FilterPort* any = nullptr;
  for (const FilterPort& p : inputs) {
    if (p.count == FilterPort::Count::AnyName)
      any = &p;
    else if (p.name == input)
      return &p;
  }
  return any;
}

const Schema<DatasetSpec>& filterEntrySchema() {
  using D = DatasetSpec;
  static const Schema<D> schema{
      "dataset that a filter makes",
      {
          textKey("name", &D::name, "What operators and other filters call it; each name once."),
          customKey<D>("type", "Volume, Particles, PathLines or Triangles", "What the filter makes.",
                       readDatasetType,
                       [](const D& d) {
                         return d.typeIsKnown ? OrderedJson(gxy::namesOf(bitOf(d.type))) : OrderedJson();
                       })
              .byDefault("what the filter makes"),
          customKey<D>(
              "filter", "text", "The name of a filter.", [](const Found& f, D& d) { d.filter = f.text(); },
              [](const D& d) { return OrderedJson(d.filter); })
              .require(),
          customKey<D>("inputs", "object",
                       "For each input of the filter the name of a dataset, or a list of names.", readInputs,
                       writeInputs)
              .byDefault("none"),
          colorKey("color", &D::color, "Colour of geometry that has no values to map.")
              .alias({"default color"}),
      }};
  return schema;
}

DatasetSpec readFilterEntry(const Found& item) {
  DatasetSpec dataset;
  auto [common, own] = split(item.value);
  readObject(item.context, common, filterEntrySchema(), dataset);
  if (dataset.filter.empty())
    item.context.fail(item.value.find("filter")->at, "`filter`: expected a name, found an empty text");
  if (!item.context.filters) {
    dataset.typeIsKnown = item.value.find("type") != nullptr;
    if (!own.object()->empty())
      dataset.properties = jsonOf(own).dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
    return dataset;
  }
  const FilterSchema* filter = item.context.filters->find(dataset.filter);
  if (!filter) {
    const std::vector<std::string> names = item.context.filters->names();
    item.context.fail(item.value.find("filter")->value.at, "there is no filter " + inQuotes(dataset.filter) +
                                                               suggestion(dataset.filter, names) +
                                                               "; expected one of " + quotedNames(names));
  }
  readOwnKeys(item, *filter, own, dataset);
  return dataset;
}

OrderedJson writeFilterEntry(const DatasetSpec& dataset) {
  OrderedJson out = writeObject(dataset, filterEntrySchema());
  if (dataset.properties.empty()) return out;
  const OrderedJson own = OrderedJson::parse(dataset.properties);
  for (const auto& [key, value] : own.items()) out[key] = value;
  return out;
}

void checkInputs(const FilterSchema& filter, const DatasetSpec& entry,
                 const std::function<std::optional<DatasetType>(const std::string&)>& typeOf,
                 Missing missing) {
  checkNames(filter, entry);
  if (missing == Missing::Refused) checkNoneMissing(filter, entry);
  for (const FilterInput& input : entry.inputs)
    for (const std::string& dataset : input.datasets) {
      const auto type = typeOf(dataset);
      const FilterPort& port = *filter.port(input.input);
      if (type && !(port.types & bitOf(*type)))
        throw Error("dataset " + inQuotes(entry.name) + ": filter " + filter.name + ": input " +
                    inQuotes(input.input, '`') + ": expected " + gxy::namesOf(port.types) + ", found " +
                    inQuotes(dataset) + ", which is " + gxy::namesOf(bitOf(*type)));
    }
}

std::vector<const FilterPort*> missingInputs(const FilterSchema& filter, const DatasetSpec& entry) {
  std::vector<const FilterPort*> missing;
  for (const FilterPort& port : filter.inputs) {
    if (port.mayLack()) continue;
    const bool there = std::any_of(entry.inputs.begin(), entry.inputs.end(), [&](const FilterInput& input) {
      return input.input == port.name && !input.datasets.empty();
    });
    if (!there) missing.push_back(&port);
  }
  return missing;
}

std::vector<size_t> evaluationOrder(const std::vector<DatasetSpec>& datasets) {
  std::map<std::string, size_t> places;
  for (size_t i = 0; i < datasets.size(); i++) places.emplace(datasets[i].name, i);
  enum class State { Unseen, Open, Done };
  std::vector<State> states(datasets.size(), State::Unseen);
  std::vector<size_t> order;
  // Depth first, without recursion: `path` are the open datasets, each with the next of its inputs to look at.
  struct Step {
    size_t place;
    std::vector<size_t> inputs;
  };
  const auto opened = [&](size_t place) {
    states[place] = State::Open;
    Step step{place, {}};
    for (const FilterInput& input : datasets[place].inputs)
      for (const std::string& name : input.datasets)
        if (const auto found = places.find(name); found != places.end()) step.inputs.push_back(found->second);
    return step;
  };
  for (size_t root = 0; root < datasets.size(); root++) {
    std::vector<Step> path;
    if (states[root] == State::Unseen) path.push_back(opened(root));
    while (!path.empty()) {
      Step& step = path.back();
      if (step.inputs.empty()) {
        states[step.place] = State::Done;
        if (!datasets[step.place].filter.empty()) order.push_back(step.place);
        path.pop_back();
        continue;
      }
      const size_t next = step.inputs.back();
      step.inputs.pop_back();
      if (states[next] == State::Open) {
        size_t first = path.size() - 1;  // of the cycle
        while (path[first].place != next) first--;
        std::string cycle;
        for (size_t i = first; i < path.size(); i++) cycle += inQuotes(datasets[path[i].place].name) + " of ";
        throw Error("datasets are made of each other, expected no cycle: " + cycle +
                    inQuotes(datasets[next].name));
      }
      if (states[next] == State::Unseen) path.push_back(opened(next));
    }
  }
  return order;
}

std::string filterReference(const FilterSchemas& filters) {
  std::string out;
  for (const std::string& name : filters.names()) {
    const FilterSchema& filter = *filters.find(name);
    out += "### " + name + "\n\n" + filter.help + " It makes " + filter.madeText() + ".\n\n";
    if (!filter.inputs.empty()) out += "| input | takes | meaning |\n|---|---|---|\n";
    for (const FilterPort& port : filter.inputs) {
      const bool any = port.count == FilterPort::Count::AnyName;
      out += "| " + (any ? port.name : inQuotes(port.name, '`')) + " | " + gxy::namesOf(port.types) +
             (port.count == FilterPort::Count::Optional ? ", optional" : "") +
             (port.count == FilterPort::Count::Many ? ", one or more" : "") +
             (port.count == FilterPort::Count::Any ? ", none or more" : "") + (any ? ", any number" : "") +
             " | " + port.help + " |\n";
    }
    if (!filter.inputs.empty()) out += "\n";
    if (!filter.properties.empty()) out += "| key | value | default | meaning |\n|---|---|---|---|\n";
    for (const KeyInfo& key : filter.properties)
      out += "| " + inQuotes(key.name, '`') + " | " + key.type + " | " +
             (key.required ? "required" : key.defaultText) + " | " + key.meaning + " |\n";
    if (!filter.properties.empty()) out += "\n";
  }
  return out;
}

}  // namespace gxy
