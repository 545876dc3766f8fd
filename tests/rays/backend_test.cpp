// SPDX-License-Identifier: Apache-2.0
// Which backend a program gets by name, and by `auto`.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "core/comm/error.h"
#include "core/rays/backend.h"

namespace gxy {
namespace {

class Named final : public Backend {
 public:
  explicit Named(std::string name) : name_(std::move(name)) {}
  std::string name() const override { return name_; }
  std::string device() const override { return "none"; }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene>, int,
                                         const Advance&) const override {
    return nullptr;
  }

 private:
  const std::string name_;
};

BackendRegistry::Maker sound(const std::string& name) {
  return [name](Ledger*) { return std::make_unique<Named>(name); };
}

BackendRegistry::Maker broken(const std::string& why) {
  return [why](Ledger*) -> std::unique_ptr<Backend> { throw Error(why); };
}

std::string errorOf(const BackendRegistry& registry, const std::string& name) {
  try {
    registry.make(name);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(BackendRegistry, AutoTakesTheNextWhereTheFirstCannotBeMade) {
  BackendRegistry registry;
  registry.add("gpu", broken("the device was lost"));
  registry.add("other", sound("other"), [] { return false; });
  registry.add("cpu", sound("cpu"));
  EXPECT_EQ(registry.make("auto")->name(), "cpu");
}

TEST(BackendRegistry, AutoTellsTheFirstErrorWhereNoneCanBeMade) {
  BackendRegistry registry;
  registry.add("gpu", broken("the device was lost"));
  registry.add("cpu", broken("no such processor"));
  EXPECT_EQ(errorOf(registry, "auto"), "the device was lost");
}

TEST(BackendRegistry, ANamedOneHasNoSubstitute) {
  BackendRegistry registry;
  registry.add("gpu", broken("the device was lost"));
  registry.add("cpu", sound("cpu"));
  EXPECT_EQ(errorOf(registry, "gpu"), "the device was lost");
  EXPECT_EQ(errorOf(registry, "quantum"),
            "backend \"quantum\" is not in this program; expected one of: auto, gpu, cpu");
}

}  // namespace
}  // namespace gxy
