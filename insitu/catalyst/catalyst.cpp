// SPDX-License-Identifier: Apache-2.0
// The binary interface that Catalyst 2 looks for in libcatalyst-NAME.so: one structure. Nothing is thrown out of its functions.
#include <exception>
#include <memory>
#include <stdexcept>
#include <utility>

#include "insitu/catalyst/adaptor.h"

using namespace gxy::catalyst;

namespace {

// What the functions return: a catalyst_status. Those from 100 on are for implementations.
enum Status { kOk = 0, kNotInitialized = 1, kConduitMissing = 7, kWrong = 100 };

Messages messages;
// A program that ends without catalyst_finalize() leaves the stream as it is: the system ends its thread and closes its connections.
Adaptor* adaptor = nullptr;

void end() { std::unique_ptr<Adaptor>(std::exchange(adaptor, nullptr)).reset(); }

template <class Action>
int guarded(Action action) noexcept {
  int status = kConduitMissing;
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

Node root(const void* params) {
  if (!params) throw std::runtime_error("the node is NULL");
  return Node(const_cast<void*>(params), "");
}

int initialize(const void* params) {
  return guarded([&] {
    end();
    messages = {};
    adaptor = std::make_unique<Adaptor>(root(params), messages).release();
    return kOk;
  });
}

int execute(const void* params) {
  return guarded([&] {
    if (!adaptor) {
      messages.say("catalyst_execute before catalyst_initialize, or that failed");
      return kNotInitialized;
    }
    adaptor->execute(root(params));
    return kOk;
  });
}

int finalize(const void*) {
  return guarded([] {
    end();
    return kOk;
  });
}

int about(void* node) {
  return guarded([&] {
    root(node);
    conduit().nodeSetPathChar8Str(node, "catalyst/implementation", "galaxy");
    conduit().nodeSetPathChar8Str(node, "catalyst/version", GALAXY_VERSION);
    if (adaptor) adaptor->about(node);
    return kOk;
  });
}

int results(void*) { return kOk; }  // Nothing comes back so far.

}  // namespace

#pragma GCC visibility push(default)
extern "C" {

struct catalyst_impl {
  int version;
  int (*initialize)(const void*);
  int (*execute)(const void*);
  int (*finalize)(const void*);
  int (*about)(void*);
  int (*results)(void*);
};

extern const struct catalyst_impl catalyst_api_impl;
const struct catalyst_impl catalyst_api_impl = {1, initialize, execute, finalize, about, results};
}
#pragma GCC visibility pop
