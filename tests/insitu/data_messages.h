// SPDX-License-Identifier: Apache-2.0
// What a rank of a simulation says to a server, put together by hand.
#pragma once
#include <string>
#include <utility>

#include "insitu/plan/description.h"
#include "insitu/plan/records.h"
#include "multiserver/protocol/wire_message.h"

namespace gxy::test {

inline protocol::WireMessage message(protocol::MessageChannel channel, Bytes payload) {
  return {channel, 0, std::move(payload)};
}

/// The ticket that insitu.join has given.
inline insitu::Ticket ticketOf(const std::string& text) {
  insitu::Ticket ticket;
  for (size_t i = 0; i < ticket.size(); i++)
    ticket[i] = uint8_t(std::stoi(text.substr(2 * i, 2), nullptr, 16));
  return ticket;
}

/// One rank with all of a field t of 8^3 floats.
inline insitu::Description described() {
  insitu::Mesh grid;
  grid.name = "grid";
  grid.grid.points = {8, 8, 8};
  grid.fields = {{"t", ScalarType::Float32, 1}};
  return {1, {grid}, {{{{{0, 0, 0}, {8, 8, 8}}}, {}}}};
}

}  // namespace gxy::test
