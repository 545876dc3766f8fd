// SPDX-License-Identifier: Apache-2.0
// What every collective must bring, whatever carries it: run by all ranks at once.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/comm/collective.h"
#include "core/comm/error.h"
#include "core/comm/random.h"

namespace gxy {

/// Bytes that only (key, from, to) gives, of a length up to `longest`.
inline Bytes gift(uint64_t key, int from, int to, uint64_t longest = 1000) {
  Random random(key * 1000003 + uint64_t(from) * 1009 + uint64_t(to));
  Bytes bytes(random.below(longest));
  for (auto& byte : bytes) byte = std::byte(random.next());
  return bytes;
}

/// One request: each kind of collective twice under one key.
inline void checkCollectives(Collective& collective, Transport& transport, uint64_t key) {
  const int ranks = transport.size(), me = transport.rank();
  for (int round = 0; round < 2; ++round) {
    const auto gathered = collective.allGather(key, gift(key + round, me, 0));
    ASSERT_EQ(gathered.size(), size_t(ranks));
    for (int r = 0; r < ranks; ++r) ASSERT_EQ(gathered[r], gift(key + round, r, 0));

    const Bytes folded =
        collective.allReduce(key, gift(key + round, me, 0), [](Bytes& into, const Bytes& other) {
          into.resize(std::max(into.size(), other.size()));
          for (size_t i = 0; i < other.size(); ++i) into[i] ^= other[i];
        });
    Bytes expected;
    for (int r = 0; r < ranks; ++r) {
      const Bytes theirs = gift(key + round, r, 0);
      expected.resize(std::max(expected.size(), theirs.size()));
      for (size_t i = 0; i < theirs.size(); ++i) expected[i] ^= theirs[i];
    }
    ASSERT_EQ(folded, expected);

    // Every third pair has nothing to send.
    const auto isEmpty = [&](int from, int to) { return (uint64_t(from + 2 * to) + key) % 3 == 0; };
    std::vector<Bytes> mine;
    for (int r = 0; r < ranks; ++r) mine.push_back(isEmpty(me, r) ? Bytes() : gift(key + round, me, r));
    const auto exchanged = collective.allToAll(key, std::move(mine));
    ASSERT_EQ(exchanged.size(), size_t(ranks));
    for (int r = 0; r < ranks; ++r)
      ASSERT_EQ(exchanged[r], isEmpty(r, me) ? Bytes() : gift(key + round, r, me));

    for (int root = 0; root < ranks; ++root)
      ASSERT_EQ(collective.broadcast(key, root, me == root ? gift(key, root, round) : Bytes{}),
                gift(key, root, round));
    collective.barrier(key);
  }
  collective.finish(key);
}

/// The last rank and, if there is one, rank 1 fail: all ranks get both reasons.
inline void checkAgreement(Collective& collective, Transport& transport, uint64_t key) {
  const int last = transport.size() - 1, me = transport.rank();
  EXPECT_NO_THROW(collective.agree(key, {}));
  std::optional<std::string> error;
  if (me == last || me == 1) error = "cannot read part " + std::to_string(me);
  std::string message;
  try {
    collective.agree(key, error);
  } catch (const Error& thrown) {
    message = thrown.what();
  }
  std::string expected;
  if (last > 1) expected = "rank 1: cannot read part 1; ";
  expected += "rank " + std::to_string(last) + ": cannot read part " + std::to_string(last);
  EXPECT_EQ(message, expected);
}

}  // namespace gxy
