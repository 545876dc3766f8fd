// SPDX-License-Identifier: Apache-2.0
// What state files may say of filters: the entries of datasets that filters make.
#pragma once
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/schema.h"

namespace gxy {

/// The types of datasets that an input takes: bits of 1 << DatasetType.
constexpr unsigned bitOf(DatasetType type) { return 1u << unsigned(type); }
inline constexpr unsigned kVolumes = bitOf(DatasetType::Volume);
inline constexpr unsigned kParticles = bitOf(DatasetType::Particles);
inline constexpr unsigned kPathLines = bitOf(DatasetType::PathLines);
inline constexpr unsigned kTriangles = bitOf(DatasetType::Triangles);
/// Volumes may be unstructured, too.
inline constexpr unsigned kUnstructured = 1u << 31;

/// Names the types in words: "Particles or PathLines".
std::string namesOf(unsigned types);

/// One input of a filter.
struct FilterPort {
  enum class Count { One, Optional, Many, Any, AnyName };
  std::string name;  ///< AnyName: what messages call it; entries choose the names of these inputs
  unsigned types = kVolumes;
  std::string help;
  Count count = Count::
      One;  ///< Many: one or more datasets under one name. Any: none or more. AnyName: any number, one under each name
  bool takesMany() const { return count == Count::Many || count == Count::Any; }
  bool mayLack() const { return count == Count::Optional || count == Count::Any || count == Count::AnyName; }
};

/// What documents may say of one filter, and what is told to users. It is made from the filter's declaration
/// (core/analysis/filter.h).
struct FilterSchema {
  std::string name;
  int version = 1;  ///< another version may make other data of the same properties
  std::string help;
  std::vector<FilterPort> inputs;
  std::optional<DatasetType> makes;   ///< absent: it tells numbers and makes no dataset
  std::string makesLike{};            ///< the input whose type the dataset has; empty: `makes` says it
  std::vector<KeyInfo> properties{};  ///< its own keys
  /// Reads its own keys from an object. Returns all of them with their values as the text of a JSON object, which is the same for the
  /// same values. Throws Error with the position of what is wrong.
  std::function<std::string(ReadContext&, const JsonValue& own)> read{};

  /// Returns the type of the dataset that an entry makes, where the type of an input is known; nothing if it makes none or that is
  /// not known.
  std::optional<DatasetType> typeMadeBy(
      const DatasetSpec& entry,
      const std::function<std::optional<DatasetType>(const std::string& dataset)>& typeOf) const;
  /// What it makes, in words.
  std::string madeText() const;
  /// Returns the port of an input that an entry calls so; null if there is none.
  const FilterPort* port(const std::string& input) const;
};

/// The filters that a program knows.
class FilterSchemas {
 public:
  virtual ~FilterSchemas() = default;
  virtual const FilterSchema* find(const std::string& name) const = 0;
  virtual std::vector<std::string> names() const = 0;
};

/// The keys that all entries with a filter have.
const Schema<DatasetSpec>& filterEntrySchema();

/// Reads an entry with the key `filter`. With `context.filters`, checks it against the filter's schema; else keeps the
/// filter's own keys as they are. Throws Error with a position.
DatasetSpec readFilterEntry(const Found& item);
OrderedJson writeFilterEntry(const DatasetSpec& dataset);

/// Checks an entry's filter and its inputs against the types of the datasets that these names mean: `typeOf` returns nothing for a
/// name that it does not know. Throws Error that names the dataset, the input, and what was expected. An entry that somebody is still
/// editing may lack inputs: Missing::Allowed.
enum class Missing { Refused, Allowed };
void checkInputs(const FilterSchema& filter, const DatasetSpec& entry,
                 const std::function<std::optional<DatasetType>(const std::string& dataset)>& typeOf,
                 Missing missing = Missing::Refused);

/// Returns the inputs that an entry must have and has not, in the filter's order.
std::vector<const FilterPort*> missingInputs(const FilterSchema& filter, const DatasetSpec& entry);

/// Returns the places of the datasets that filters make, each after those it reads. Throws Error that names the
/// datasets of a cycle.
std::vector<size_t> evaluationOrder(const std::vector<DatasetSpec>& datasets);

/// Returns the reference of all filters, in Markdown.
std::string filterReference(const FilterSchemas& filters);

}  // namespace gxy
