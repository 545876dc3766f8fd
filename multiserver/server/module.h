// SPDX-License-Identifier: Apache-2.0
// What a module is written against; docs/modules.md walks through one.
//
// A module is a shared library that defines one GALAXY_MODULE. It is loaded on every rank, its body is run there once, and
// registers verbs (used on rank 0, where clients are) and works (used on every rank).
#pragma once
#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "multiserver/protocol/statement.h"
#include "multiserver/server/document_reader.h"
#include "multiserver/server/node.h"
#include "multiserver/server/session.h"

namespace gxy {

/// Changes with every change of what modules see. A module built for another is refused.
inline constexpr uint32_t kModuleAbi = 5;

/// When a request runs: after the earlier ones of its session and before the later ones; in its turn, but the later ones
/// do not wait for its end (long work); at once, on the thread that serves all sockets (the server's own short ones only).
enum class Order { InTurn, Aside, AtOnce };

struct Verb {
  std::string name;
  std::string arguments, help;  ///< for people: "NAME [GENERATION]", "Waits for a dataset."
  Order order = Order::InTurn;
  /// Returns what the reply holds after `ok`, an object or null (nothing); a member `text` is what people are shown. Throws
  /// (gxy::Error: a message for the user) to answer `error: ...`. Runs on a thread of its own and may wait.
  std::function<nlohmann::json(Request&)> action;

  /// The arguments of a request, to be taken one by one.
  protocol::Arguments argumentsOf(const Request& request) const {
    return {request.arguments(), name + (arguments.empty() ? "" : " " + arguments)};
  }
};

/// An action on the objects of a rank, as a type: its name, when it runs, its parameters (to and from JSON, for instance by
/// NLOHMANN_DEFINE_TYPE_INTRUSIVE), and what it does.
template <class W>
concept TypedWork = requires(const W& work, Node& node, nlohmann::json& json, const Work::Call& call) {
  { W::name } -> std::convertible_to<std::string>;
  { W::runs } -> std::convertible_to<Work::Runs>;
  to_json(json, work);
  { work.action(node, call) } -> std::convertible_to<nlohmann::json>;
};

/// What a module's body registers. Nothing of it counts until it has succeeded on all ranks.
class Registration {
 public:
  explicit Registration(Node& node) : node_(node) {}
  Node& node() const { return node_; }

  void verb(Verb verb) { verbs_.push_back(std::move(verb)); }

  /// A work by its name, which should begin with the module's: "example.range".
  void work(std::string name, Work::Action action, Work::Runs runs = Work::Runs::Short) {
    works_.push_back({std::move(name), std::move(action), runs});
  }
  template <TypedWork W>
  void work() {
    work(
        W::name,
        [&node = node_](const Work::Call& call) -> nlohmann::json {
          return call.parameters.get<W>().action(node, call);
        },
        W::runs);
  }

  /// Keeps what the module needs for as long as the server runs.
  void keep(std::shared_ptr<void> what) { kept_.push_back(std::move(what)); }

 private:
  friend class Modules;
  struct NamedWork {
    std::string name;
    Work::Action action;
    Work::Runs runs;
  };
  Node& node_;
  std::vector<Verb> verbs_;
  std::vector<NamedWork> works_;
  std::vector<std::shared_ptr<void>> kept_;
};

/// Sends a typed work to all ranks and waits for its results, by rank. Throws Error when it failed on any.
template <TypedWork W>
std::vector<nlohmann::json> callAll(Node& node, const W& work) {
  nlohmann::json parameters;
  to_json(parameters, work);
  return node.callAll(W::name, parameters);
}

}  // namespace gxy

/// Begins the body of a module: `GALAXY_MODULE(registration) { registration.verb({...}); }`.
#define GALAXY_MODULE(registration)                                        \
  extern "C" uint32_t galaxy_module_abi() { return gxy::kModuleAbi; }      \
  extern "C" void galaxy_module_register(gxy::Registration& registration); \
  extern "C" void galaxy_module_register(gxy::Registration& registration)
