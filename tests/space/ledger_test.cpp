// SPDX-License-Identifier: Apache-2.0
#include "core/space/ledger.h"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>

namespace gxy {
namespace {

TEST(Ledger, EntriesCountWhileTheyLive) {
  Ledger ledger;
  {
    LedgerEntry volume = ledger.enter("ann", "volume", 1000);
    const LedgerEntry ghosts = ledger.enter("ann", "ghosts", 100);
    const LedgerEntry other = ledger.enter("bob", "volume", 10);
    EXPECT_EQ(ledger.total(), 1110);
    EXPECT_EQ(ledger.total("ann"), 1100);
    volume.resize(500);
    EXPECT_EQ(ledger.snapshot(), (std::vector<Ledger::Line>{
                                     {"ann", "ghosts", 100}, {"ann", "volume", 500}, {"bob", "volume", 10}}));
  }
  EXPECT_EQ(ledger.total(), 0);
  EXPECT_EQ(ledger.peak(), 1110);
  EXPECT_TRUE(ledger.snapshot().empty());
}

TEST(Ledger, MovedEntriesCountOnce) {
  Ledger ledger;
  LedgerEntry a = ledger.enter("ann", "volume", 7);
  LedgerEntry b = std::move(a);
  EXPECT_EQ(ledger.total(), 7);
  b = ledger.enter("ann", "volume", 9);
  EXPECT_EQ(ledger.total(), 9);
  b = {};
  EXPECT_EQ(ledger.total(), 0);
}

TEST(Ledger, MayGoBeforeItsEntries) {
  auto ledger = std::make_unique<Ledger>();
  LedgerEntry entry = ledger->enter("ann", "volume", 7);
  ledger.reset();
  entry.resize(9);
  EXPECT_EQ(entry.bytes(), 9);
}

TEST(Ledger, TotalsAreExactUnderThreads) {
  Ledger ledger;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 1000; ++i) {
        LedgerEntry entry = ledger.enter(t % 2 ? "ann" : "bob", "rays", 64);
        entry.resize(32);
      }
    });
  }
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(ledger.total(), 0);
  EXPECT_GE(ledger.peak(), 64);
  EXPECT_LE(ledger.peak(), 4 * 64);
}

TEST(Ledger, PeaksOfAPurposeOutliveItsEntries) {
  Ledger ledger;
  {
    const LedgerEntry rays = ledger.enter("ann", "rays", 5);
    { const LedgerEntry more = rays.another(20); }
    const LedgerEntry less = rays.another(10);
    EXPECT_EQ(ledger.total(), 15);
  }
  const LedgerEntry volume = ledger.enter("ann", "volume", 3);
  EXPECT_EQ(ledger.peaks(), (std::vector<Ledger::Line>{{"ann", "rays", 25}, {"ann", "volume", 3}}));
  EXPECT_EQ(LedgerEntry().another(100).bytes(), 0);
}

TEST(ProcessBytes, GrowsByWhatIsTouched) {
  constexpr int64_t kSize = 64 << 20;
  const ProcessBytes before = processBytes();
  const auto block = std::make_unique<std::byte[]>(kSize);
  std::memset(block.get(), 1, kSize);
  const ProcessBytes after = processBytes();
  EXPECT_GE(after.resident - before.resident, kSize * 9 / 10);
  EXPECT_GE(after.peakResident, after.resident);
}

}  // namespace
}  // namespace gxy
