// SPDX-License-Identifier: Apache-2.0
// What every session can ask the server itself, and how verbs are found.
#pragma once
#include <string>

#include "multiserver/server/module.h"

namespace gxy {

/// The server's own verb of this name ("stat" or "server.stat"), or null.
const Verb* serverVerb(const std::string& name);

/// What a session means by a verb: the server's own, else that of the first of its modules that has it; `module.verb` means
/// that module's. Valid as long as the session. Throws Error, with what is near, where there is none.
const Verb& resolveVerb(Session& session, const std::string& name);

/// Registers what the verbs need on every rank.
void addServerWorks(Node& node);

}  // namespace gxy
