// SPDX-License-Identifier: Apache-2.0
// Tenants: who may use the server, and how much of it. Used on rank 0.
#pragma once
#include <array>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

namespace gxy {

/// Returns 32 bytes from the system's random source.
std::array<unsigned char, 32> randomBytes();
/// Returns 64 hexadecimal digits from the system's random source.
std::string newToken();

/// Compares tokens in a time that depends only on the length of `given`.
bool sameToken(const std::string& given, const std::string& expected);

/// Identifies tenants by token, and counts and limits what each has under way. Thread safe.
class Tenants {
 public:
  struct Identity {
    std::string tenant;
    bool administrator = false;
    bool viewOnly = false;  ///< may only look
    bool operator==(const Identity&) const = default;
  };

  /// `frames` is the number of renderings that each tenant may have in flight.
  explicit Tenants(int frames) : frames_(frames) {}

  /// Returns what is wrong with a tenant's name; empty if it is allowed.
  static std::string wrongName(const std::string& name);

  /// Adds a tenant's token. add() and admitAll() are called before clients come.
  void add(const std::string& token, Identity identity);
  /// Admits every client as an administrator, with the tenant that it names.
  void admitAll() { admitsAll_ = true; }
  bool admitsAll() const { return admitsAll_; }
  /// Returns the token that stands for an identity; empty after admitAll().
  std::string tokenOf(const Identity& identity) const;
  /// Returns the identity of a client; nothing for a wrong token. `tenant` counts only after admitAll();
  /// throws Error if it is not allowed then.
  std::optional<Identity> identify(const std::string& token, const std::string& tenant) const;

  /// A rendering that is in flight as long as this object lives. It may outlive the Tenants.
  class RenderSlot {
   public:
    RenderSlot() = default;
    RenderSlot(RenderSlot&& other) noexcept : end_(std::exchange(other.end_, nullptr)) {}
    RenderSlot& operator=(RenderSlot&& other) noexcept {
      if (end_) end_();
      end_ = std::exchange(other.end_, nullptr);
      return *this;
    }
    ~RenderSlot() {
      if (end_) end_();
    }

   private:
    friend class Tenants;
    std::function<void()> end_;
  };

  /// The memory that a rendering takes.
  struct Cost {
    int64_t bytes = 0;              ///< memory of its picture
    std::function<int64_t()> room;  ///< bytes that all the tenant's pictures in flight may take now
  };
  /// Begins a rendering. Throws Error if the tenant has as many as it may have, or there is no memory for the
  /// picture.
  RenderSlot begin(const std::string& tenant, const Cost& cost);
  /// The same, but waits instead. `check` is called about every 100 ms while it waits; its exception is
  /// passed on. Throws Error if there is no memory even without the tenant's other renderings.
  RenderSlot beginWhenFree(const std::string& tenant, const Cost& cost, const std::function<void()>& check);

  static constexpr int kAside = 128;  ///< requests Aside of a tenant that run at once, each on a thread
  /// Begins a request Aside (module.h), which ends when the result is released. Throws Error if the tenant
  /// has kAside. The result may outlive the Tenants.
  [[nodiscard]] std::shared_ptr<void> beginAside(const std::string& tenant);

  static constexpr int kLong = 4;  ///< long works (Exchanges) that run at once for a tenant
  /// Begins a long work, which ends when the result is released. Waits while the tenant has kLong. `check` is
  /// called about every 100 ms while it waits; its exception is passed on. The result may outlive the Tenants.
  [[nodiscard]] std::shared_ptr<void> beginLong(const std::string& tenant,
                                                const std::function<void()>& check);

  /// Returns, for each tenant by name: frames in flight, bytes of their pictures, frames done, and the
  /// seconds they took.
  nlohmann::json statistics() const;
  /// Returns a number for a tenant. It never changes.
  uint32_t number(const std::string& tenant);
  std::string name(uint32_t number) const;

 private:
  struct Account {
    uint32_t number = 0;
    int frames = 0, aside = 0, longWorks = 0;
    int64_t bytes = 0;
    uint64_t done = 0;
    double seconds = 0;
  };
  struct State {
    mutable std::mutex mutex;
    std::condition_variable ended;
    std::map<std::string, Account> accounts;
  };
  RenderSlot entered(const std::string& tenant, int64_t bytes);  ///< called with the lock held
  Account& account(const std::string& tenant);

  const int frames_;
  bool admitsAll_ = false;
  std::map<std::string, Identity> identities_;  ///< by token
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace gxy
