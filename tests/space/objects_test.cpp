// SPDX-License-Identifier: Apache-2.0
#include "core/space/objects.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "core/comm/error.h"

namespace gxy {
namespace {

using namespace std::chrono_literals;
using Kind = ObjectEvent::Kind;

/// One rank's objects, and all events that they caused.
struct Space {
  Observers observers;
  Objects objects{observers};
  std::vector<ObjectEvent> events;
  Observers::Subscription all =
      observers.subscribe({}, [this](const ObjectEvent& e) { events.push_back(e); });

  bool update(Key key, Generation generation) {
    if (!objects.reserve(key)) return false;
    objects.stage(key, makePayload<int>(int(generation)));
    objects.commit(key, generation);
    return true;
  }
};

constexpr Key kKey{7};

TEST(Payload, AWrongTypeIsAClearError) {
  const Payload p = makePayload<std::string>("text");
  EXPECT_EQ(*p.get<std::string>(), "text");
  try {
    p.get<int>();
    FAIL() << "an error was expected";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("basic_string"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("expected a int"), std::string::npos);
  }
  EXPECT_THROW(Payload().get<int>(), Error);
}

TEST(Objects, APinKeepsItsGenerationThroughUpdates) {
  Space s;
  s.objects.add(kKey, makePayload<int>(1));
  const Pin pin = s.objects.pin(kKey);
  ASSERT_TRUE(s.update(kKey, 2));
  EXPECT_EQ(*pin.get<int>(), 1);
  EXPECT_EQ(pin.generation(), 1u);
  EXPECT_EQ(*s.objects.pin(kKey).get<int>(), 2);
  EXPECT_EQ(*s.objects.pin(kKey, 1).get<int>(), 1);
}

TEST(Objects, AStepIsSkippedAndReportedWhileBothBuffersAreTaken) {
  Space s;
  s.objects.add(kKey, makePayload<int>(1));
  Pin pin = s.objects.pin(kKey);
  ASSERT_TRUE(s.update(kKey, 2));
  EXPECT_FALSE(s.update(kKey, 3));
  EXPECT_EQ(*s.objects.pin(kKey).get<int>(), 2);
  pin.release();
  EXPECT_TRUE(s.update(kKey, 4));
  EXPECT_EQ(s.events, (std::vector<ObjectEvent>{{Kind::Added, kKey, 1},
                                                {Kind::Updated, kKey, 2},
                                                {Kind::Wanted, kKey, 1},
                                                {Kind::Skipped, kKey, 2},
                                                {Kind::Updated, kKey, 4}}));
}

TEST(Objects, WhoeverLetsGoWhenAskedMakesRoom) {
  Space s;
  s.objects.add(kKey, makePayload<int>(1));
  Pin pin = s.objects.pin(kKey);
  const auto asked = s.observers.subscribe(kKey, [&](const ObjectEvent& event) {
    if (event.kind == Kind::Wanted && event.generation == pin.generation()) pin.release();
  });
  ASSERT_TRUE(s.update(kKey, 2));
  EXPECT_TRUE(s.update(kKey, 3));
  EXPECT_EQ(*s.objects.pin(kKey).get<int>(), 3);
}

TEST(Objects, AWaitingPublisherGoesOnWhenThePinGoes) {
  Space s;
  s.objects.add(kKey, makePayload<int>(1), {60s});
  Pin pin = s.objects.pin(kKey);
  ASSERT_TRUE(s.update(kKey, 2));
  std::thread frame([&] { pin.release(); });
  EXPECT_TRUE(s.update(kKey, 3));
  frame.join();
  EXPECT_EQ(*s.objects.pin(kKey).get<int>(), 3);
}

TEST(Objects, AWaitEndsAtItsTimeOut) {
  Space s;
  s.objects.add(kKey, makePayload<int>(1), {5ms});
  const Pin pin = s.objects.pin(kKey);
  ASSERT_TRUE(s.update(kKey, 2));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(s.objects.reserve(kKey));
  EXPECT_GE(std::chrono::steady_clock::now() - start, 5ms);
}

TEST(Objects, ThereAreNeverThreeBuffers) {
  Space s;
  const auto alive = std::make_shared<std::atomic<int>>(0);
  struct Counted {
    std::shared_ptr<std::atomic<int>> alive;
    explicit Counted(std::shared_ptr<std::atomic<int>> a) : alive(std::move(a)) { ++*alive; }
    ~Counted() { --*alive; }
  };
  s.objects.add(kKey, makePayload<Counted>(alive));
  for (Generation g = 2; g < 10; ++g) {
    ASSERT_TRUE(s.objects.reserve(kKey));
    EXPECT_EQ(*alive, 1);
    EXPECT_FALSE(s.objects.reserve(kKey));
    s.objects.stage(kKey, makePayload<Counted>(alive));
    s.objects.commit(kKey, g);
    EXPECT_EQ(*alive, 2);
  }
  s.objects.drop(kKey);
  EXPECT_EQ(*alive, 0);
}

TEST(Objects, AnAbandonedStepLeavesNothing) {
  Space s;
  s.objects.add(kKey, makePayload<int>(1));
  ASSERT_TRUE(s.objects.reserve(kKey));
  s.objects.stage(kKey, makePayload<int>(2));
  s.objects.abandon(kKey);
  EXPECT_EQ(*s.objects.pin(kKey).get<int>(), 1);
  EXPECT_TRUE(s.update(kKey, 3));
}

TEST(Objects, CallsOutOfOrderAreRefused) {
  Space s;
  EXPECT_THROW(s.objects.add(Key{}, makePayload<int>(1)), Error);
  EXPECT_THROW(s.objects.pin(kKey), Error);
  EXPECT_THROW(s.objects.reserve(kKey), Error);
  EXPECT_THROW(s.objects.drop(kKey), Error);
  s.objects.add(kKey, makePayload<int>(1));
  EXPECT_THROW(s.objects.add(kKey, makePayload<int>(1)), Error);
  EXPECT_THROW(s.objects.stage(kKey, makePayload<int>(2)), Error);
  EXPECT_THROW(s.objects.commit(kKey, 2), Error);
  EXPECT_THROW(s.objects.pin(kKey, 2), Error);
  ASSERT_TRUE(s.objects.reserve(kKey));
  EXPECT_THROW(s.objects.stage(kKey, Payload()), Error);
  s.objects.stage(kKey, makePayload<int>(2));
  EXPECT_THROW(s.objects.stage(kKey, makePayload<int>(2)), Error);
  EXPECT_THROW(s.objects.commit(kKey, 1), Error);
  EXPECT_NO_THROW(s.objects.commit(kKey, 2));
}

TEST(Objects, PinsOutliveTheObjectAndTheSpace) {
  Pin pin;
  {
    Space s;
    s.objects.add(kKey, makePayload<int>(1));
    pin = s.objects.pin(kKey);
    s.objects.drop(kKey);
    EXPECT_FALSE(s.objects.contains(kKey));
    EXPECT_EQ(s.events.back(), (ObjectEvent{Kind::Dropped, kKey, 1}));
  }
  EXPECT_EQ(*pin.get<int>(), 1);
}

TEST(Objects, ADropEndsAWaitWithAnError) {
  Space s;
  s.objects.add(kKey, makePayload<int>(1), {60s});
  const Pin pin = s.objects.pin(kKey);
  ASSERT_TRUE(s.update(kKey, 2));
  std::thread dropper([&] { s.objects.drop(kKey); });
  EXPECT_THROW(s.objects.reserve(kKey), Error);
  dropper.join();
}

TEST(Objects, FramesNeverSeeAMixOfStepsUnderThreads) {
  Observers observers;
  Objects objects(observers);
  objects.add(kKey, makePayload<int>(1), {60s});
  std::atomic<bool> done = false;
  std::atomic<int> wrong = 0;
  std::vector<std::thread> frames;
  for (int t = 0; t < 3; ++t) {
    frames.emplace_back([&] {
      while (!done) {
        const Pin pin = objects.pin(kKey);
        if (Generation(*pin.get<int>()) != pin.generation()) ++wrong;
      }
    });
  }
  for (Generation g = 2; g <= 300; ++g) {
    ASSERT_TRUE(objects.reserve(kKey));
    objects.stage(kKey, makePayload<int>(int(g)));
    objects.commit(kKey, g);
  }
  done = true;
  for (std::thread& t : frames) t.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(objects.pin(kKey).generation(), 300u);
}

TEST(Observers, HearOfTheirObjectUntilTheyEnd) {
  Observers observers;
  int one = 0, all = 0;
  auto a = observers.subscribe(kKey, [&](const ObjectEvent&) { ++one; });
  const auto b = observers.subscribe({}, [&](const ObjectEvent&) { ++all; });
  observers.notify({Kind::Updated, kKey, 2});
  observers.notify({Kind::Updated, Key{8}, 2});
  a.end();
  observers.notify({Kind::Updated, kKey, 3});
  EXPECT_EQ(one, 1);
  EXPECT_EQ(all, 3);
}

TEST(Observers, CallbacksMayUseTheSpaceAndEndThemselves) {
  Observers observers;
  Objects objects(observers);
  int calls = 0;
  Observers::Subscription self;
  self = observers.subscribe({}, [&](const ObjectEvent& e) {
    ++calls;
    if (e.kind == Kind::Added && e.key == kKey) objects.add(Key{8}, makePayload<int>(1));  // notifies again
    if (e.key == Key{8}) self.end();
  });
  objects.add(kKey, makePayload<int>(1));
  objects.drop(kKey);
  EXPECT_EQ(calls, 2);
  EXPECT_TRUE(objects.contains(Key{8}));
}

TEST(Observers, NoCallbackRunsAfterItsSubscriptionEnded) {
  Observers observers;
  std::atomic<bool> done = false;
  std::thread notifier([&] {
    while (!done) {
      observers.notify({Kind::Updated, kKey, 2});
      std::this_thread::yield();
    }
  });
  std::atomic<int> late = 0;
  for (int i = 0; i < 200; ++i) {
    std::atomic<bool> ended = false;
    auto s = observers.subscribe(kKey, [&](const ObjectEvent&) { late += ended ? 1 : 0; });
    std::this_thread::yield();
    s.end();
    ended = true;
  }
  done = true;
  notifier.join();
  EXPECT_EQ(late, 0);
}

}  // namespace
}  // namespace gxy
