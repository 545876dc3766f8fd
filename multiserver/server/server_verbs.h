// SPDX-License-Identifier: Apache-2.0
// The server's own verbs, and the search for verbs.
#pragma once
#include <string>

#include "multiserver/server/module.h"

namespace gxy {

/// Returns the server's own verb with this name ("stat" or "server.stat"), or null.
const Verb* serverVerb(const std::string& name);

/// Returns the verb that a name means in a session: the server's own, or else that of the first of the
/// session's modules that has it. `module.verb` means that module's. The result is valid as long as the
/// session. Throws Error, with a similar name, if there is none.
const Verb& resolveVerb(Session& session, const std::string& name);

/// Registers the works that the verbs need, on every rank.
void addServerWorks(ServerRank& serverRank);

}  // namespace gxy
