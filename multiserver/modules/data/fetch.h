// SPDX-License-Identifier: Apache-2.0
// Verb `fetch`: sends what a dataset holds to the client, as arrays.
#pragma once
#include <nlohmann/json.hpp>

#include "multiserver/server/module.h"

namespace gxy {

/// Fetches that are under way, on rank 0.
class Fetches;

/// Registers the work that gathers a dataset for `fetch`, and returns what fetchDataset() needs.
std::shared_ptr<Fetches> addFetchWork(Registration& registration);

/// Verb `fetch`, on rank 0.
nlohmann::json fetchDataset(Fetches& fetches, Request& request, protocol::Arguments arguments);

}  // namespace gxy
