// SPDX-License-Identifier: Apache-2.0
// The binary interface that Catalyst 2 looks for in libcatalyst-NAME.so: one structure. Nothing is thrown out of its functions.
#include <exception>
#include <memory>
#include <stdexcept>
#include <utility>

#include "insitu/catalyst/adaptor.h"

using namespace gxy::catalyst;

// What the functions return. Numbers from 100 on are for implementations.
enum catalyst_status { kOk = 0, kNotInitialized = 1, kConduitMissing = 7, kWrong = 100 };

namespace {

Messages messages;
// A program that ends without catalyst_finalize() leaves the stream as it is: the system ends its thread and closes its connections.
Adaptor* adaptor = nullptr;

void end() { std::unique_ptr<Adaptor>(std::exchange(adaptor, nullptr)).reset(); }

template <class Action>
catalyst_status guarded(Action action) noexcept {
  catalyst_status status = kConduitMissing;
  try {
    try {
      conduit();
      status = kWrong;
      return action();
    } catch (const std::exception& e) {
      messages.say(e.what());
    }
  } catch (...) {
    // Of Conduit's own, or there is no memory for the message.
  }
  return status;
}

Node root(const conduit_node_impl* params) {
  if (!params) throw std::runtime_error("the node is NULL");
  return Node(const_cast<conduit_node_impl*>(params), "");
}

catalyst_status initialize(const conduit_node_impl* params) {
  return guarded([&] {
    end();
    messages = {};
    adaptor = std::make_unique<Adaptor>(root(params), messages).release();
    return kOk;
  });
}

catalyst_status execute(const conduit_node_impl* params) {
  return guarded([&] {
    if (!adaptor) {
      messages.say("catalyst_execute before catalyst_initialize, or that failed");
      return kNotInitialized;
    }
    adaptor->execute(root(params));
    return kOk;
  });
}

catalyst_status finalize(const conduit_node_impl*) {
  return guarded([] {
    end();
    return kOk;
  });
}

catalyst_status about(conduit_node_impl* node) {
  return guarded([&] {
    root(node);
    conduit().nodeSetPathChar8Str(node, "catalyst/implementation", "galaxy");
    conduit().nodeSetPathChar8Str(node, "catalyst/version", GALAXY_VERSION);
    if (adaptor) adaptor->about(node);
    return kOk;
  });
}

catalyst_status results(conduit_node_impl*) { return kOk; }  // Nothing comes back so far.

}  // namespace

#pragma GCC visibility push(default)
extern "C" {

struct catalyst_impl {
  int version;
  catalyst_status (*initialize)(const conduit_node_impl*);
  catalyst_status (*execute)(const conduit_node_impl*);
  catalyst_status (*finalize)(const conduit_node_impl*);
  catalyst_status (*about)(conduit_node_impl*);
  catalyst_status (*results)(conduit_node_impl*);
};

extern const struct catalyst_impl catalyst_api_impl;
const struct catalyst_impl catalyst_api_impl = {1, initialize, execute, finalize, about, results};
}
#pragma GCC visibility pop
