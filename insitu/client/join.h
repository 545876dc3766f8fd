// SPDX-License-Identifier: Apache-2.0
// How a rank of a simulation joins a stream of a server.
#pragma once
#include <string>
#include <vector>

#include "insitu/client/interrupt.h"
#include "insitu/client/options.h"
#include "insitu/plan/records.h"

namespace gxy::insitu {

/// Who joins.
struct Member {
  std::string name;  ///< of the stream
  int rank = 0, ranks = 1;
};

/// What the server answers.
struct Joined {
  uint64_t stream = 0;
  Ticket ticket{};
  struct Rank {
    std::string host;
    uint16_t port = 0;
  };
  std::vector<Rank> ranks;  ///< of the server: where they take data
};

/// Connects to the server as a client, joins the stream, and hangs up. Throws Error, with what the server says, and Closing.
Joined join(const Options& options, const Member& member, Interrupt& interrupt);

}  // namespace gxy::insitu
