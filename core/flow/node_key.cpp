// SPDX-License-Identifier: Apache-2.0
#include "core/flow/node_key.h"

#include <algorithm>

#include "core/flow/sha256.h"

namespace gxy::flow {
namespace {

void addNumber(Sha256& hash, uint64_t number) {
  std::array<char, 8> bytes{};
  for (size_t i = 0; i < bytes.size(); i++) bytes[i] = char(number >> (8 * i) & 0xff);
  hash.add({bytes.data(), bytes.size()});
}

// With its length, so that no two sequences of texts are written alike.
void addText(Sha256& hash, const std::string& text) {
  addNumber(hash, text.size());
  hash.add(text);
}

void addData(Sha256& hash, const DataId& data) {
  if (const auto* source = std::get_if<SourceGeneration>(&data)) {
    addNumber(hash, 1);
    addNumber(hash, source->object.value);
    addNumber(hash, source->generation);
  } else {
    addNumber(hash, 2);
    for (uint64_t word : std::get<NodeKey>(data).words) addNumber(hash, word);
  }
}

}  // namespace

std::string NodeKey::text() const {
  std::string out;
  for (uint64_t word : words)
    for (int shift = 60; shift >= 0; shift -= 4) out += "0123456789abcdef"[word >> shift & 15];
  return out;
}

NodeKey keyOf(const std::string& filter, int version, const std::string& properties,
              std::vector<KeyInput> inputs) {
  std::sort(inputs.begin(), inputs.end(),
            [](const KeyInput& a, const KeyInput& b) { return a.input < b.input; });
  Sha256 hash;
  addText(hash, "galaxy node 1");
  addText(hash, filter);
  addNumber(hash, uint64_t(version));
  addText(hash, properties);
  addNumber(hash, inputs.size());
  for (const KeyInput& input : inputs) {
    addText(hash, input.input);
    addNumber(hash, input.data.size());
    for (const DataId& data : input.data) addData(hash, data);
  }
  const Sha256::Digest digest = hash.digest();
  NodeKey key;
  for (size_t i = 0; i < 16; i++) key.words[i / 8] = key.words[i / 8] << 8 | digest[i];
  return key;
}

}  // namespace gxy::flow
