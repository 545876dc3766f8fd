// SPDX-License-Identifier: Apache-2.0
// Messages between the program and its workers. Only for the sources of these.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "tools/gxybench/worker.h"

namespace gxy::bench {

/// Stands before a worker's JSON; other lines of its output are passed on.
inline constexpr const char* kLineMark = "gxybench-measured ";

/// The prefix of the files with the picture of setting i: float RGBA and double depth, as they are in memory.
inline std::string pictureFile(const Job& job, size_t i) { return job.pictures + std::to_string(i); }

nlohmann::json toJson(const Job& job);
Job jobOf(const nlohmann::json& json);

nlohmann::json toJson(const Row& row);
Row rowOf(const nlohmann::json& json);

}  // namespace gxy::bench
