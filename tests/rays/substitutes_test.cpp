// SPDX-License-Identifier: Apache-2.0
// What `auto` does where a backend fails after it was made: the next takes its place.
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/comm/error.h"
#include "core/rays/backend.h"
#include "core/space/ledger.h"

namespace gxy {
namespace {

/// What a fake device does, and what was asked of it.
struct Device {
  std::string full;       ///< not empty: makeScene throws it
  std::string fullFrame;  ///< not empty: makeFrame throws it
  std::string failing;    ///< not empty: all answers are this error
  bool lost = false;
  int backends = 0;
  std::atomic<int> scenes = 0, spawned = 0, traced = 0;
  size_t bytes = 100;
  std::shared_ptr<const DeviceFrame> frame;  ///< the last that was made
};

class FakeScene final : public DeviceScene {
 public:
  explicit FakeScene(Device& device) : device_(device) {}
  std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame&) const override {
    if (!device_.fullFrame.empty()) throw Error(device_.fullFrame);
    return device_.frame = std::make_shared<DeviceFrame>();
  }
  void spawn(const DeviceFrame& frame, const SpawnTile&, Done done) const override {
    device_.spawned++;
    answer(frame, done);
  }
  void trace(const DeviceFrame& frame, int, bool, RayList, Done done) const override {
    device_.traced++;
    answer(frame, done);
  }
  size_t bytes() const override { return device_.bytes; }
  std::vector<SharedBytes> sharedBytes() const override { return {{&device_, 1000}}; }

 private:
  void answer(const DeviceFrame& frame, const Done& done) const {
    EXPECT_EQ(&frame, device_.frame.get());
    TraceResult result;
    result.error = device_.failing;
    done(std::move(result));
  }
  Device& device_;
};

class FakeBackend final : public Backend {
 public:
  FakeBackend(std::string name, Device& device) : name_(std::move(name)), device_(device) {
    device_.backends++;
  }
  std::string name() const override { return name_; }
  std::string device() const override { return "device of " + name_; }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene>, int rank,
                                         const Advance& advance) const override {
    EXPECT_EQ(rank, 3);
    advance(0.5);
    if (!device_.full.empty()) throw Error(device_.full);
    device_.scenes++;
    return std::make_unique<FakeScene>(device_);
  }
  bool lost() const override { return device_.lost; }

 private:
  const std::string name_;
  Device& device_;
};

/// A program with two backends, and what it logs.
class Substitutes : public testing::Test {
 protected:
  Substitutes() : before_(spdlog::default_logger()) {
    auto logger =
        std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(said_));
    logger->set_pattern("%l: %v");
    spdlog::set_default_logger(std::move(logger));
    registry_.add("gpu", [this](Ledger*) { return std::make_unique<FakeBackend>("gpu", gpu_); });
    registry_.add("cpu", [this](Ledger*) { return std::make_unique<FakeBackend>("cpu", cpu_); });
  }
  ~Substitutes() override { spdlog::set_default_logger(before_); }

  static std::unique_ptr<DeviceScene> sceneOn(const Backend& backend) { return backend.makeScene({}, 3); }
  /// One tile of a frame that is made for it; its error.
  static std::string errorOfFrame(const DeviceScene& scene) {
    const auto frame = scene.makeFrame({});
    return errorOfTile(scene, *frame);
  }
  static std::string errorOfTile(const DeviceScene& scene, const DeviceFrame& frame) {
    std::string error = "no answer";
    scene.spawn(frame, {0, 0, 1, 1, 0}, [&](TraceResult result) { error = result.error; });
    return error;
  }
  static std::string errorOfPacket(const DeviceScene& scene, const DeviceFrame& frame) {
    std::string error = "no answer";
    scene.trace(frame, 0, true, {}, [&](TraceResult result) { error = result.error; });
    return error;
  }
  template <class Call>
  static std::string thrownBy(const Call& call) {
    try {
      call();
    } catch (const Error& e) {
      return e.what();
    }
    return "nothing";
  }

  Device gpu_, cpu_;
  BackendRegistry registry_;
  std::ostringstream said_;

 private:
  const std::shared_ptr<spdlog::logger> before_;
};

TEST_F(Substitutes, AreNotMadeBeforeTheyAreNeeded) {
  const auto backend = registry_.make("auto");
  const auto scene = sceneOn(*backend);
  EXPECT_EQ(errorOfFrame(*scene), "");
  EXPECT_EQ(backend->name(), "gpu");
  EXPECT_EQ(backend->device(), "device of gpu");
  EXPECT_EQ(cpu_.backends, 0);
  EXPECT_EQ(said_.str(), "");
}

TEST_F(Substitutes, TakeASceneForWhichThereIsNoRoom) {
  const auto backend = registry_.make("auto");
  gpu_.full = "no room for volumes";
  const auto large = sceneOn(*backend);
  EXPECT_EQ(said_.str(),
            "warning: backend gpu fails with a scene: no room for volumes; cpu takes its place\n");
  gpu_.full = "";
  const auto small = sceneOn(*backend);
  EXPECT_EQ(errorOfFrame(*large), "");
  EXPECT_EQ(cpu_.spawned, 1);
  EXPECT_EQ(errorOfFrame(*small), "");
  EXPECT_EQ(gpu_.spawned, 1);
}

TEST_F(Substitutes, TakeTheFramesAfterOneThatFailedOfItsSceneAlone) {
  const auto backend = registry_.make("auto");
  const auto scene = sceneOn(*backend), other = sceneOn(*backend);
  const auto underWay = scene->makeFrame({});
  const auto onGpu = gpu_.frame;
  gpu_.failing = "it took too long";
  EXPECT_EQ(errorOfPacket(*scene, *underWay), "it took too long");
  const std::string warning =
      "warning: backend gpu fails with a scene: it took too long; cpu takes its place\n";
  EXPECT_EQ(said_.str(), warning);
  EXPECT_EQ(cpu_.scenes, 0) << "nobody has asked for a frame";
  EXPECT_EQ(errorOfFrame(*scene), "");
  EXPECT_EQ(errorOfFrame(*scene), "");
  EXPECT_EQ(cpu_.scenes, 1);
  EXPECT_EQ(cpu_.spawned, 2);
  gpu_.frame = onGpu;
  EXPECT_EQ(errorOfPacket(*scene, *underWay), "it took too long") << "a frame stays where it was made";
  EXPECT_EQ(cpu_.traced, 0);
  EXPECT_EQ(said_.str(), warning);
  gpu_.failing = "";
  EXPECT_EQ(errorOfFrame(*other), "");
  EXPECT_EQ(cpu_.scenes, 1);
}

TEST_F(Substitutes, TakeAllScenesOfALostDevice) {
  const auto backend = registry_.make("auto");
  const auto first = sceneOn(*backend), second = sceneOn(*backend);
  gpu_.failing = "gone", gpu_.lost = true;
  EXPECT_EQ(errorOfFrame(*first), "") << "it is known to be lost when a frame is made";
  EXPECT_EQ(errorOfFrame(*second), "");
  const auto third = sceneOn(*backend);
  EXPECT_EQ(errorOfFrame(*third), "");
  EXPECT_EQ(gpu_.scenes, 2);
  EXPECT_EQ(gpu_.spawned, 0);
  EXPECT_EQ(cpu_.scenes, 3);
  EXPECT_EQ(cpu_.backends, 1);
  EXPECT_EQ(backend->name(), "cpu");
  EXPECT_EQ(said_.str(), "warning: backend gpu is lost; cpu takes its place\n");
}

TEST_F(Substitutes, OfALostDeviceAreToldOfOnce) {
  const auto backend = registry_.make("auto");
  const auto first = sceneOn(*backend), second = sceneOn(*backend);
  gpu_.failing = "gone", gpu_.lost = true;
  for (const DeviceScene* scene : {first.get(), second.get()}) {
    gpu_.lost = false;
    const auto frame = scene->makeFrame({});
    gpu_.lost = true;
    EXPECT_EQ(errorOfTile(*scene, *frame), "gone");
  }
  EXPECT_EQ(errorOfFrame(*first), "");
  EXPECT_EQ(errorOfFrame(*second), "");
  EXPECT_EQ(said_.str(), "warning: backend gpu is lost: gone; cpu takes its place\n");
}

TEST_F(Substitutes, TakeAFrameForWhichThereIsNoRoom) {
  const auto scene = sceneOn(*registry_.make("auto"));
  gpu_.fullFrame = "no room for a frame";
  EXPECT_EQ(errorOfFrame(*scene), "");
  EXPECT_EQ(cpu_.spawned, 1);
  EXPECT_EQ(said_.str(),
            "warning: backend gpu fails with a scene: no room for a frame; cpu takes its place\n");
}

// By whatever is thrown, an Error too.
TEST_F(Substitutes, TakeNothingThatHasBeenCancelled) {
  const auto backend = registry_.make("auto");
  const auto cancel = [](double) { throw Error("cancelled"); };
  EXPECT_EQ(thrownBy([&] { backend->makeScene({}, 3, cancel); }), "cancelled");
  EXPECT_EQ(cpu_.backends, 0);
  EXPECT_EQ(said_.str(), "");
  gpu_.full = "no room";
  int asked = 0;
  const auto cancelLater = [&](double) {
    if (++asked == 2) throw Error("cancelled later");
  };
  EXPECT_EQ(thrownBy([&] { backend->makeScene({}, 3, cancelLater); }), "cancelled later");
}

TEST_F(Substitutes, HaveTheFlagsOfTheirFrames) {
  const auto scene = sceneOn(*registry_.make("auto"));
  const auto frame = scene->makeFrame({});
  for (const bool urgent : {true, false}) {
    frame->setUrgent(urgent);
    EXPECT_EQ(frame->urgent(), urgent);
    EXPECT_EQ(gpu_.frame->urgent(), urgent);
  }
  EXPECT_FALSE(gpu_.frame->cancelled());
  frame->cancel();
  EXPECT_TRUE(frame->cancelled());
  EXPECT_TRUE(gpu_.frame->cancelled());
}

TEST_F(Substitutes, AreInTheLedgerAsTheDevicesAndNotInTheScenesBytes) {
  Ledger ledger;
  cpu_.bytes = 20;
  {
    const auto backend = registry_.make("auto", &ledger);
    auto first = sceneOn(*backend), second = sceneOn(*backend);
    EXPECT_EQ(ledger.total(), 0) << "what scenes tell of themselves is entered by others";
    gpu_.lost = true;
    errorOfFrame(*first);
    EXPECT_EQ(ledger.total("device"), 1020);
    errorOfFrame(*second);
    EXPECT_EQ(ledger.total("device"), 1040) << "what they share is entered once";
    EXPECT_EQ(first->bytes(), 100u);
    EXPECT_EQ(first->sharedBytes().at(0).what, &gpu_);
    const auto third = sceneOn(*backend);
    EXPECT_EQ(third->bytes(), 20u);
    EXPECT_EQ(ledger.total("device"), 1040);
  }
  EXPECT_EQ(ledger.total(), 0);
}

TEST_F(Substitutes, ThatCannotBeMadeLeaveWhatThereWas) {
  BackendRegistry registry;
  registry.add("gpu", [this](Ledger*) { return std::make_unique<FakeBackend>("gpu", gpu_); });
  registry.add("cpu", [](Ledger*) -> std::unique_ptr<Backend> { throw Error("no such processor"); });
  registry.add("tpu", {}, [] { return false; });
  const auto backend = registry.make("auto");
  const auto scene = sceneOn(*backend);
  gpu_.failing = "it took too long";
  EXPECT_EQ(errorOfFrame(*scene), "it took too long");
  EXPECT_EQ(errorOfFrame(*scene), "it took too long");
  gpu_.failing = "";
  EXPECT_EQ(errorOfFrame(*scene), "");
  EXPECT_EQ(said_.str(),
            "warning: backend gpu fails with a scene: it took too long; cpu takes its place\n"
            "warning: backend cpu cannot be used: no such processor\n");
  gpu_.full = "no room";
  EXPECT_EQ(thrownBy([&] { sceneOn(*backend); }), "no room");
  gpu_.lost = true;
  EXPECT_EQ(thrownBy([&] { sceneOn(*backend); }),
            "backend gpu is lost, and there is no other to take its place");
}

TEST_F(Substitutes, ThatFailInTheirTurnFailAsIfTheyWereAlone) {
  const auto scene = sceneOn(*registry_.make("auto"));
  gpu_.failing = "gone", cpu_.failing = "too hot";
  EXPECT_EQ(errorOfFrame(*scene), "gone");
  EXPECT_EQ(errorOfFrame(*scene), "too hot");
  EXPECT_EQ(errorOfFrame(*scene), "too hot");
  cpu_.failing = "";
  EXPECT_EQ(errorOfFrame(*scene), "");
  gpu_.full = "no room", cpu_.full = "no room either";
  EXPECT_EQ(thrownBy([&] { sceneOn(*registry_.make("auto")); }), "no room");
}

TEST_F(Substitutes, AreForAutoOnly) {
  const auto backend = registry_.make("gpu");
  const auto scene = sceneOn(*backend);
  gpu_.failing = "gone", gpu_.lost = true;
  EXPECT_EQ(errorOfFrame(*scene), "gone");
  EXPECT_EQ(errorOfFrame(*scene), "gone");
  gpu_.full = "no room";
  EXPECT_EQ(thrownBy([&] { sceneOn(*backend); }), "no room");
  EXPECT_EQ(backend->name(), "gpu");
  EXPECT_EQ(cpu_.backends, 0);
  EXPECT_EQ(said_.str(), "");
}

TEST_F(Substitutes, AreMadeOnceForFramesOfSeveralThreads) {
  const auto scene = sceneOn(*registry_.make("auto"));
  gpu_.failing = "gone";
  EXPECT_EQ(errorOfFrame(*scene), "gone");
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; i++) threads.emplace_back([&] { EXPECT_NE(scene->makeFrame({}), nullptr); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(cpu_.scenes, 1);
}

}  // namespace
}  // namespace gxy
