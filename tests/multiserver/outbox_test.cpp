// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/outbox.h"

#include <gtest/gtest.h>

#include <thread>

namespace gxy {
namespace {

using protocol::MessageChannel;
using protocol::PixelHeader;
using protocol::PixelKind;

Bytes record(uint32_t window, uint64_t frame, PixelKind kind, uint32_t pass = 0, size_t bytes = 100,
             uint32_t scale = 1) {
  PixelHeader h;
  h.kind = kind;
  h.window = window;
  h.frame = frame;
  h.pass = pass;
  h.scale = scale;
  h.width = h.height = 16;
  if (kind == PixelKind::Tile) h.w = h.h = 16;
  return protocol::pixelRecord(h, Bytes(bytes));
}

std::string kindsLeft(Outbox& outbox) {
  std::string kinds;
  while (const auto frame = outbox.next()) {
    if (frame->channel != MessageChannel::Pixels) {
      kinds += "CQREPF"[int(frame->channel)];
      continue;
    }
    const PixelHeader h = protocol::pixelHeader(frame->payload);
    kinds += h.kind == PixelKind::Tile ? 't' : h.kind == PixelKind::EndOfPass ? 'p' : 'f';
    kinds += std::to_string(h.frame);
  }
  return kinds;
}

TEST(Outbox, SendsControlThenTextThenPixelsThenFiles) {
  Outbox outbox({}, [] {}, {});
  outbox.file(9, Bytes(10), [] { return false; });
  outbox.pixels(record(1, 1, PixelKind::Tile));
  outbox.event({{"event", "added"}});
  outbox.reply(1, "ok");
  outbox.control("pong 1");
  EXPECT_EQ(kindsLeft(outbox), "CERt1F");
  EXPECT_EQ(outbox.counters().queuedBytes, 0u);
}

TEST(Outbox, WakesWhoSendsForAllThatComes) {
  int woken = 0;
  Outbox outbox({}, [&] { woken++; }, {});
  outbox.control("pong 1");
  EXPECT_EQ(woken, 1);
  outbox.reply(1, "ok");
  EXPECT_EQ(woken, 2);
  outbox.event({{"event", "added"}});
  EXPECT_EQ(woken, 3);
  outbox.pixels(record(1, 1, PixelKind::Tile));
  EXPECT_EQ(woken, 4);
  outbox.file(9, Bytes(10), [] { return false; });
  EXPECT_EQ(woken, 5);
  outbox.farewell("bye");
  EXPECT_EQ(woken, 6);
}

TEST(Outbox, SendsWindowsInTurn) {
  Outbox outbox({}, [] {}, {});
  for (uint32_t window = 1; window <= 3; window++)
    for (int tile = 0; tile < 2; tile++) outbox.pixels(record(window, window, PixelKind::Tile));
  EXPECT_EQ(kindsLeft(outbox), "t1t2t3t1t2t3");
}

TEST(Outbox, SaysOnceThatItHasClosed) {
  Outbox outbox({}, [] {}, {});
  int closed = 0;
  outbox.onClose([&] { closed++; });
  outbox.farewell("bye");
  EXPECT_EQ(kindsLeft(outbox), "C");
  EXPECT_EQ(closed, 0) << "its farewell is not its end";
  outbox.close();
  outbox.close();
  EXPECT_EQ(closed, 1);
  outbox.onClose([&] { closed++; });
  EXPECT_EQ(closed, 2) << "at once where it has closed";
}

TEST(Outbox, AReplyFollowsTheFilesOfItsRequest) {
  Outbox outbox({}, [] {}, {});
  outbox.file(9, Bytes(10), [] { return false; });
  outbox.reply(9, "ok");
  EXPECT_EQ(kindsLeft(outbox), "FR");
}

TEST(Outbox, AReplyFollowsTheFilesOfItsRequestAlsoBehindThoseOfOthers) {
  Outbox outbox({}, [] {}, {});
  outbox.file(8, Bytes(10), [] { return false; });
  outbox.file(9, Bytes(10), [] { return false; });
  outbox.reply(9, "ok");
  EXPECT_EQ(kindsLeft(outbox), "FFR");
}

TEST(Outbox, ANewerFrameDropsTheTilesOfAnOlderOneButNotItsEnd) {
  Outbox outbox({}, [] {}, {});
  outbox.pixels(record(1, 1, PixelKind::Tile));
  outbox.pixels(record(1, 1, PixelKind::EndOfPass));
  outbox.pixels(record(1, 1, PixelKind::EndOfFrame));
  outbox.pixels(record(2, 1, PixelKind::Tile));
  outbox.pixels(record(1, 2, PixelKind::Tile));
  outbox.pixels(record(1, 2, PixelKind::Tile));
  EXPECT_EQ(outbox.counters().tilesDropped, 1u);
  EXPECT_EQ(kindsLeft(outbox), "f1t1t2t2");
}

TEST(Outbox, ACoarserLevelStaysWhenAFinerOneOfItsFrameComes) {
  Outbox outbox({}, [] {}, {});
  outbox.pixels(record(1, 1, PixelKind::Tile, 0, 100, 4));
  outbox.pixels(record(1, 1, PixelKind::EndOfPass, 0, 100, 4));
  outbox.pixels(record(1, 1, PixelKind::Tile));
  EXPECT_EQ(outbox.counters().tilesDropped, 0u);
  EXPECT_EQ(kindsLeft(outbox), "t1p1t1");
}

TEST(Outbox, HoldsOnePassOfAWindowForASlowReader) {
  Outbox outbox({}, [] {}, {});
  for (uint32_t pass = 0; pass < 100; pass++) {
    for (int tile = 0; tile < 4; tile++) outbox.pixels(record(1, 1, PixelKind::Tile, pass, 1000));
    outbox.pixels(record(1, 1, PixelKind::EndOfPass, pass));
  }
  EXPECT_EQ(outbox.counters().tilesDropped, 99u * 4);
  EXPECT_LT(outbox.counters().mostQueuedBytes, 2 * 4 * 1100 + 100 * 200u);
}

TEST(Outbox, SaysWhenAPassHasBeenTakenUnlessItWasDropped) {
  Outbox outbox({}, [] {}, {});
  int sent = 0;
  outbox.pixels(record(1, 1, PixelKind::Tile));
  outbox.pixels(record(1, 1, PixelKind::EndOfPass), [&] { sent++; });
  outbox.next();
  EXPECT_EQ(sent, 0) << "the tile";
  outbox.next();
  EXPECT_EQ(sent, 1);
  outbox.pixels(record(1, 2, PixelKind::Tile));
  outbox.pixels(record(1, 2, PixelKind::EndOfPass), [&] { sent++; });
  outbox.dropTiles(1);
  outbox.pixels(record(1, 3, PixelKind::Tile));
  outbox.pixels(record(1, 3, PixelKind::EndOfPass));
  EXPECT_EQ(kindsLeft(outbox), "t3p3");
  EXPECT_EQ(sent, 1);
}

TEST(Outbox, SaysWhenAPassHasBeenTakenAlsoOnceAFurtherOneHasDroppedItsTiles) {
  Outbox outbox({}, [] {}, {});
  int sent = 0;
  outbox.pixels(record(1, 1, PixelKind::Tile));
  outbox.pixels(record(1, 1, PixelKind::EndOfPass), [&] { sent++; });
  outbox.pixels(record(1, 1, PixelKind::Tile, 1));
  EXPECT_EQ(kindsLeft(outbox), "p1t1");
  EXPECT_EQ(sent, 1);
}

TEST(Outbox, RefusesTilesBeyondItsLimit) {
  Outbox outbox({.text = 1000, .files = 1000, .pixels = 5000}, [] {}, {});
  int taken = 0;
  for (uint32_t window = 1; window <= 100; window++)
    taken += outbox.pixels(record(window, 1, PixelKind::Tile, 0, 936));
  EXPECT_EQ(taken, 5);
}

TEST(Outbox, TilesThatAreDroppedLeaveTheirRoom) {
  Outbox outbox({.text = 1000, .files = 1000, .pixels = 5000}, [] {}, {});
  for (uint64_t frame = 1; frame <= 100; frame++)
    ASSERT_TRUE(outbox.pixels(record(1, frame, PixelKind::Tile, 0, 936))) << frame;
  for (uint32_t pass = 1; pass <= 100; pass++)
    ASSERT_TRUE(outbox.pixels(record(1, 100, PixelKind::Tile, pass, 936))) << pass;
  outbox.dropTiles(1);
  int taken = 0;
  for (uint32_t window = 2; window <= 100; window++)
    taken += outbox.pixels(record(window, 1, PixelKind::Tile, 0, 936));
  EXPECT_EQ(taken, 5) << "all of it";
}

TEST(Outbox, LeavesEventsOutAndSaysHowMany) {
  Outbox outbox({.text = 1000, .files = 1000, .pixels = 1000}, [] {}, {});
  outbox.reply(1, std::string(2000, 'x'));
  EXPECT_TRUE(outbox.aboveWatermark());
  EXPECT_FALSE(outbox.event({{"event", "added"}}));
  EXPECT_FALSE(outbox.event({{"event", "added"}}));
  EXPECT_TRUE(outbox.next().has_value());
  EXPECT_FALSE(outbox.aboveWatermark());
  EXPECT_TRUE(outbox.event({{"event", "dropped"}}));
  EXPECT_EQ(nlohmann::json::parse(outbox.next()->text()), (nlohmann::json{{"event", "lost"}, {"count", 2}}));
  EXPECT_EQ(nlohmann::json::parse(outbox.next()->text())["event"], "dropped");
  EXPECT_TRUE(outbox.event({{"event", "renamed"}}));
  EXPECT_EQ(nlohmann::json::parse(outbox.next()->text())["event"], "renamed") << "it is told once";
}

TEST(Outbox, EndsOfFramesMakeItCongestedUntilTheyAreTaken) {
  Outbox outbox({.text = 1000, .files = 1000, .pixels = 1000}, [] {}, {});
  for (uint64_t frame = 1; frame <= 100; frame++) outbox.pixels(record(1, frame, PixelKind::EndOfFrame));
  EXPECT_TRUE(outbox.aboveWatermark());
  while (outbox.next()) continue;
  EXPECT_FALSE(outbox.aboveWatermark());
}

TEST(Outbox, SaysOnceWhenItIsNoLongerCongested) {
  Outbox outbox({40, 1000, 1000}, [] {}, {});
  int drained = 0;
  const auto count = [&] { drained++; };
  outbox.reply(1, std::string(30, 'x'));
  EXPECT_FALSE(outbox.aboveWatermark(count));
  outbox.reply(2, std::string(30, 'x'));
  EXPECT_TRUE(outbox.aboveWatermark(count));
  outbox.next();
  EXPECT_FALSE(outbox.aboveWatermark());
  while (outbox.next()) continue;
  EXPECT_EQ(drained, 1);
}

TEST(Outbox, FilesWaitForRoomUntilCancelledOrClosed) {
  Outbox outbox({.text = 1000, .files = 100, .pixels = 1000}, [] {}, {});
  EXPECT_TRUE(outbox.file(1, Bytes(90), [] { return false; }));
  EXPECT_FALSE(outbox.file(1, Bytes(90), [] { return true; })) << "cancelled";
  std::thread waiter([&] { EXPECT_TRUE(outbox.file(1, Bytes(90), [] { return false; })); });
  EXPECT_TRUE(outbox.next().has_value());
  waiter.join();
  std::thread other([&] { EXPECT_FALSE(outbox.file(1, Bytes(90), [] { return false; })); });
  outbox.close();
  other.join();
}

TEST(Outbox, AFileMayBeLongerThanWhatMayWaitIfItIsAlone) {
  Outbox outbox({.text = 1000, .files = 100, .pixels = 1000}, [] {}, {});
  EXPECT_TRUE(outbox.file(1, Bytes(1000), [] { return true; }));
  EXPECT_FALSE(outbox.file(1, Bytes(1), [] { return true; }));
}

TEST(Outbox, AFarewellFollowsRepliesAndNothingFollowsIt) {
  Outbox outbox({}, [] {}, {});
  outbox.pixels(record(1, 1, PixelKind::Tile));
  outbox.farewell("bye");
  outbox.reply(1, "ok");
  EXPECT_EQ(kindsLeft(outbox), "RC");
}

TEST(Outbox, EntersWhatWaitsInTheLedger) {
  Ledger ledger;
  Outbox outbox(
      {}, [] {}, ledger.enter("server", "to be sent", 0));
  outbox.reply(1, std::string(500, 'x'));
  EXPECT_EQ(ledger.total("server"), 500);
  outbox.chargeTo(ledger.enter("ann", "to be sent", 0));
  EXPECT_EQ(ledger.total("ann"), 500);
  EXPECT_EQ(ledger.total(), 500);
  outbox.close();
  EXPECT_EQ(ledger.total(), 0);
}

}  // namespace
}  // namespace gxy
