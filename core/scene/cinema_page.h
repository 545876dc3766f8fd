// SPDX-License-Identifier: Apache-2.0
// The page that browses a Cinema database.
#pragma once
#include <string>

#include "core/scene/cinema_table.h"

namespace gxy {

/// Returns a page of HTML, to be kept as index.html beside the database's data.csv. It has the table, its style and its script in
/// itself, and needs nothing else but the pictures, which it finds by their relative names; so it works from a folder, without a
/// server and without a network. It has a slider for each parameter. `title` is what the page calls the database.
std::string cinemaPage(const CinemaTable& table, const std::string& title);

}  // namespace gxy
