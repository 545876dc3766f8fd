// SPDX-License-Identifier: Apache-2.0
// The interface for modules. docs/modules.md explains one step by step.
//
// A module is a shared library that defines one GALAXY_MODULE. It is loaded on every rank. Its body runs once
// on each, and registers verbs (used on rank 0, which serves clients), works and filters (used on every rank).
#pragma once
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <typeindex>
#include <utility>
#include <vector>

#include "multiserver/protocol/statement.h"
#include "multiserver/server/document_reader.h"
#include "multiserver/server/server_rank.h"
#include "multiserver/server/session.h"

namespace gxy {

/// This number changes with every change of the headers that modules include. A module built for another
/// number is refused.
inline constexpr uint32_t kModuleAbi = 13;

/// When a request runs. InTurn: after the earlier requests of its session and before the later ones. Aside:
/// it starts in its turn, but later requests do not wait for its end; for long work. AtOnce: immediately, on
/// the thread that serves all sockets; only for short verbs of the server itself.
enum class Order { InTurn, Aside, AtOnce };

/// Whether a verb changes anything that others can see, or that outlives the session: data, graphs, files, simulations. A
/// session with a view-only token may only use verbs that look; its windows are its own.
enum class Effect { Changes, Looks };

struct Verb {
  std::string name;
  std::string arguments, help;  ///< texts for users: "NAME [GENERATION]", "Waits for a dataset."
  Order order = Order::InTurn;
  /// Returns the object that the reply has after `ok`, or null for none. If the object has a member `text`,
  /// programs show that to users. To reply `error: ...`, it throws; an Error has a message for the user. It
  /// runs on a thread of its own and may wait, unless its order is AtOnce.
  std::function<nlohmann::json(Request&)> action;
  Effect effect = Effect::Changes;

  /// Returns the arguments of a request. The request must outlive the result.
  protocol::Arguments argumentsOf(const Request& request) const {
    return {request.arguments(), name + (arguments.empty() ? "" : " " + arguments)};
  }
};

/// A type that defines an action of a Work: its name, how it runs, its parameters as members (converted to
/// and from JSON, for instance by NLOHMANN_DEFINE_TYPE_INTRUSIVE), and the function action().
template <class W>
concept TypedWork = requires(const W& work, ServerRank& serverRank, nlohmann::json& json,
                             const Work::Call& call) {
  { W::name } -> std::convertible_to<std::string>;
  { W::runs } -> std::convertible_to<Work::Runs>;
  to_json(json, work);
  { work.action(serverRank, call) } -> std::convertible_to<nlohmann::json>;
};

/// Collects the verbs, works and filters that a module's body registers. They take effect only if the module loads on
/// all ranks.
class Registration {
 public:
  explicit Registration(ServerRank& serverRank) : serverRank_(serverRank) {}
  ServerRank& serverRank() const { return serverRank_; }

  void verb(Verb verb) { verbs_.push_back(std::move(verb)); }

  /// Registers a work. Its name should begin with the module's name: "example.range".
  void work(std::string name, Work::Action action, Work::Runs runs = Work::Runs::Short) {
    works_.push_back({std::move(name), std::move(action), runs});
  }
  template <TypedWork W>
  void work() {
    work(
        W::name,
        [&serverRank = serverRank_](const Work::Call& call) -> nlohmann::json {
          return call.parameters.get<W>().action(serverRank, call);
        },
        W::runs);
  }

  /// Registers a filter, which core/analysis/filter.h explains.
  template <class F>
  void filter() {
    filters_.push_back(makeFilter<F>());
  }

  /// Keeps an object of the module alive as long as the server runs.
  void keep(std::shared_ptr<void> what) { kept_.push_back(std::move(what)); }

  /// What modules have in common on this rank, and keep: the T of a module that is loaded already, else what `make` makes, which
  /// may register works here. T is a type of the server's own libraries.
  template <class T>
  std::shared_ptr<T> shared(const std::function<std::shared_ptr<T>()>& make) {
    return std::static_pointer_cast<T>(
        sharedOf(typeid(T), [&]() -> std::shared_ptr<void> { return make(); }));
  }

 private:
  friend class Modules;
  std::shared_ptr<void> sharedOf(std::type_index type, const std::function<std::shared_ptr<void>()>& make);
  struct NamedWork {
    std::string name;
    Work::Action action;
    Work::Runs runs;
  };
  ServerRank& serverRank_;
  std::vector<Verb> verbs_;
  std::vector<NamedWork> works_;
  std::vector<std::shared_ptr<const Filter>> filters_;
  std::vector<std::shared_ptr<void>> kept_;
};

/// Sends a typed work to all ranks, waits, and returns the results by rank. Throws Error if it failed on any rank.
template <TypedWork W>
std::vector<nlohmann::json> callAll(ServerRank& serverRank, const W& work) {
  nlohmann::json parameters;
  to_json(parameters, work);
  return serverRank.callAll(W::name, parameters);
}

}  // namespace gxy

/// Begins the body of a module: `GALAXY_MODULE(registration) { registration.verb({...}); }`.
#define GALAXY_MODULE(registration)                                        \
  extern "C" uint32_t galaxy_module_abi() { return gxy::kModuleAbi; }      \
  extern "C" void galaxy_module_register(gxy::Registration& registration); \
  extern "C" void galaxy_module_register(gxy::Registration& registration)
