// SPDX-License-Identifier: Apache-2.0
// What the tests of core/io share: a folder that goes away, sample patterns, ranks on threads, and a mutator
// of texts.
#pragma once
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "core/comm/collectives.h"
#include "core/comm/error.h"
#include "core/io/volume_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/thread_ranks.h"

namespace gxy::testing {

using gxy::test::TemporaryFolder;
using gxy::test::ThreadRanks;

/// Bytes that differ from sample to sample, and are finite as floats.
inline std::vector<std::byte> pattern(int64_t samples, ScalarType type) {
  std::vector<std::byte> bytes(size_t(samples) * bytesOf(type));
  withType(type, [&](auto zero) {
    for (int64_t i = 0; i < samples; ++i) {
      const auto value = decltype(zero)((i * 7919) % 251 - (std::is_signed_v<decltype(zero)> ? 125 : 0));
      std::memcpy(bytes.data() + size_t(i) * sizeof value, &value, sizeof value);
    }
  });
  return bytes;
}

/// One rank whose part is to end when it has been asked so often.
struct EndsAt : Collectives {
  explicit EndsAt(int most) : most(most) {}
  int rank() const override { return 0; }
  int size() const override { return 1; }
  std::vector<Bytes> allGather(Bytes mine) override { return {std::move(mine)}; }
  std::vector<Bytes> allToAll(std::vector<Bytes> perRank) override { return perRank; }
  void check() const override {
    if (++asked == most) throw Error("cancelled");
  }
  const int most;
  mutable int asked = 0;
};

/// Keeps the warnings about thousands of damaged texts off the terminal while it lives.
class QuietLog {
 public:
  QuietLog() { spdlog::set_level(spdlog::level::off); }
  ~QuietLog() { spdlog::set_level(spdlog::level::info); }
};

/// A damaged copy of a text: truncated, bytes changed, pieces doubled or removed, numbers replaced by absurd
/// ones.
inline std::string mutated(const std::string& text, std::mt19937& random) {
  static const char* absurd[] = {"-1",
                                 "0",
                                 "1e999",
                                 "nan",
                                 "-inf",
                                 "99999999999999999999",
                                 "9223372036854775807",
                                 "1.5",
                                 "\"\"",
                                 "null",
                                 "{}",
                                 "[]",
                                 "true",
                                 "-9223372036854775808",
                                 "",
                                 "\xff\xfe"};
  const auto below = [&](size_t n) { return n ? size_t(random() % n) : 0; };
  std::string out = text;
  for (size_t changes = 1 + below(3); changes > 0; --changes) {
    const size_t at = below(out.size());
    switch (random() % 5) {
      case 0:
        out.resize(at);
        break;
      case 1:
        if (!out.empty()) out[at] = char(random());
        break;
      case 2:
        out.erase(at, 1 + below(12));
        break;
      case 3:
        out.insert(at, out.substr(below(out.size()), below(20)));
        break;
      default: {
        const size_t digit = out.find_first_of("0123456789", at);
        if (digit == std::string::npos) break;
        const size_t end = out.find_first_not_of("0123456789.eE+-", digit);
        out.replace(digit, (end == std::string::npos ? out.size() : end) - digit,
                    absurd[below(std::size(absurd))]);
      }
    }
  }
  return out;
}

}  // namespace gxy::testing
