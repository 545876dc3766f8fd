// SPDX-License-Identifier: Apache-2.0
// Filters: algorithms that make a dataset, or tell numbers, from datasets.
//
// A filter is declared once, as a type:
//
//   struct Threshold {
//     double least = 0, largest = 0;                       // its properties
//     static FilterInfo info();                            // name, version, inputs, what it makes
//     static std::vector<KeyRow<Threshold>> properties();     // a row for each property (core/scene/schema.h)
//     FilterResult run(FilterRun& run) const;              // on all ranks together
//   };
//
// From this come the entry of a state file, the verb `make`, its evaluation by gxyrender, and the reference
// page. docs/modules.md walks through an example.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/dataset.h"
#include "core/scene/filter_schema.h"

namespace gxy {

class FieldMaker;
class Sampler;
class Tracer;

/// A generation of a dataset that a filter reads. It is pinned while the filter runs.
struct FilterSource {
  std::string name;  ///< for messages
  Key key{};
  Generation generation = 0;
  std::shared_ptr<const Dataset> data;
};

/// What a filter makes on one rank.
struct FilterResult {
  std::shared_ptr<Dataset> dataset;                ///< null if the filter makes none
  nlohmann::json told = nlohmann::json::object();  ///< members of the reply; those of rank 0 count
};

/// What the place where a filter runs gives to it, on each rank.
struct FilterServices {
  /// Enters bytes in the ledger for a purpose ("volume", "geometry") before they are allocated. Throws Error if there is no room.
  std::function<LedgerEntry(const std::string& purpose, int64_t bytes)> takeMemory;
  /// Is called on all ranks when item `item` of `of` begins. If it throws, it throws on all ranks.
  std::function<void(int64_t item, int64_t of, const std::string& text)> begin = [](int64_t, int64_t,
                                                                                    const std::string&) {};
  /// Trace lines. Filters that need them throw Error where they are null.
  Tracer* tracer = nullptr;
  FieldMaker* fieldMaker = nullptr;
  std::string tenant;  ///< of whom the memory is, in the ledger
  uint32_t turn = 0;   ///< rank 0: whose turn it is for work that is shared (Priority::tenant)
  /// Sends rays through data, together with those of all other ranks. Null on all ranks: there is none.
  Sampler* sampler = nullptr;
};

/// One evaluation of a filter on one rank. All ranks make the same collective calls in the same order, whatever
/// fails on one of them: what may fail on one rank is inside agree(). One thread uses it.
class FilterRun {
 public:
  using Inputs = std::map<std::string, std::vector<FilterSource>>;

  FilterRun(Collectives& ranks, Inputs inputs, FilterServices services)
      : ranks(ranks), inputs_(std::move(inputs)), services_(std::move(services)) {}

  Collectives& ranks;

  /// The dataset of an input that every entry has.
  const FilterSource& input(const std::string& name) const { return inputs_.at(name).at(0); }
  /// The dataset of an input that an entry may have; null if it has not.
  const FilterSource* optional(const std::string& name) const;
  /// All inputs by name.
  const Inputs& inputs() const { return inputs_; }
  /// The time of the inputs that have one; NaN if none has, or they differ.
  double time() const;

  LedgerEntry takeMemory(const std::string& purpose, int64_t bytes) {
    return services_.takeMemory(purpose, bytes);
  }
  const FilterServices& services() const { return services_; }
  /// Collective. Reports that item `item` of `of` begins.
  void begin(int64_t item, int64_t of, const std::string& text) { services_.begin(item, of, text); }

  /// Throws Error on all ranks if this program has none.
  Sampler& sampler() const;

  /// Makes a dataset of a volume or of geometry.
  std::shared_ptr<Dataset> made(std::shared_ptr<const Volume> volume,
                                std::shared_ptr<const Partitioning> partitioning, LedgerEntry memory) const;
  std::shared_ptr<Dataset> made(std::shared_ptr<const OwnedGeometry> geometry,
                                std::shared_ptr<const Partitioning> partitioning, LedgerEntry memory) const;

 private:
  const Inputs inputs_;
  const FilterServices services_;
};

/// What a filter's declaration says besides its properties.
struct FilterInfo {
  std::string name;
  int version = 1;  ///< to be raised when the same properties make other data
  std::string help;
  std::vector<FilterPort> inputs;
  std::optional<DatasetType> makes;  ///< absent: it tells numbers only
  std::string makesLike = {};  ///< the input whose type the dataset has, whatever `makes` says; empty: none
};

/// A filter of any type. Immutable; any thread may use it.
struct Filter {
  FilterSchema schema;
  /// Collective. `properties` is what FilterSchema::read returned.
  std::function<FilterResult(FilterRun& run, const std::string& properties)> run;
};

/// Collective. Evaluates a filter and says in its dataset how it was made. Throws Error on all ranks if an input is of a type that the
/// filter does not take, or if inputs are of different steps of one source.
FilterResult evaluate(const Filter& filter, FilterRun& run, const std::string& properties);

template <class T>
Schema<T> propertiesOf() {
  return {"filter " + T::info().name, T::properties()};
}

namespace detail {

/// Returns JSON whose members are sorted, so that equal values have equal texts.
std::string sortedText(const OrderedJson& properties);

template <class T>
std::string readProperties(ReadContext& context, const JsonValue& own) {
  const Schema<T> schema = propertiesOf<T>();
  T filter;
  readObject(context, own, schema, filter);
  return sortedText(writeObject(filter, schema));
}

template <class T>
FilterResult runFilter(FilterRun& run, const std::string& properties) {
  T filter;
  ReadContext context;
  context.sourceName = T::info().name;
  readObject(context, parseJson(properties, context.sourceName), propertiesOf<T>(), filter);
  return filter.run(run);
}

template <class T>
KeyInfo describedKey(const KeyRow<T>& key) {
  KeyInfo info = key.info;
  if (info.defaultText.empty() && !info.required) info.defaultText = "`" + key.write(T{}).dump() + "`";
  return info;
}

}  // namespace detail

/// Makes a Filter from its declaration.
template <class T>
std::shared_ptr<const Filter> makeFilter() {
  const FilterInfo info = T::info();
  auto filter = std::make_shared<Filter>();
  filter->schema = {info.name, info.version, info.help, info.inputs, info.makes, info.makesLike};
  for (const KeyRow<T>& key : T::properties()) filter->schema.properties.push_back(detail::describedKey(key));
  filter->schema.read = detail::readProperties<T>;
  filter->run = detail::runFilter<T>;
  return filter;
}

/// Filters by name. They are never removed. Thread safe.
class Filters final : public FilterSchemas {
 public:
  /// Throws Error if the name is taken.
  void add(std::shared_ptr<const Filter> filter);
  template <class T>
  void add() {
    add(makeFilter<T>());
  }
  const FilterSchema* find(const std::string& name) const override;
  std::vector<std::string> names() const override;
  /// Throws Error, with the known names, if there is none.
  std::shared_ptr<const Filter> get(const std::string& name) const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const Filter>> filters_;
};

/// Adds the filters that all programs have.
void addStandardFilters(Filters& filters);
/// These filters alone.
const Filters& standardFilters();

}  // namespace gxy
