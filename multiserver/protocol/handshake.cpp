// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/handshake.h"

#include "core/comm/error.h"
#include "core/scene/json_text.h"
#include "multiserver/protocol/json.h"

namespace gxy::protocol {

namespace {

// Returns a member of an object, which must have the type of `fallback`; returns `fallback` if there is none.
template <class T>
T member(const nlohmann::json& object, const char* key, T fallback, const char* what) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  try {
    return found->get<T>();
  } catch (const nlohmann::json::exception&) {
    throw Error(std::string(what) + ": `" + key + "` is " + found->type_name() + ", expected another type");
  }
}

}  // namespace

std::optional<std::string_view> afterWord(std::string_view text, std::string_view word) {
  if (!text.starts_with(word)) return std::nullopt;
  text.remove_prefix(word.size());
  if (text.empty()) return text;
  if (text.front() != ' ') return std::nullopt;
  return text.substr(1);
}

std::string helloText(const Hello& hello) {
  nlohmann::json object{{"token", hello.token}, {"client", hello.client}, {"tenant", hello.tenant}};
  if (!hello.ticket.empty()) object["ticket"] = hello.ticket;
  return "hello " + dump(object);
}

std::string asLogged(std::string_view text) { return inQuotes(text.substr(0, 80)); }

Hello parseHello(std::string_view text) {
  const auto json = afterWord(text, "hello");
  if (!json) throw Error("handshake: expected `hello JSON`");
  const nlohmann::json object = parseObject(*json, "hello");
  Hello hello;
  hello.token = member(object, "token", std::string(), "hello");
  hello.ticket = member(object, "ticket", std::string(), "hello");
  hello.client = member(object, "client", std::string("unnamed"), "hello");
  hello.tenant = member(object, "tenant", hello.tenant, "hello");
  if (hello.client.size() > 255 || hello.tenant.empty() || hello.tenant.size() > 255)
    throw Error("hello: `client` or `tenant` is too long or empty, expected 1 to 255 bytes");
  if (hasControls(hello.client) || hasControls(hello.tenant))  // Other users see them.
    throw Error("hello: `client` or `tenant` has control characters, expected text without them");
  return hello;
}

std::string welcomeText(const Welcome& w) {
  nlohmann::json object{{"server", w.server},
                        {"session", w.session},
                        {"tenant", w.tenant},
                        {"administrator", w.administrator},
                        {"view only", w.viewOnly},
                        {"ranks", w.ranks},
                        {"limits",
                         {{"request bytes", w.limits.requestBytes},
                          {"requests", w.limits.requests},
                          {"windows", w.limits.windows},
                          {"pixels", w.limits.pixels},
                          {"clients", w.limits.clients}}}};
  if (!w.token.empty()) object["token"] = w.token;
  return "welcome " + dump(object);
}

Welcome parseWelcome(std::string_view text) {
  const auto json = afterWord(text, "welcome");
  if (!json) throw Error("handshake: expected `welcome JSON`");
  const nlohmann::json object = parseObject(*json, "welcome");
  Welcome w;
  w.server = member(object, "server", std::string(), "welcome");
  w.session = member(object, "session", uint64_t(0), "welcome");
  w.tenant = member(object, "tenant", std::string(), "welcome");
  w.administrator = member(object, "administrator", false, "welcome");
  w.viewOnly = member(object, "view only", false, "welcome");
  w.ranks = member(object, "ranks", 0, "welcome");
  w.token = member(object, "token", std::string(), "welcome");
  const auto limits = member(object, "limits", nlohmann::json::object(), "welcome");
  w.limits.requestBytes = member(limits, "request bytes", w.limits.requestBytes, "welcome");
  w.limits.requests = member(limits, "requests", w.limits.requests, "welcome");
  w.limits.windows = member(limits, "windows", w.limits.windows, "welcome");
  w.limits.pixels = member(limits, "pixels", w.limits.pixels, "welcome");
  w.limits.clients = member(limits, "clients", w.limits.clients, "welcome");
  return w;
}

}  // namespace gxy::protocol
