// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/join.h"

#include <nlohmann/json.hpp>

#include "core/comm/error.h"
#include "insitu/client/wire_socket.h"
#include "multiserver/protocol/handshake.h"
#include "multiserver/protocol/json.h"
#include "multiserver/protocol/run_files.h"

namespace gxy::insitu {

using nlohmann::json;
using protocol::MessageChannel;

namespace {

constexpr std::chrono::seconds kJoinPatience(10);

// The connection of a client, for a few requests.
class Requests {
 public:
  Requests(const Options& options, const Member& member, Interrupt& interrupt)
      : interrupt_(interrupt),
        end_(Interrupt::Clock::now() + kJoinPatience),
        socket_(options.host, options.port, protocol::Purpose::Client, interrupt, end_) {
    protocol::Hello hello;
    hello.client = "simulation " + member.name;
    hello.tenant = options.tenant;
    std::string noToken;
    hello.token = token(options, noToken);
    socket_.send(protocol::textMessage(MessageChannel::Control, 0, protocol::helloText(hello)));
    const auto answer = socket_.expect(interrupt_, end_);
    if (const auto reason = protocol::afterWord(answer.text(), "bye"))
      throw Error("the server refuses: " + std::string(*reason) +
                  (noToken.empty() ? "" : " (none was sent: " + noToken + ")"));
    protocol::parseWelcome(answer.text());
  }

  json request(const std::string& statement) {
    socket_.send(protocol::textMessage(MessageChannel::Request, ++id_, statement));
    for (;;) {
      const auto message = socket_.expect(interrupt_, end_);
      if (message.channel == MessageChannel::Control) answerPing(message.text());
      if (message.channel != MessageChannel::Reply || message.id != id_) continue;
      if (const auto value = protocol::afterWord(message.text(), "ok"))
        return value->empty() ? json() : protocol::parseAnswer(*value, "reply");
      throw Error("the server refuses: " + std::string(message.text()));
    }
  }

 private:
  // As the client library does: a token that lies on this machine goes to no other machine unasked.
  std::string token(const Options& options, std::string& whyNone) const {
    if (!options.token.empty() || !options.asksForToken) return options.token;
    if (options.tokenFile == "-") return {};
    if (!options.tokenFile.empty()) return protocol::readToken(options.tokenFile);
    if (!socket_.isLoopback())
      throw Error(
          "host " + options.host +
          " is another machine, and everything goes there as clear text, the token, too: expected the "
          "option \"token-file\" with a copy of the server's token");
    try {
      return protocol::readServerToken(options.port);
    } catch (const Error& e) {
      whyNone = e.what();
      return {};
    }
  }
  void answerPing(std::string_view text) {
    if (const auto number = protocol::afterWord(text, "ping"))
      socket_.send(protocol::textMessage(MessageChannel::Control, 0, "pong " + std::string(*number)));
    else if (const auto why = protocol::afterWord(text, "bye"))
      throw Error("the server ends the connection: " + std::string(*why));
  }

  Interrupt& interrupt_;
  const Interrupt::Clock::time_point end_;
  WireSocket socket_;
  uint32_t id_ = 0;
};

Ticket ticketOf(const std::string& hexadecimal) {
  Ticket ticket{};
  if (hexadecimal.size() != 2 * ticket.size())
    throw Error("reply to insitu.join: the ticket has a wrong size");
  for (size_t i = 0; i < ticket.size(); i++)
    ticket[i] = uint8_t(std::stoi(hexadecimal.substr(2 * i, 2), nullptr, 16));
  return ticket;
}

}  // namespace

Joined join(const Options& options, const Member& member, Interrupt& interrupt) {
  Requests requests(options, member, interrupt);
  requests.request("load insitu");
  json what{{"name", member.name},
            {"rank", member.rank},
            {"ranks", member.ranks},
            {"scope", options.scope},
            {"partition", json::parse(options.partition)},
            {"steerable", json::parse(options.steerable)}};
  if (member.rank == 0) what["triggers"] = json::parse(options.triggers);
  const json reply = requests.request("insitu.join " + what.dump());
  try {
    Joined joined{reply.at("stream").get<uint64_t>(), ticketOf(reply.at("ticket").get<std::string>()), {}};
    for (const json& rank : reply.at("ranks")) {
      const auto host = rank.at("host").get<std::string>();
      joined.ranks.push_back({host.empty() ? options.host : host, rank.at("port").get<uint16_t>()});
    }
    return joined;
  } catch (const std::exception& e) {
    throw Error(std::string("reply to insitu.join: ") + e.what());
  }
}

}  // namespace gxy::insitu
