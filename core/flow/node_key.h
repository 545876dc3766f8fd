// SPDX-License-Identifier: Apache-2.0
// The name of what a filter makes: the same for the same filter, properties and inputs.
#pragma once
#include <array>
#include <compare>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/space/key.h"
#include "core/space/observers.h"

namespace gxy::flow {

/// The key of a node: the first 128 bits of the SHA-256 of what keyOf() writes down. An output is valid exactly if it carries the key
/// of its node. Different contents have different keys, also where somebody looks for two that have the same.
struct NodeKey {
  std::array<uint64_t, 2> words{};

  auto operator<=>(const NodeKey&) const = default;
  std::string text() const;  ///< 32 hexadecimal digits
};

/// One generation of an object of the data space. Keys of objects are never used twice, so this means the same data for ever.
struct SourceGeneration {
  Key object;
  Generation generation = 0;
  auto operator<=>(const SourceGeneration&) const = default;
};

/// What an input is: a generation of a source, or the output with this key.
using DataId = std::variant<SourceGeneration, NodeKey>;

/// What one input of a filter is given: one or several, in the document's order.
struct KeyInput {
  std::string input;
  std::vector<DataId> data;
  bool operator==(const KeyInput&) const = default;
};

/// Returns the key of a node. `properties`: the filter's own keys as canonical JSON, which is the same for the same values. The order of
/// `inputs` has no meaning; the order of the data of one input has.
///
/// It hashes, each text with its length before it and all numbers as 8 bytes, little-endian: the text "galaxy node 1", filter, version,
/// properties, the number of inputs, and for each input by name: name, number of data, and for each of them 1, object and generation, or
/// 2 and the key.
NodeKey keyOf(const std::string& filter, int version, const std::string& properties,
              std::vector<KeyInput> inputs);

}  // namespace gxy::flow
