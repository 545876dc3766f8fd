// SPDX-License-Identifier: Apache-2.0
// Who may use the server, and how much of it. Rank 0.
#pragma once
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

/// 64 hexadecimal digits from the system's random source.
std::string newToken();

/// Compares in a time that depends on the length of `given` only.
bool sameToken(const std::string& given, const std::string& expected);

/// Tenants by token, and what each has under way. Thread safe.
class Tenants {
 public:
  struct Identity {
    std::string tenant;
    bool administrator = false;
  };

  /// `frames`: renderings that each tenant may have in flight.
  explicit Tenants(int frames) : frames_(frames) {}

  /// Empty where a tenant may be called so, else what is wrong.
  static std::string wrongName(const std::string& name);

  /// These two before clients come.
  void add(const std::string& token, Identity identity);
  /// Every client is welcome, as an administrator and whatever tenant it names.
  void admitAll() { admitsAll_ = true; }
  /// Nothing for a wrong token. Throws Error where a client that is welcome as any tenant names none that may be.
  std::optional<Identity> identify(const std::string& token, const std::string& tenant) const;

  /// A rendering in flight, until destroyed. May outlive the Tenants.
  class Frame {
   public:
    Frame() = default;
    Frame(Frame&& other) noexcept : end_(std::exchange(other.end_, nullptr)) {}
    Frame& operator=(Frame&& other) noexcept {
      if (end_) end_();
      end_ = std::exchange(other.end_, nullptr);
      return *this;
    }
    ~Frame() {
      if (end_) end_();
    }

   private:
    friend class Tenants;
    std::function<void()> end_;
  };

  /// What a rendering takes.
  struct Cost {
    int64_t bytes = 0;              ///< of its picture
    std::function<int64_t()> room;  ///< bytes that pictures of the tenant in flight may take now, together
  };
  /// Throws Error when the tenant has as many as it may have.
  Frame begin(const std::string& tenant, const Cost& cost);
  /// Waits for room instead; throws Error where there would be none without its other renderings, and what `check` throws,
  /// which is called now and then.
  Frame beginWhenFree(const std::string& tenant, const Cost& cost, const std::function<void()>& check);

  static constexpr int kAside = 128;  ///< long requests that run at once for a tenant; each holds a thread
  /// One of these, until let go. Throws Error when the tenant has as many as it may have. The same lifetime.
  [[nodiscard]] std::shared_ptr<void> beginAside(const std::string& tenant);

  static constexpr int kLong = 4;  ///< long works (Exchanges) that run at once for a tenant
  /// One of these, until let go. Waits where the tenant has as many as it may have; throws what `check` throws, which is called
  /// now and then. The same lifetime.
  [[nodiscard]] std::shared_ptr<void> beginLong(const std::string& tenant,
                                                const std::function<void()>& check);

  /// By name: frames in flight and done, bytes of their pictures, seconds they took.
  nlohmann::json statistics() const;
  /// A number for a tenant that stays the same.
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
  Frame entered(const std::string& tenant, int64_t bytes);  ///< with the lock held
  Account& account(const std::string& tenant);

  const int frames_;
  bool admitsAll_ = false;
  std::map<std::string, Identity> identities_;  ///< by token
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace gxy
